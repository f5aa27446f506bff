"""Friction that changes with the tendon's place."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_sheaths

EFFECT = Effect(
    identifier="position_dependent_friction",
    name="friction that changes with the tendon's place",
    equation="μ (1 + γ u), u the tendon drawn in",
    looks_like="the loop is wider at one end of the stroke than tension explains",
    source="a worn or kinked stretch of tendon",
    candidates=on_sheaths(Knob("friction_gradient", "1/m", -2e3, 2e3, 30.0)),
)
