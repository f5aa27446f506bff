"""Effects of joints, bodies, gravity, actuators and sensors."""

from __future__ import annotations

from typing import Final

from tendon_mj.lab.diagnosis.effects.binding import ParameterSpecification as Spec
from tendon_mj.lab.diagnosis.effects.binding import (
    armatures,
    bodies,
    drawn_plays,
    drives,
    drives_on_joints,
    gears,
    motors,
    on,
    on_gravity,
    on_inputs,
    on_joints,
    on_pulleys,
    on_sensors,
    springs,
    together,
)
from tendon_mj.lab.diagnosis.effects.effect import Effect
from tendon_mj.lab.replay import RANGE_WIDTH

_G: Final = 10.0  # however a rig is turned, its weight along an axis is at most this [m/s²]

_TURNED: Final = (
    "Record the same motion with the rig turned by 90°: a spring turns with it, weight does not."
)
_AT_THE_DRIVE: Final = (
    "Measure the tension at the drive by a load cell: the gear's friction is not in it, the"
    " sheath's is."
)
_STRAIGHTENED: Final = (
    "Record the same moves with the sheath straighter: its friction shrinks, the gear's does not."
)


def _width(parameter: str) -> Spec:
    """Width of a play."""
    return Spec(parameter, "rad or m", 0.0, 0.5, 5e-4, larger=(5e-3, 2e-2, 8e-2))


JOINT_EFFECTS: Final = (
    Effect(
        identifier="joint_damping",
        name="damping of a joint",
        equation="torque = … − d q̇",
        signature="the joint trails in fast motion",
        source="MuJoCo, joint damping",
        next_experiment="the same motion of the joint at three speeds",
        in_motion=True,
        look_at="the bearings of the joint",
        tell_apart={
            "kv": (
                "Measure the servo's force: what a joint damps it has to supply, its own rate gain"
                " not."
            )
        },
        binding=on_joints(Spec("damping", "N m s/rad or N s/m", 0.0, 1e4, 0.002)),
    ),
    Effect(
        identifier="joint_friction",
        name="dry friction of a joint",
        equation="torque = … − F sgn q̇",
        signature="the joint stands still after reversals, by the same torque at any tension",
        source="MuJoCo, joint frictionloss",
        next_experiment="slow reversals of the joint with the tendon at its lowest tension",
        look_at="the bearings of the joint",
        binding=on_joints(Spec("frictionloss", "N m or N", 0.0, 1e3, 0.001)),
    ),
    Effect(
        identifier="output_play",
        name="play between the pulley and its joint",
        equation="|q − p| ≤ b/2, p of the pulley that the cables turn",
        signature=(
            "the joint stands still or falls through where its load changes sides, and not where"
            " the drive reverses"
        ),
        source="Nordin & Gutman 2002, Automatica 38(10), a survey of backlash",
        next_experiment="the joint moved by hand from stop to stop, the drive held",
        look_at="the pulley on its joint, and the gear or linkage behind the cable",
        tell_apart={
            "backlash": (
                "Hold the drive and move the joint by hand: play behind the cable moves no drum."
            )
        },
        binding=together(
            on_pulleys(_width("output_play")),
            on(drawn_plays, _width(RANGE_WIDTH)),
        ),
    ),
    Effect(
        identifier="drum_play",
        name="play between a motor and the drum of its cables",
        equation="|q − p| ≤ b/2, p of the drum, on which the cables pull against each other",
        signature="the motor turns freely for an angle where the torque of its cables changes sign",
        source="Nordin & Gutman 2002, Automatica 38(10), a survey of backlash",
        next_experiment="the motor turned slowly to and fro, its joint at rest without a load",
        look_at="the drum on its shaft, the coupling and the gear of the motor",
        tell_apart={
            "output_play": (
                "Hold the motor and move the joint by hand: play at the motor moves its drum."
            )
        },
        binding=on_pulleys(_width("reel_play")),
    ),
    Effect(
        identifier="joint_stiffness",
        name="a spring in a joint",
        equation="torque = … − k (q − q_ref)",
        signature="the joint moves less than it should, in proportion to its angle",
        source="MuJoCo, joint stiffness",
        next_experiment="the joint held at several angles for seconds each",
        binding=on_joints(Spec("stiffness", "N m/rad or N/m", 0.0, 1e6, 0.002)),
    ),
    Effect(
        identifier="springref",
        name="rest position of a joint's spring",
        equation="torque = … − k (q − q_ref)",
        signature="a constant force or torque on the joint",
        source="MuJoCo, joint springref",
        next_experiment="the joint at rest with nothing that pulls",
        binding=on(springs, Spec("springref", "rad or m", -6.3, 6.3, 1e-3)),
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
        binding=on(
            springs,
            Spec("stiffness", "N m/rad or N/m", 0.02, 50.0, 0.05, relative=True),
            Spec("springref", "rad or m", -4.0, 6.0, 0.02, relative=True, times="stiffness"),
        ),
        kind="parameter",
    ),
    Effect(
        identifier="armature",
        name="inertia about a joint, of its motor or of what it carries",
        equation="torque = … − I q̈",
        signature="a lag that grows with the square of the frequency, at any load",
        source="MuJoCo, joint armature",
        next_experiment="fast motion of the joint at two frequencies",
        in_motion=True,
        look_at="the rotor and gear of its motor, and the shape and mass of what it carries",
        binding=on(armatures, Spec("armature", "kg m² or kg", 0.0, 1e3, 1e-4)),
        kind="parameter",
    ),
    Effect(
        identifier="mass",
        name="mass of a body",
        equation="force = … − m q̈ + m g",
        signature="force in proportion to acceleration, and weight in proportion to it",
        source="MuJoCo, body mass",
        next_experiment="the body on scales, or fast motion at two frequencies",
        binding=on(bodies, Spec("mass", "kg", 0.01, 100.0, 0.05, relative=True)),
        kind="parameter",
    ),
    Effect(
        identifier="gravity_load",
        name="weight that the model does not carry",
        equation="force = … + m g",
        signature="an offset of tension that changes with posture",
        source="MuJoCo, option gravity",
        next_experiment="the same motion with the rig turned by 90° and by 180°",
        tell_apart={
            **dict.fromkeys(("joint_stiffness", "joint_spring"), _TURNED),
            "command_offset": (
                "Record the same motion with the rig turned by 180°: weight turns with it, the"
                " force of a motor does not."
            ),
        },
        binding=on_gravity(*(Spec(axis, "m/s²", -_G, _G, 1.0) for axis in "xyz")),
    ),
)


