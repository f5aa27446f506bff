"""Friction that the tension does not change."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_sheaths

EFFECT = Effect(
    identifier="constant_friction",
    name="friction that the tension does not change",
    equation="T_high = T_low e^{μφ} + F_c",
    looks_like="a loop as wide at low tension as at high",
    source="Kaneko, Wada, Maekawa & Tanie 1991, section 2.3",
    candidates=on_sheaths(Knob("constant_friction", "N", 0.0, 50.0, 0.3)),
)
