"""Laws of the antagonistic joint: symmetry, compliance, the capstan, and a dead band that grows."""

from __future__ import annotations

import dataclasses

import mujoco
import numpy as np
import pytest

from tendon_mj.attach import add_sensor
from tendon_mj.errors import InvalidValueError
from tendon_mj.models import Bench, Joint, build_joint
from tests.refusals import refusing
from tests.rigs import simulated

BENDS = (0.0, 60.0, 120.0, 180.0, 240.0)
SENSORS = (
    "joint_angle",
    "spool_angle",
    "input_tension_1",
    "input_tension_2",
    "output_tension_1",
    "output_tension_2",
)


def run(joint, command, duration, reels=(0.0, 0.0)):
    """Readings (steps, sensors) while the spool is told ``command(time)``."""
    model = build_joint(joint).compile()
    data = mujoco.MjData(model)
    readings = []
    for _ in range(round(duration / joint.timestep)):
        data.ctrl[:] = command(data.time), *reels
        mujoco.mj_step(model, data)
        readings.append(data.sensordata[: len(SENSORS)].copy())
    return dict(zip(SENSORS, np.array(readings).T, strict=True))


def to(angle, within=1.0):
    return lambda time: angle * min(1.0, time / within)


def sine(time):
    return np.sin(time)


@pytest.mark.parametrize("bend", BENDS)
def test_both_tendons_are_as_long_and_as_bent_as_the_numbers_say(bend):
    joint = Joint(bend=np.radians(bend))
    spec = build_joint(joint)
    add_sensor(spec, "sheath_1", "bend_angle", "bend_1")
    add_sensor(spec, "sheath_2", "bend_angle", "bend_2")
    model = spec.compile()
    data = simulated(model)
    for number in (1, 2):
        angles = data.sensor(f"bend_{number}").data
        # the bend of a straight tendon is an arc cosine near 1
        np.testing.assert_allclose(angles, joint.bend / joint.guides, rtol=1e-9, atol=1e-7)
    np.testing.assert_allclose(
        model.tendon_length0, joint.length + 2.0 * joint.free_length, rtol=1e-12
    )


def test_tendons_start_at_the_pretension():
    at_rest = run(Joint(pretension=7.0), to(0.0), 0.1)
    for sensor in SENSORS[2:]:
        np.testing.assert_allclose(at_rest[sensor], 7.0, rtol=1e-9)
    np.testing.assert_allclose(at_rest["joint_angle"], 0.0, atol=1e-12)


def test_a_command_turned_round_mirrors_everything():
    there, back = run(Joint(), sine, 4.0), run(Joint(), lambda t: -np.sin(t), 4.0)
    np.testing.assert_allclose(there["joint_angle"], -back["joint_angle"], atol=1e-9)
    for end in ("input", "output"):
        for one, other in ((1, 2), (2, 1)):
            np.testing.assert_allclose(
                there[f"{end}_tension_{one}"], back[f"{end}_tension_{other}"], atol=1e-7
            )


def test_without_friction_and_spring_the_hinge_goes_where_the_spool_goes():
    ideal = Joint(friction=0.0, stiffness=0.0, damping=0.005)
    answer = run(ideal, to(0.7), 2.0)
    assert answer["joint_angle"][-1] == pytest.approx(answer["spool_angle"][-1], abs=1e-6)
    assert answer["spool_angle"][-1] == pytest.approx(0.7, abs=1e-6)


@pytest.mark.parametrize("stiffness", [0.01, 0.02, 0.04])
def test_without_friction_the_hinge_follows_up_to_the_tendons_stretch(stiffness):
    joint = Joint(friction=0.0, stiffness=stiffness, damping=0.005)
    answer = run(joint, to(0.5), 2.0)
    tendons = 2.0 * joint.moment_arm**2 * joint.axial_stiffness
    tendons /= joint.length + 2.0 * joint.free_length
    # what is wound in shortens a tendon by 0.2 %, which this linear spring neglects
    share = tendons / (tendons + stiffness)
    assert answer["joint_angle"][-1] == pytest.approx(0.5 * share, rel=3e-3)
    pull = answer["output_tension_1"][-1] - answer["output_tension_2"][-1]
    assert pull * joint.moment_arm == pytest.approx(stiffness * 0.5 * share, rel=5e-3)


def test_friction_leaves_the_spring_in_balance_with_the_tensions_at_the_hinge():
    joint = Joint(damping=0.005)
    answer = run(joint, to(0.6), 2.0)
    pull = answer["output_tension_1"][-1] - answer["output_tension_2"][-1]
    torque = joint.stiffness * answer["joint_angle"][-1]
    assert pull * joint.moment_arm == pytest.approx(torque, rel=2e-3)


@pytest.mark.parametrize("bend", BENDS)
def test_a_sliding_tendon_has_the_capstans_ratio(bend):
    joint = Joint(bend=np.radians(bend), damping=0.005)
    answer = run(joint, to(0.9, within=2.0), 1.99)
    pulled = answer["input_tension_1"][-1] / answer["output_tension_1"][-1]
    released = answer["input_tension_2"][-1] / answer["output_tension_2"][-1]
    assert pulled == pytest.approx(np.exp(joint.exponent), rel=1e-6)
    assert released == pytest.approx(np.exp(-joint.exponent), rel=1e-6)


def test_the_dead_band_grows_with_the_bend():
    bands = []
    for bend in BENDS:
        answer = run(Joint(bend=np.radians(bend), damping=0.005), sine, np.pi)
        top = int(np.argmax(answer["joint_angle"]))
        turned = answer["joint_angle"] < answer["joint_angle"][top] - 0.01
        moved = top + int(np.argmax(turned[top:]))
        bands.append(answer["spool_angle"].max() - answer["spool_angle"][moved])
    assert np.all(np.diff(bands) > 0.01)


def test_the_reels_set_the_tension_and_leave_the_hinge():
    joint = Joint(friction=0.0, damping=0.005)
    answer = run(joint, to(0.0), 1.0, reels=(1e-4, 1e-4))
    length = joint.length + 2.0 * joint.free_length
    more = joint.axial_stiffness * 1e-4 / length
    for number in (1, 2):
        tension = answer[f"input_tension_{number}"][-1]
        assert tension == pytest.approx(joint.pretension + more, rel=2e-3)
    assert answer["joint_angle"][-1] == pytest.approx(0.0, abs=1e-9)


def test_half_the_timestep_hardly_matters():
    coarse = Joint()
    fine = dataclasses.replace(coarse, timestep=coarse.timestep / 2.0)
    a, b = run(coarse, sine, 4.0), run(fine, sine, 4.0)
    np.testing.assert_allclose(a["joint_angle"], b["joint_angle"][::2], atol=5e-4)
    np.testing.assert_allclose(a["output_tension_1"], b["output_tension_1"][::2], atol=0.02)


REFUSED = [("friction", -0.1), ("friction", np.nan), ("axial_stiffness", 0.0), ("length", 0.0)]
REFUSED += [("pretension", -1.0), ("guides", 0), ("bend", np.inf), ("timestep", 0.0)]


@pytest.mark.parametrize("kind", [Joint, Bench])
@pytest.mark.parametrize(("number", "value"), REFUSED)
def test_numbers_out_of_range_are_refused_by_name(kind, number, value):
    with refusing(InvalidValueError, f"{number} = {value}"):
        kind(**{number: value})
