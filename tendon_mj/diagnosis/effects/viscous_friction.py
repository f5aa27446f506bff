"""Friction that grows with speed."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_sheaths

EFFECT = Effect(
    identifier="viscous_friction",
    name="friction that grows with speed",
    equation="T_high = T_low e^{μφ} + c_v |v|",
    looks_like="wider loops when fast, and nothing when slow",
    source=(
        "Armstrong-Hélouvry, Dupont & Canudas de Wit 1994, Automatica 30(7), a survey of "
        "friction models"
    ),
    candidates=on_sheaths(Knob("viscous_friction", "N s/m", 0.0, 5e3, 10.0)),
)
