"""Radius of a drum or pulley."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect
from tendon_mj.diagnosis.place import Knob, on_inputs, on_sheaths, together

EFFECT = Effect(
    identifier="moment_arm",
    name="radius of a drum or pulley",
    equation="ξ = r θ",
    looks_like="all displacements of the tendon too large or too small in proportion",
    source="Kaneko, Wada, Maekawa & Tanie 1991, section 3",
    candidates=together(
        on_inputs(Knob("command_scale", "-", 0.5, 2.0, 0.02, share=True)),
        on_sheaths(Knob("output_radius", "m", 0.3, 3.0, 0.02, share=True)),
    ),
    kind="parameter",
)
