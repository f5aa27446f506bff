"""A spring in a joint."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_joints

EFFECT = Effect(
    identifier="joint_stiffness",
    name="a spring in a joint",
    equation="torque = … − k (q − q_ref)",
    looks_like="the joint moves less than it should, in proportion to its angle",
    source="MuJoCo, joint stiffness",
    candidates=on_joints(Knob("stiffness", "N m/rad or N/m", 0.0, 1e6, 0.002)),
)
