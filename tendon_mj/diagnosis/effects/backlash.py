"""Play between drive and tendon."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_sheaths

EFFECT = Effect(
    identifier="backlash",
    name="play between drive and tendon",
    equation="ξ_in = play of width b of the drive's displacement",
    looks_like=(
        "both tensions stand still for the same displacement after every reversal, at any tension"
    ),
    source="Nordin & Gutman 2002, Automatica 38(10), a survey of backlash",
    candidates=on_sheaths(Knob("backlash", "m", 0.0, 5e-3, 2e-5)),
)
