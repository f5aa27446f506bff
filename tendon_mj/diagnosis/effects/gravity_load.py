"""Weight that the model does not carry."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_world

EFFECT = Effect(
    identifier="gravity_load",
    name="weight that the model does not carry",
    equation="force = … + m g",
    looks_like="an offset of tension that changes with posture",
    source="MuJoCo, option gravity",
    candidates=on_world(
        Knob("x", "m/s²", -30.0, 30.0, 1.0),
        Knob("y", "m/s²", -30.0, 30.0, 1.0),
        Knob("z", "m/s²", -30.0, 30.0, 1.0),
    ),
)
