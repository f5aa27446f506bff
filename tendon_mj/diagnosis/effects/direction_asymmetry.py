"""Friction that differs between pulling and loosening."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_sheaths

EFFECT = Effect(
    identifier="direction_asymmetry",
    name="friction that differs between pulling and loosening",
    equation="μ (1 + α) pulling, μ (1 − α) loosening",
    looks_like="one branch of the loop is off, the other less or the other way",
    source="an assumption of ours: a worn or plaited tendon has a grain",
    candidates=on_sheaths(Knob("direction_asymmetry", "-", -0.9, 0.9, 0.05)),
)
