"""Friction that falls with speed (Stribeck)."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_sheaths

EFFECT = Effect(
    identifier="velocity_weakening",
    name="friction that falls with speed (Stribeck)",
    equation="μ(v) = μ + Δμ e^{−|v|/v_s}",
    looks_like="wider loops when slow than when fast; a rise of friction around each reversal",
    source=(
        "Armstrong-Hélouvry, Dupont & Canudas de Wit 1994, Automatica 30(7), a survey of "
        "friction models"
    ),
    candidates=on_sheaths(
        Knob("stribeck_friction", "-", 0.0, 0.5, 0.01),
        Knob("stribeck_velocity", "m/s", 1e-4, 0.3, 1.0, starts=(0.001, 0.004, 0.015)),
    ),
    rugged=True,
)
