"""A sensor with a wrong scale."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_sensors

EFFECT = Effect(
    identifier="sensor_gain",
    name="a sensor with a wrong scale",
    equation="g × reading",
    looks_like="an error in proportion to the reading, of one sensor only",
    source="metrology: scale error",
    candidates=on_sensors(Knob("scale", "-", -0.5, 1.5, 0.01), spans=False),
)
