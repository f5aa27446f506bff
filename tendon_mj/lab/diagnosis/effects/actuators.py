"""Effects of actuators, and their wrong numbers."""

from __future__ import annotations

from typing import Final

from tendon_mj.lab.diagnosis.effects.binding import (
    ParameterSpecification,
    on_drives,
    on_inputs,
    on_motors,
    on_servos,
    together,
)
from tendon_mj.lab.diagnosis.effects.effect import Effect

ACTUATORS: Final = (
    Effect(
        identifier="command_delay",
        name="a drive that acts late",
        equation="control(t) = column(t − d)",
        signature="everything trails what is driven, by the same time at any speed",
        source="transport delay",
        next_experiment="one hard step of the command: everything begins late and keeps its shape",
        binding=on_inputs(ParameterSpecification("command_delay", "s", 0.0, 0.3, 0.002)),
    ),
    Effect(
        identifier="slip",
        name="a slip of the cable on its drive",
        equation="control + s from t_s on",
        signature="from one moment of one recording on, all readings are those of another zero",
        source="a clamp, a knot or a turn on a drum that gave way; an encoder that lost counts",
        next_experiment="a mark on cable and drum, before and after",
        binding=on_drives(ParameterSpecification("slip", "m or rad", -1.0, 1.0, 1e-4)),
        event=True,
    ),
    Effect(
        identifier="gear",
        name="gear of a motor",
        equation="force = gear × control",
        signature="all forces of a motor too large or too small in proportion",
        source="MuJoCo, actuator gear",
        next_experiment="the motor's force against a scale or a load cell",
        binding=on_motors(ParameterSpecification("gear", "-", 0.2, 5.0, 0.02, relative=True)),
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
            on_servos(ParameterSpecification("kp", "-", 0.1, 10.0, 0.05, relative=True)),
            on_inputs(ParameterSpecification("tension_gain", "-", 0.1, 10.0, 0.05, relative=True)),
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
        binding=together(
            on_servos(ParameterSpecification("kv", "-", 0.1, 10.0, 0.05, relative=True)),
            on_inputs(ParameterSpecification("velocity_gain", "-", 0.1, 10.0, 0.05, relative=True)),
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
        binding=on_motors(
            ParameterSpecification("command_offset", "of the control", -1e3, 1e3, 0.01)
        ),
        kind="parameter",
    ),
)
