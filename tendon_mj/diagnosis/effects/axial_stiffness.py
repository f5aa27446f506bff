"""Stiffness of the tendon."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_sheaths

EFFECT = Effect(
    identifier="axial_stiffness",
    name="stiffness of the tendon",
    equation="EA",
    looks_like="slopes of all branches too steep or too flat",
    source="Kaneko, Wada, Maekawa & Tanie 1991, eq. (5)",
    candidates=on_sheaths(Knob("axial_stiffness", "N", 0.1, 10.0, 0.05, share=True)),
    kind="parameter",
)
