"""Effects of the tendon, its sheath and its drive; and parameters of theirs that may be wrong."""

from __future__ import annotations

from typing import Final

from tendon_mj.lab.diagnosis.effects.binding import ParameterSpecification as Spec
from tendon_mj.lab.diagnosis.effects.binding import (
    commands,
    frictionless_sheaths,
    on,
    on_reels,
    on_sheaths,
    together,
)
from tendon_mj.lab.diagnosis.effects.effect import Effect

_KANEKO: Final = "Kaneko, Wada, Maekawa & Tanie 1991"
_FRICTION_SURVEY: Final = (
    "Armstrong-Hélouvry, Dupont & Canudas de Wit 1994, Automatica 30(7), a survey of friction"
    " models"
)

_IN_ANOTHER_POSTURE: Final = (
    "Record the same loop in another posture of the sheath: only the product μφ shows"
    " as long as the bend φ stays as it is."
)

TRANSMISSION: Final = (
    Effect(
        identifier="sheath_friction",
        name="friction of the sheath (capstan)",
        equation="T_high = T_low e^{μφ}",
        signature="output lags input in a wide loop whose width grows with the tension",
        source=f"{_KANEKO}, eq. (1)",
        next_experiment="full loops at two pretensions: its loop widens with the tension",
        look_at="the sheath and its lining",
        binding=on(frictionless_sheaths, Spec("friction", "-", 0.0, 1.0, 0.02), shared=True),
        overrides_known=True,  # a coefficient of 0 says that the model has no friction, not the rig
    ),
    Effect(
        identifier="static_friction",
        name="static friction above the dynamic one",
        equation="at rest T_high ≤ T_low e^{μ_s φ}, μ_s = (1 + x) μ",
        signature=(
            "a jump of the tension after each reversal or dwell, when the tendon breaks loose"
        ),
        source=f"{_KANEKO}, eq. (1)",
        next_experiment=(
            "slow pulls after rests of different lengths, driven by a force and not by a "
            "displacement: it shows as a jump at breakaway"
        ),
        look_at="the sheath and its lining",
        binding=on_sheaths(Spec("static_friction", "-", 0.0, 3.0, 0.2, relative_to="friction")),
        changes="friction",
    ),
    Effect(
        identifier="velocity_weakening",
        name="friction that falls with speed (Stribeck)",
        equation="μ(v) = μ + Δμ e^{−|v|/v_s}",
        signature="wider loops when slow than when fast; a rise of friction around each reversal",
        source=_FRICTION_SURVEY,
        next_experiment="the same loop at speeds from very slow to slow: friction falls with it",
        in_motion=True,
        look_at="the sheath and its lining",
        tell_apart={
            "static_friction": (
                "Record slow motion at several speeds and after rests of several lengths: static"
                " friction acts once at breakaway, a Stribeck curve at every low speed."
            )
        },
        binding=on_sheaths(
            Spec("stribeck_friction", "-", 0.0, 0.5, 0.01),
            Spec("stribeck_velocity", "m/s", 1e-4, 0.3, 1.0, starts=(0.001, 0.004, 0.015)),
        ),
        non_smooth=True,
        changes="friction",  # alone it would be friction of the sheath with one number more
    ),
    Effect(
        identifier="viscous_friction",
        name="friction that grows with speed",
        equation="T_high = T_low e^{μφ} + c_v |v|",
        signature="wider loops when fast, and nothing when slow",
        source=_FRICTION_SURVEY,
        next_experiment="the same loop ten times as fast: its part of the loop grows tenfold",
        in_motion=True,
        look_at="the sheath and its lining, and its lubricant",
        binding=on_sheaths(Spec("viscous_friction", "N s/m", 0.0, 5e3, 10.0)),
    ),
    Effect(
        identifier="constant_friction",
        name="friction that the tension does not change",
        equation="T_high = T_low e^{μφ} + F_c",
        signature="a loop as wide at low tension as at high",
        source=f"{_KANEKO}, section 2.3",
        next_experiment=(
            "the same loop at a third and at three times the pretension: its part of the loop stays"
        ),
        look_at="the sheath and its lining, seals and pulleys",
        tell_apart={
            "friction": (
                "Record the same loop at a third and at three times the pretension: capstan"
                " friction grows in proportion, a constant one stays."
            )
        },
        binding=on_sheaths(Spec("constant_friction", "N", 0.0, 50.0, 0.3)),
    ),
    Effect(
        identifier="direction_asymmetry",
        name="friction that differs between pulling and loosening",
        equation="μ (1 + α) pulling, μ (1 − α) loosening",
        signature="one branch of the loop is off, the other less or the other way",
        source="an assumption of ours: a worn or plaited tendon has a grain",
        next_experiment=(
            "long steady pulls and long steady releases at one speed: their branches differ"
        ),
        look_at="the sheath and its lining, and where the cable enters and leaves it",
        binding=on_sheaths(Spec("direction_asymmetry", "-", -0.9, 0.9, 0.05)),
        changes="friction",
    ),
    Effect(
        identifier="position_dependent_friction",
        name="friction that changes with the tendon's place",
        equation="μ (1 + γ u), u the tendon drawn in",
        signature="the loop is wider at one end of the stroke than tension explains",
        source="a worn or kinked stretch of tendon",
        next_experiment="short loops at different places along the stroke",
        look_at="where the cable rubs most: a kink, a worn or dirty place",
        binding=on_sheaths(Spec("friction_gradient", "1/m", -2e3, 2e3, 30.0)),
        changes="friction",
    ),
    Effect(
        identifier="load_dependent_friction",
        name="friction whose coefficient changes with the tension",
        equation="μ (1 + λ (T − T_0)), T the tension at each place of the sheath",
        signature="the loop widens faster with the tension than the tension grows, or slower",
        source="polymers: the area of contact grows less than the load, Archard 1957",
        next_experiment="the same loop at two pretensions: the ratio of its tensions changes",
        look_at="the sheath's lining",
        tell_apart=dict.fromkeys(
            ("position_dependent_friction", "direction_asymmetry"),
            "Record the same loop at another pretension: a coefficient that changes with the"
            " tension is another one there, at the same places and in both directions.",
        ),
        binding=on_sheaths(Spec("load_gradient", "1/N", -1.0, 1.0, 0.003)),
        changes="friction",
    ),
    Effect(
        identifier="friction_drift",
        name="friction that changes with time",
        equation="μ (1 + β t)",
        signature="loops widen or narrow from cycle to cycle",
        source="running-in, lubricant and temperature",
        next_experiment="the same loop again at the end of an hour of motion",
        look_at="the sheath and its lining, for heat and wear",
        binding=on_sheaths(Spec("friction_drift", "1/s", -0.2, 1.0, 0.01)),
        changes="friction",
    ),
    Effect(
        identifier="backlash",
        name="play between drive and tendon",
        equation="ξ_in = play of width b of the drive's displacement",
        signature=(
            "both tensions stand still for the same displacement after every reversal, at any "
            "tension"
        ),
        source="Nordin & Gutman 2002, Automatica 38(10), a survey of backlash",
        next_experiment=(
            "small reversals at a low and at a high tension: its lost motion is the same"
        ),
        look_at="the spool on its shaft, the coupling and the gear before the cable, and its ends",
        tell_apart={
            "friction": (
                "Record small reversals at a low and at a high tension: play loses the same motion"
                " at both, friction more at the higher one."
            )
        },
        binding=on_sheaths(Spec("backlash", "m", 0.0, 5e-3, 2e-5, larger=(2e-4, 1e-3, 4e-3))),
    ),
    Effect(
        identifier="stiffening",
        name="a tendon that stiffens as it stretches",
        equation="T = EA ε (1 + κ ε)",
        signature="branches are curved: steeper at high tension",
        source="ropes bed in: Costello 1997, Theory of Wire Rope",
        next_experiment=(
            "one slow pull over the whole range of tension: its slope grows with the tension"
        ),
        look_at="the cable",
        binding=on_sheaths(Spec("stiffening", "-", 0.0, 5e3, 20.0)),
    ),
    Effect(
        identifier="creep",
        name="a tendon that creeps (viscoelastic)",
        equation="ε = T/EA + ε_c, τ_c dε_c/dt = χ T/EA − ε_c",
        signature="tension sinks during a dwell after pulling and rises after loosening",
        source="standard linear solid; polymer tendons",
        next_experiment="a step and then minutes of rest, pulling and releasing",
        in_motion=True,
        look_at="the cable",
        binding=on_sheaths(
            Spec("creep", "-", 0.0, 3.0, 0.03),
            # faster creep is a softer cable, whose stiffness may be known
            Spec("creep_time", "s", 0.1, 30.0, 1.0, starts=(0.15, 0.5, 2.5)),
        ),
    ),
    Effect(
        identifier="sheath_compliance",
        name="an elastic mount of the sheath",
        equation="of ξ_in only ξ_in − C_s (T_in − T_0) reaches the tendon",
        signature=(
            "both tensions too small for the displacement, in proportion to the input tension"
        ),
        source="Bowden sheaths compress: Kaneko et al. 1991 hold them rigid",
        next_experiment="the same loop with the sheath's ends clamped, or its length measured",
        look_at="the brackets that hold the sheath",
        tell_apart={
            "axial_stiffness": (
                "Measure the tendon alone on a tensile tester, or clamp the sheath: in series"
                " compliances add up, whatever gives way."
            )
        },
        binding=on_sheaths(Spec("sheath_compliance", "m/N", 0.0, 1e-3, 5e-7)),
    ),
    Effect(
        identifier="output_compliance",
        name="an elastic mount at the output",
        equation="of the motion ξ_out at the output only ξ_out − C_o (T_out − T_0) arrives",
        signature="the output moves too little under load, in proportion to the output tension",
        source="cuffs and anchors on soft tissue, brackets at the sheath's far end",
        next_experiment="the output blocked, and then pulled: how far the cable still moves",
        look_at="what holds the cable and the sheath at the output: anchor, cuff, bracket",
        tell_apart={
            "sheath_compliance": (
                "Clamp one end of the sheath after the other: the motion that is lost goes with the"
                " mount that gives way."
            ),
            "axial_stiffness": (
                "Block the output and pull: what moves beyond the last guide is its mount, and not"
                " the tendon."
            ),
        },
        binding=on_sheaths(Spec("output_compliance", "m/N", 0.0, 1e-3, 5e-7)),
    ),
    Effect(
        identifier="tendon_inertia",
        name="mass of the tendon",
        equation="T_left − T_right = … + m dv/dt",
        signature="input tension runs ahead of the output in fast motion, as acceleration",
        source=f"{_KANEKO}, section 2.2",
        next_experiment="fast steps or a sweep up to the first resonance",
        in_motion=True,
        binding=on_sheaths(Spec("tendon_mass", "kg", 0.0, 20.0, 0.1)),
    ),
)


