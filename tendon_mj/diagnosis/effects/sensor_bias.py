"""A sensor with an offset."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_sensors

EFFECT = Effect(
    identifier="sensor_bias",
    name="a sensor with an offset",
    equation="reading + b",
    looks_like="the same error at every moment, of one sensor only",
    source="metrology: zero error",
    candidates=on_sensors(Knob("offset", "of the sensor", -0.5, 0.5, 0.01)),
)
