"""Coefficient of friction."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_sheaths

EFFECT = Effect(
    identifier="friction",
    name="coefficient of friction",
    equation="μ",
    looks_like="loops too wide or too narrow at every tension",
    source="Kaneko, Wada, Maekawa & Tanie 1991, eq. (1)",
    candidates=on_sheaths(Knob("friction", "-", 0.1, 5.0, 0.05, share=True)),
    kind="parameter",
)
