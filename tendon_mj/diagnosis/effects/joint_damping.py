"""Damping of a joint."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_joints

EFFECT = Effect(
    identifier="joint_damping",
    name="damping of a joint",
    equation="torque = … − d q̇",
    looks_like="the joint trails in fast motion",
    source="MuJoCo, joint damping",
    candidates=on_joints(Knob("damping", "N m s/rad or N s/m", 0.0, 1e4, 0.002)),
)