ACTUATORS: Final = (
    Effect(
        identifier="command_delay",
        name="a drive that acts late",
        equation="control(t) = column(t − d)",
        signature="everything trails what is driven, by the same time at any speed",
        source="transport delay",
        next_experiment="one hard step of the command: everything begins late and keeps its shape",
        in_motion=True,
        look_at="the drive and its clock",
        tell_apart={
            "sensor_delay": (
                "Measure a second quantity: a late sensor trails alone, behind a late drive all do."
            )
        },
        binding=on_inputs(Spec("command_delay", "s", 0.0, 0.3, 0.002)),
    ),
    Effect(
        identifier="slip",
        name="a slip of the cable on its drive",
        equation="control + s from t_s on",
        signature="from one moment of one recording on, all readings are those of another zero",
        source="a clamp, a knot or a turn on a drum that gave way; an encoder that lost counts",
        next_experiment="a mark on cable and drum, before and after",
        look_at="where the cable is held on its drum, the coupling, and lost counts of the encoder",
        binding=on(drives, Spec("slip", "m or rad", -1.0, 1.0, 1e-4)),
        event=True,
    ),
    Effect(
        identifier="gear",
        name="gear of a motor",
        equation="force = gear × control",
        signature="all forces of a motor too large or too small in proportion",
        source="MuJoCo, actuator gear",
        next_experiment="the motor's force against a scale or a load cell",
        tell_apart={
            "mass": (
                "Hold the motor against a load cell: its force at rest tells the gear without the"
                " mass."
            )
        },
        binding=on(motors, Spec("gear", "-", 0.2, 5.0, 0.02, relative=True)),
        kind="parameter",
    ),
    Effect(
        identifier="gear_friction",
        name="friction of a gear that grows with its load",
        equation="η = 1/(1 + c) forward, 1 − c back unless another is stated",
        signature="a servo stays behind its goal by more the more its joint bears, both ways",
        source="docs/no_tendons.md, a gear; mujoco issue 3528",
        next_experiment="the joint lifted and let down slowly under two loads",
        look_at="the gear of the motor",
        tell_apart={
            **dict.fromkeys(("sheath_friction", "friction"), _STRAIGHTENED),
            "gear_efficiency": (
                "Record the place of the motor: where a gear rubs it stays behind its goal by more,"
                " where a reading alone is off it does not."
            ),
            "kp": "Let the joint rest after moves from both sides: friction stops it on either.",
        },
        binding=on(gears, Spec("gear_friction", "-", 0.0, 5.0, 0.03)),
        kind="parameter",
    ),
    Effect(
        identifier="kp",
        name="gain of a servo",
        equation="force = k_p (command − q) − k_v q̇",
        signature="a servo that yields too much or too little under load",
        source="MuJoCo, actuator position; docs/servo.md, eq. (27)",
        next_experiment="the servo at rest under two loads",
        binding=together(
            on(drives_on_joints, Spec("kp", "-", 0.1, 10.0, 0.05, relative=True)),
            on_inputs(Spec("tension_gain", "-", 0.1, 10.0, 0.05, relative=True)),
        ),
        kind="parameter",
    ),
    Effect(
        identifier="kv",
        name="gain of a servo on the rate",
        equation="force = k_p (command − q) − k_v q̇",
        signature="a servo that trails in proportion to its rate, more or less than it should",
        source="MuJoCo, actuator position; docs/servo.md, eq. (27)",
        next_experiment="the same motion at three speeds, with the servo's force",
        in_motion=True,
        binding=together(
            on(drives_on_joints, Spec("kv", "-", 0.1, 10.0, 0.05, relative=True)),
            on_inputs(Spec("velocity_gain", "-", 0.1, 10.0, 0.05, relative=True)),
        ),
        kind="parameter",
    ),
    Effect(
        identifier="command_offset",
        name="constant force of a motor",
        equation="control = column + c",
        signature="a constant force or torque where the motor acts",
        source="metrology: zero error",
        next_experiment="the motor's force at rest, against a scale or a load cell",
        binding=on(motors, Spec("command_offset", "of the control", -1e3, 1e3, 0.01)),
        kind="parameter",
    ),
)


