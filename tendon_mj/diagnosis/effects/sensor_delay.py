"""A sensor that reports late."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_sensors

EFFECT = Effect(
    identifier="sensor_delay",
    name="a sensor that reports late",
    equation="reading(t − d)",
    looks_like="one sensor trails the others by the same time at any speed",
    source="transport delay",
    candidates=on_sensors(Knob("delay", "s", 0.0, 0.3, 0.002), spans=False),
)
