"""Dry friction of a joint."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_joints

EFFECT = Effect(
    identifier="joint_friction",
    name="dry friction of a joint",
    equation="torque = … − F sgn q̇",
    looks_like="the joint stands still after reversals, by the same torque at any tension",
    source="MuJoCo, joint frictionloss",
    candidates=on_joints(Knob("frictionloss", "N m or N", 0.0, 1e3, 0.001)),
)
