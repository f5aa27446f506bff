"""Static friction above the dynamic one."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_sheaths

EFFECT = Effect(
    identifier="static_friction",
    name="static friction above the dynamic one",
    equation="at rest T_high ≤ T_low e^{μ_s φ}, μ_s = (1 + x) μ",
    looks_like="a jump of the tension after each reversal or dwell, when the tendon breaks loose",
    source="Kaneko, Wada, Maekawa & Tanie 1991, eq. (1)",
    candidates=on_sheaths(Knob("static_friction", "-", 0.0, 3.0, 0.2, relative_to="friction")),
)
