"""Effects of joints, bodies and gravity."""

from __future__ import annotations

from typing import Final

from tendon_mj.lab.diagnosis.effects.binding import (
    ParameterSpecification,
    on_armatures,
    on_bodies,
    on_gravity,
    on_joints,
    on_springs,
)
from tendon_mj.lab.diagnosis.effects.effect import Effect

_G: Final = 10.0  # however a rig is turned, its weight along an axis is no more [m/s²]

JOINTS: Final = (
    Effect(
        identifier="joint_damping",
        name="damping of a joint",
        equation="torque = … − d q̇",
        signature="the joint trails in fast motion",
        source="MuJoCo, joint damping",
        next_experiment="the same motion of the joint at three speeds",
        binding=on_joints(ParameterSpecification("damping", "N m s/rad or N s/m", 0.0, 1e4, 0.002)),
    ),
    Effect(
        identifier="joint_friction",
        name="dry friction of a joint",
        equation="torque = … − F sgn q̇",
        signature="the joint stands still after reversals, by the same torque at any tension",
        source="MuJoCo, joint frictionloss",
        next_experiment="slow reversals of the joint with the tendon at its lowest tension",
        binding=on_joints(ParameterSpecification("frictionloss", "N m or N", 0.0, 1e3, 0.001)),
    ),
    Effect(
        identifier="joint_stiffness",
        name="a spring in a joint",
        equation="torque = … − k (q − q_ref)",
        signature="the joint moves less than it should, in proportion to its angle",
        source="MuJoCo, joint stiffness",
        next_experiment="the joint held at several angles for seconds each",
        binding=on_joints(ParameterSpecification("stiffness", "N m/rad or N/m", 0.0, 1e6, 0.002)),
    ),
    Effect(
        identifier="springref",
        name="rest position of a joint's spring",
        equation="torque = … − k (q − q_ref)",
        signature="a constant force or torque on the joint",
        source="MuJoCo, joint springref",
        next_experiment="the joint at rest with nothing that pulls",
        binding=on_springs(ParameterSpecification("springref", "rad or m", -6.3, 6.3, 1e-3)),
        kind="parameter",
    ),
    Effect(
        identifier="joint_spring",
        name="spring of a joint, its stiffness and its rest position",
        equation="torque = … − k (q − q_ref)",
        signature="the joint moves too much or too little, and yet starts where it should",
        source="MuJoCo, joint stiffness and springref",
        next_experiment="the joint held at several angles for seconds each",
        # The torque in the reference pose often balances a pretension: it is kept, k is wrong.
        binding=on_springs(
            ParameterSpecification("stiffness", "N m/rad or N/m", 0.02, 50.0, 0.05, relative=True),
            ParameterSpecification(
                "springref", "rad or m", -4.0, 6.0, 0.02, relative=True, times="stiffness"
            ),
        ),
        kind="parameter",
    ),
    Effect(
        identifier="armature",
        name="inertia of a motor, reflected to its joint",
        equation="torque = … − I q̈",
        signature="a lag that grows with the square of the frequency, at any load",
        source="MuJoCo, joint armature",
        next_experiment="fast motion of the joint at two frequencies",
        binding=on_armatures(ParameterSpecification("armature", "kg m² or kg", 0.0, 1e3, 1e-4)),
        kind="parameter",
    ),
    Effect(
        identifier="mass",
        name="mass of a body",
        equation="force = … − m q̈ + m g",
        signature="force in proportion to acceleration, and weight in proportion to it",
        source="MuJoCo, body mass",
        next_experiment="the body on scales, or fast motion at two frequencies",
        binding=on_bodies(ParameterSpecification("mass", "kg", 0.01, 100.0, 0.05, relative=True)),
        kind="parameter",
    ),
    Effect(
        identifier="gravity_load",
        name="weight that the model does not carry",
        equation="force = … + m g",
        signature="an offset of tension that changes with posture",
        source="MuJoCo, option gravity",
        next_experiment="the same motion with the rig turned by 90° and by 180°",
        binding=on_gravity(
            *(ParameterSpecification(axis, "m/s²", -_G, _G, 1.0) for axis in "xyz"),
        ),
    ),
)