SENSOR_EFFECTS: Final = (
    Effect(
        identifier="sensor_bias",
        name="a sensor with an offset",
        equation="reading + b",
        signature="the same error at every moment, of one sensor only",
        source="metrology: zero error",
        next_experiment="the sensor at rest with nothing on it, before and after",
        look_at="the sensor's zero",
        binding=on_sensors(Spec("offset", "of the sensor", -0.5, 0.5, 0.01)),
    ),
    Effect(
        identifier="sensor_gain",
        name="a sensor with a wrong scale",
        equation="g × reading",
        signature="an error in proportion to the reading, of one sensor only",
        source="metrology: scale error",
        next_experiment="the sensor under two known weights far apart",
        look_at="the sensor's calibration",
        tell_apart={
            "sensor_bias": (
                "Record a wider range of tension, down to none at all: an offset stays the same, a"
                " wrong scale grows with the reading."
            )
        },
        binding=on_sensors(Spec("scale", "-", -0.5, 1.5, 0.01), spans=False),
        absent=1.0,
    ),
    Effect(
        identifier="sensor_delay",
        name="a sensor that reports late",
        equation="reading(t − d)",
        signature="one sensor trails the others by the same time at any speed",
        source="transport delay",
        next_experiment="one hard step: the reading begins late and keeps its corners",
        in_motion=True,
        look_at="the sensor, its amplifier and its filter",
        binding=on_sensors(Spec("delay", "s", 0.0, 0.3, 0.002), spans=False),
    ),
    Effect(
        identifier="sensor_lag",
        name="a sensor behind a low-pass filter",
        equation="τ dy/dt = x − y",
        signature="one sensor trails and rounds its corners",
        source="first-order lag",
        next_experiment="one hard step: the reading begins at once and rounds its corners",
        in_motion=True,
        look_at="the sensor, its amplifier and its filter",
        tell_apart={
            "sensor_delay": (
                "Record one hard step: a delay shifts it and keeps its corners, a lag begins at"
                " once and rounds them. Slow motion only shows the time by which both trail."
            )
        },
        binding=on_sensors(Spec("lag", "s", 0.0, 0.5, 0.002), spans=False),
    ),
    Effect(
        identifier="sensor_drift",
        name="a sensor whose zero wanders",
        equation="reading + r t",
        signature="an error that grows with time, of one sensor only",
        source="metrology: zero drift",
        next_experiment="the sensor at rest for as long as a recording takes",
        look_at="the sensor's zero, for heat",
        tell_apart={
            "friction_drift": (
                "Record the sensor at rest for as long: a drifting sensor drifts there too."
            )
        },
        binding=on_sensors(Spec("drift", "of the sensor per s", -0.1, 0.1, 0.002)),
    ),
    Effect(
        identifier="gear_efficiency",
        name="a gear between the cable and a reading of its tension",
        equation="T/η winding in, T η paying out; at rest between the two",
        signature="the reading jumps by 1/η² at each reversal of the drive, at any tension",
        source="motor current as torque: a gear's friction grows with its load",
        next_experiment=(
            "the reading beside a load cell or a hanging weight, wound in and paid out slowly"
        ),
        look_at="the gear before the motor whose current is read; a load cell has none",
        tell_apart=dict.fromkeys(("sheath_friction", "friction"), _AT_THE_DRIVE),
        binding=on_sensors(
            Spec("efficiency", "-", 0.3, 1.0, 0.05),
            Spec("rest_in", "-", -1.0, 1.0, 0.1),
            Spec("rest_out", "-", -1.0, 1.0, 0.1),
            spans=False,
        ),
        absent=1.0,
    ),
)
