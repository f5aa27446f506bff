"""A sensor behind a low-pass filter."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_sensors

EFFECT = Effect(
    identifier="sensor_lag",
    name="a sensor behind a low-pass filter",
    equation="τ dy/dt = x − y",
    looks_like="one sensor trails and rounds its corners",
    source="first-order lag",
    candidates=on_sensors(Knob("lag", "s", 0.0, 0.5, 0.002), spans=False),
)
