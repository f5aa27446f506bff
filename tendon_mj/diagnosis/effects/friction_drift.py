"""Friction that changes with time."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_sheaths

EFFECT = Effect(
    identifier="friction_drift",
    name="friction that changes with time",
    equation="μ (1 + β t)",
    looks_like="loops widen or narrow from cycle to cycle",
    source="running-in, lubricant and temperature",
    candidates=on_sheaths(Knob("friction_drift", "1/s", -0.2, 1.0, 0.01)),
)
