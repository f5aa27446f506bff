"""Bend of the sheath."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_sheaths

EFFECT = Effect(
    identifier="bend_angle",
    name="bend of the sheath",
    equation="φ + φ_x",
    looks_like=(
        "as a wrong coefficient of friction, and cannot be told from it where the bend "
        "does not change"
    ),
    source="Kaneko, Wada, Maekawa & Tanie 1991, eq. (12)",
    candidates=on_sheaths(Knob("extra_bend", "rad", -3.0, 12.0, 0.1)),
    kind="parameter",
)
