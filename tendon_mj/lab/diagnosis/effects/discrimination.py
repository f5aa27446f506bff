"""Experiments that tell two effects apart which are known to explain the same data."""

from __future__ import annotations

from typing import Final

# Two identifiers → the sentence that says what to record.
DISCRIMINATING_EXPERIMENTS: Final[dict[frozenset[str], str]] = {
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
    frozenset({"joint_spring", "gravity_load"}): (
        "Record the same motion with the rig turned by 90°: a spring turns with it, weight does"
        " not."
    ),
    frozenset({"command_offset", "gravity_load"}): (
        "Record the same motion with the rig turned by 180°: weight turns with it, the force of a"
        " motor does not."
    ),
    frozenset({"command_delay", "sensor_delay"}): (
        "Measure a second quantity: a late sensor trails alone, behind a late drive all do."
    ),
    frozenset({"kv", "joint_damping"}): (
        "Measure the servo's force: what a joint damps it has to supply, its own rate gain not."
    ),
    frozenset({"springref", "pretension"}): (
        "Let the tendon go slack: the joint then rests where its spring does."
    ),
    frozenset({"gear", "mass"}): (
        "Hold the motor against a load cell: its force at rest tells the gear without the mass."
    ),
    frozenset({"sensor_bias", "pretension"}): (
        "Read the sensor with the tendon slack: an offset remains, a pretension is gone."
    ),
    frozenset({"gear_efficiency", "sheath_friction"}): (
        "Measure the tension at the drive by a load cell: the gear's friction is not in it, the"
        " sheath's is."
    ),
    frozenset({"gear_efficiency", "friction"}): (
        "Measure the tension at the drive by a load cell: the gear's friction is not in it, the"
        " sheath's is."
    ),
    frozenset({"sensor_drift", "friction_drift"}): (
        "Record the sensor at rest for as long: a drifting sensor drifts there too."
    ),
}