PARAMETER_EFFECTS: Final = (
    Effect(
        identifier="friction",
        name="coefficient of friction",
        equation="μ",
        signature="loops too wide or too narrow at every tension",
        source=f"{_KANEKO}, eq. (1)",
        next_experiment="full loops at two pretensions: the tensions' ratio stays",
        binding=on_sheaths(Spec("friction", "-", 0.0, 20.0, 0.05, relative=True)),
        kind="parameter",
    ),
    Effect(
        identifier="axial_stiffness",
        name="stiffness of the tendon",
        equation="EA",
        signature="slopes of all branches too steep or too flat",
        source=f"{_KANEKO}, eq. (5)",
        next_experiment="small fast motions between reversals, or the tendon on a tensile tester",
        binding=on_sheaths(Spec("axial_stiffness", "N", 0.02, 50.0, 0.05, relative=True)),
        kind="parameter",
    ),
    Effect(
        identifier="pretension",
        name="pretension of the tendon",
        equation="T_0",
        signature="all tensions too high or too low by much the same",
        source=f"{_KANEKO}, section 2.1",
        next_experiment="the tension at rest in the reference pose",
        tell_apart={
            "springref": "Let the tendon go slack: the joint then rests where its spring does.",
            "sensor_bias": (
                "Read the sensor with the tendon slack: an offset remains, a pretension is gone."
            ),
        },
        binding=on_sheaths(Spec("pretension", "N", 0.0, 20.0, 0.05, relative=True)),
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
        source=f"{_KANEKO}, eq. (12)",
        next_experiment="the same loop in another posture of the sheath, straighter or more bent",
        tell_apart=dict.fromkeys(("friction", "sheath_friction"), _IN_ANOTHER_POSTURE),
        binding=on_sheaths(Spec("drawn_bend", "rad", 0.0, 15.0, 0.1)),
        kind="parameter",
    ),
    Effect(
        identifier="moment_arm",
        name="radius of a drum or pulley",
        equation="ξ = r θ",
        signature="all displacements of the tendon too large or too small in proportion",
        source=f"{_KANEKO}, section 3",
        next_experiment=(
            "the joint's angle beside the tendon's displacement, by hand and without load"
        ),
        binding=together(
            on(commands, Spec("command_scale", "-", 0.5, 2.0, 0.02, relative=True), shared=True),
            on_reels(Spec("reel_radius", "m", 0.3, 3.0, 0.02, relative=True)),
            on_sheaths(Spec("output_radius", "m", 0.3, 3.0, 0.02, relative=True)),
        ),
        kind="parameter",
    ),
)
