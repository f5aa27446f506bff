"""A sensor whose zero wanders."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_sensors

EFFECT = Effect(
    identifier="sensor_drift",
    name="a sensor whose zero wanders",
    equation="reading + r t",
    looks_like="an error that grows with time, of one sensor only",
    source="metrology: zero drift",
    candidates=on_sensors(Knob("drift", "of the sensor per s", -0.1, 0.1, 0.002)),
)
