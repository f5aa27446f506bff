"""Effects of the sensors."""

from __future__ import annotations

from typing import Final

from tendon_mj.lab.diagnosis.effects.binding import ParameterSpecification, on_sensors
from tendon_mj.lab.diagnosis.effects.effect import Effect

SENSORS: Final = (
    Effect(
        identifier="sensor_bias",
        name="a sensor with an offset",
        equation="reading + b",
        signature="the same error at every moment, of one sensor only",
        source="metrology: zero error",
        next_experiment="the sensor at rest with nothing on it, before and after",
        binding=on_sensors(ParameterSpecification("offset", "of the sensor", -0.5, 0.5, 0.01)),
    ),
    Effect(
        identifier="sensor_gain",
        name="a sensor with a wrong scale",
        equation="g × reading",
        signature="an error in proportion to the reading, of one sensor only",
        source="metrology: scale error",
        next_experiment="the sensor under two known weights far apart",
        binding=on_sensors(ParameterSpecification("scale", "-", -0.5, 1.5, 0.01), spans=False),
        absent=1.0,
    ),
    Effect(
        identifier="sensor_delay",
        name="a sensor that reports late",
        equation="reading(t − d)",
        signature="one sensor trails the others by the same time at any speed",
        source="transport delay",
        next_experiment="one hard step: the reading begins late and keeps its corners",
        binding=on_sensors(ParameterSpecification("delay", "s", 0.0, 0.3, 0.002), spans=False),
    ),
    Effect(
        identifier="sensor_lag",
        name="a sensor behind a low-pass filter",
        equation="τ dy/dt = x − y",
        signature="one sensor trails and rounds its corners",
        source="first-order lag",
        next_experiment="one hard step: the reading begins at once and rounds its corners",
        binding=on_sensors(ParameterSpecification("lag", "s", 0.0, 0.5, 0.002), spans=False),
    ),
    Effect(
        identifier="sensor_drift",
        name="a sensor whose zero wanders",
        equation="reading + r t",
        signature="an error that grows with time, of one sensor only",
        source="metrology: zero drift",
        next_experiment="the sensor at rest for as long as a recording takes",
        binding=on_sensors(
            ParameterSpecification("drift", "of the sensor per s", -0.1, 0.1, 0.002)
        ),
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
        binding=on_sensors(
            ParameterSpecification("efficiency", "-", 0.3, 1.0, 0.05),
            ParameterSpecification("rest_in", "-", -1.0, 1.0, 0.1),
            ParameterSpecification("rest_out", "-", -1.0, 1.0, 0.1),
            spans=False,
        ),
        absent=1.0,
    ),
)
