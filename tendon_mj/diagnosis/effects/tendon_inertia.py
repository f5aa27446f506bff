"""Mass of the tendon."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_sheaths

EFFECT = Effect(
    identifier="tendon_inertia",
    name="mass of the tendon",
    equation="T_left − T_right = … + m dv/dt",
    looks_like="input tension runs ahead of the output in fast motion, as acceleration",
    source="Kaneko, Wada, Maekawa & Tanie 1991, section 2.2",
    candidates=on_sheaths(Knob("tendon_mass", "kg", 0.0, 20.0, 0.1)),
)
