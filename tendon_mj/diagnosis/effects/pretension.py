"""Pretension of the tendon."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_sheaths

EFFECT = Effect(
    identifier="pretension",
    name="pretension of the tendon",
    equation="T_0",
    looks_like="all tensions too high or too low by much the same",
    source="Kaneko, Wada, Maekawa & Tanie 1991, section 2.1",
    candidates=on_sheaths(Knob("pretension", "N", 0.1, 5.0, 0.05, share=True)),
    kind="parameter",
)
