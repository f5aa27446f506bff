"""A tendon that creeps (viscoelastic)."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_sheaths

EFFECT = Effect(
    identifier="creep",
    name="a tendon that creeps (viscoelastic)",
    equation="ε = T/EA + ε_c, τ_c dε_c/dt = χ T/EA − ε_c",
    looks_like="tension sinks during a dwell after pulling and rises after loosening",
    source="standard linear solid; polymer tendons",
    candidates=on_sheaths(
        Knob("creep", "-", 0.0, 3.0, 0.03),
        Knob("creep_time", "s", 0.02, 30.0, 1.0, starts=(0.1, 0.5, 2.5)),
    ),
)
