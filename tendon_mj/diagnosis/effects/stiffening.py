"""A tendon that stiffens as it stretches."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_sheaths

EFFECT = Effect(
    identifier="stiffening",
    name="a tendon that stiffens as it stretches",
    equation="T = EA ε (1 + κ ε)",
    looks_like="branches are curved: steeper at high tension",
    source="ropes bed in: Costello 1997, Theory of Wire Rope",
    candidates=on_sheaths(Knob("stiffening", "-", 0.0, 5e3, 20.0)),
)
