"""A sheath whose mount yields."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_sheaths

EFFECT = Effect(
    identifier="sheath_compliance",
    name="a sheath whose mount yields",
    equation="of ξ_in only ξ_in − C_s (T_in − T_0) reaches the tendon",
    looks_like="both tensions too small for the displacement, in proportion to the input tension",
    source="Bowden sheaths compress: Kaneko et al. 1991 hold them rigid",
    candidates=on_sheaths(Knob("sheath_compliance", "m/N", 0.0, 1e-3, 5e-7)),
)
