"""What to record next, so that effects which explain the same data can be told apart."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

# What brings an effect out, as the end of a sentence that begins with "record".
EXPERIMENTS: Final[dict[str, str]] = {
    "sheath_friction": "full loops at two pretensions: its loop widens with the tension",
    "static_friction": "slow pulls after rests of different lengths, driven by a force and not by"
    " a displacement: it shows as a jump at breakaway",
    "velocity_weakening": "the same loop at speeds from very slow to slow: friction falls with it",
    "viscous_friction": "the same loop ten times as fast: its part of the loop grows tenfold",
    "constant_friction": "the same loop at a third and at three times the pretension: its part of"
    " the loop stays",
    "direction_asymmetry": "long steady pulls and long steady releases at one speed: their branches"
    " differ",
    "position_dependent_friction": "short loops at different places along the stroke",
    "friction_drift": "the same loop again at the end of an hour of motion",
    "backlash": "small reversals at a low and at a high tension: its lost motion is the same",
    "stiffening": "one slow pull over the whole range of tension: its slope grows with the tension",
    "creep": "a step and then minutes of rest, pulling and releasing",
    "sheath_compliance": "the same loop with the sheath's ends clamped, or its length measured",
    "tendon_inertia": "fast steps or a sweep up to the first resonance",
    "joint_damping": "the same motion of the joint at three speeds",
    "joint_friction": "slow reversals of the joint with the tendon at its lowest tension",
    "joint_stiffness": "the joint held at several angles for seconds each",
    "gravity_load": "the same motion with the rig turned by 90° and by 180°",
    "sensor_bias": "the sensor at rest with nothing on it, before and after",
    "sensor_gain": "the sensor under two known weights far apart",
    "sensor_delay": "one hard step: the reading begins late and keeps its corners",
    "sensor_lag": "one hard step: the reading begins at once and rounds its corners",
    "sensor_drift": "the sensor at rest for as long as a recording takes",
    "friction": "full loops at two pretensions: the tensions' ratio stays",
    "axial_stiffness": "small fast motions between reversals, or the tendon on a tensile tester",
    "pretension": "the tension at rest in the reference pose",
    "bend_angle": "the same loop in another posture of the sheath, straighter or more bent",
    "moment_arm": "the joint's angle beside the tendon's displacement, by hand and without load",
}

# Where two are known to tie, the one experiment that parts them.
PAIRS: Final[dict[frozenset[str], str]] = {
    frozenset({"sensor_delay", "sensor_lag"}): (
        "Record one hard step: a delay shifts it and keeps its corners, a lag begins at once and"
        " rounds them. Slow motion only shows the time by which both trail."
    ),
    frozenset({"sensor_bias", "sensor_gain"}): (
        "Record a wider range of tension, down to none at all: an offset stays the same, a wrong"
        " scale grows with the reading."
    ),
    frozenset({"friction", "bend_angle"}): (
        "Record the same loop in another posture of the sheath: only the product μφ shows as long"
        " as the bend φ stays as it is."
    ),
    frozenset({"sheath_friction", "bend_angle"}): (
        "Record the same loop in another posture of the sheath: only the product μφ shows as long"
        " as the bend φ stays as it is."
    ),
    frozenset({"axial_stiffness", "sheath_compliance"}): (
        "Measure the tendon alone on a tensile tester, or clamp the sheath: in series compliances"
        " add up, whatever gives way."
    ),
    frozenset({"friction", "constant_friction"}): (
        "Record the same loop at a third and at three times the pretension: capstan friction grows"
        " in proportion, a constant one stays."
    ),
    frozenset({"static_friction", "velocity_weakening"}): (
        "Record slow motion at several speeds and after rests of several lengths: static friction"
        " acts once at breakaway, a Stribeck curve at every low speed."
    ),
    frozenset({"backlash", "friction"}): (
        "Record small reversals at a low and at a high tension: play loses the same motion at both,"
        " friction more at the higher one."
    ),
    frozenset({"joint_stiffness", "gravity_load"}): (
        "Record the same motion with the rig turned by 90°: a spring turns with it, weight does"
        " not."
    ),
    frozenset({"sensor_bias", "pretension"}): (
        "Read the sensor with the tendon slack: an offset remains, a pretension is gone."
    ),
    frozenset({"sensor_drift", "friction_drift"}): (
        "Record the sensor at rest for as long: a drifting sensor drifts there too."
    ),
}


def advise(group: Sequence[str]) -> list[str]:
    """Sentences that say which experiment tells the effects of a group apart.

    Args:
        group: identifiers of the catalogue, two or more.

    Returns:
        One sentence for every pair that is known to tie; for effects in none of these, what
        brings each of them out.
    """
    said: list[str] = []
    covered: set[str] = set()
    for k, one in enumerate(group):
        for other in group[k + 1 :]:
            sentence = PAIRS.get(frozenset({one, other}))
            if sentence:
                covered |= {one, other}
                said += [sentence] if sentence not in said else []
    said += [
        f"For {name.replace('_', ' ')}, record {EXPERIMENTS[name]}."
        for name in group
        if name not in covered and name in EXPERIMENTS
    ]
    return said
