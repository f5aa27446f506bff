"""Wrong numbers: parameters that the model has, at another value."""

from __future__ import annotations

from typing import Final

from tendon_mj.lab.diagnosis.effects.binding import (
    ParameterSpecification,
    on_commands,
    on_reels,
    on_sheaths,
    together,
)
from tendon_mj.lab.diagnosis.effects.effect import Effect

PARAMETERS: Final = (
    Effect(
        identifier="friction",
        name="coefficient of friction",
        equation="μ",
        signature="loops too wide or too narrow at every tension",
        source="Kaneko, Wada, Maekawa & Tanie 1991, eq. (1)",
        next_experiment="full loops at two pretensions: the tensions' ratio stays",
        binding=on_sheaths(ParameterSpecification("friction", "-", 0.0, 20.0, 0.05, relative=True)),
        kind="parameter",
    ),
    Effect(
        identifier="axial_stiffness",
        name="stiffness of the tendon",
        equation="EA",
        signature="slopes of all branches too steep or too flat",
        source="Kaneko, Wada, Maekawa & Tanie 1991, eq. (5)",
        next_experiment="small fast motions between reversals, or the tendon on a tensile tester",
        binding=on_sheaths(
            ParameterSpecification("axial_stiffness", "N", 0.02, 50.0, 0.05, relative=True)
        ),
        kind="parameter",
    ),
    Effect(
        identifier="pretension",
        name="pretension of the tendon",
        equation="T_0",
        signature="all tensions too high or too low by much the same",
        source="Kaneko, Wada, Maekawa & Tanie 1991, section 2.1",
        next_experiment="the tension at rest in the reference pose",
        binding=on_sheaths(
            ParameterSpecification("pretension", "N", 0.0, 20.0, 0.05, relative=True)
        ),
        kind="parameter",
    ),
    Effect(
        identifier="bend_angle",
        name="bend of the sheath",
        equation="φ",
        signature=(
            "as a wrong coefficient of friction, and cannot be told from it where the bend "
            "does not change"
        ),
        source="Kaneko, Wada, Maekawa & Tanie 1991, eq. (12)",
        next_experiment="the same loop in another posture of the sheath, straighter or more bent",
        binding=on_sheaths(ParameterSpecification("drawn_bend", "rad", 0.0, 15.0, 0.1)),
        kind="parameter",
    ),
    Effect(
        identifier="moment_arm",
        name="radius of a drum or pulley",
        equation="ξ = r θ",
        signature="all displacements of the tendon too large or too small in proportion",
        source="Kaneko, Wada, Maekawa & Tanie 1991, section 3",
        next_experiment=(
            "the joint's angle beside the tendon's displacement, by hand and without load"
        ),
        binding=together(
            on_commands(
                ParameterSpecification("command_scale", "-", 0.5, 2.0, 0.02, relative=True)
            ),
            on_reels(ParameterSpecification("reel_radius", "m", 0.3, 3.0, 0.02, relative=True)),
            on_sheaths(ParameterSpecification("output_radius", "m", 0.3, 3.0, 0.02, relative=True)),
        ),
        kind="parameter",
    ),
)
