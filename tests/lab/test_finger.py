"""Laws of the finger: geometry, the capstan at every joint, stability, contact."""

from __future__ import annotations

import dataclasses
import itertools
import os

import mujoco
import numpy as np
import pytest
from mujoco import rollout
from scipy.linalg import eigh

from tendon_mj.attach import add_sensor
from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.finger import (
    ANGLES,
    OUT_OF_REACH,
    Trajectory,
    clamped,
    curl,
    find_motion,
    hold,
    prepare_finger,
    press,
    simulate_finger,
    summarise,
    tap,
)
from tendon_mj.models import JOINTS, TENDONS, Finger, build_finger, load_model, spool_angles
from tendon_mj.plugin import unsolved_evaluations
from tests.refusals import refusing
from tests.rigs import simulated

FINGER = Finger()
SHEATH_GUIDES = FINGER.forearm_guides + FINGER.wrist_guides


@pytest.fixture(scope="module")
def model():
    return build_finger(FINGER).compile()


def wander(finger, seed, duration=60.0):
    """Every joint for itself to a random angle of its range every 0.3 s, smoothly."""
    random, interval = np.random.default_rng(seed), 0.3
    low, high = np.array([(joint.low, joint.high) for joint in finger.joints.values()]).T
    goals = random.uniform(low, high, (round(duration / interval) + 2, len(JOINTS)))
    goals[0] = 0.0
    time = np.linspace(0.0, duration, round(duration / 0.01) + 1)
    at = np.floor(time / interval).astype(int)
    share = time / interval - at
    share = (share * share * (3.0 - 2.0 * share))[:, None]
    angles = (1.0 - share) * goals[at] + share * goals[at + 1]
    columns = dict(zip(ANGLES, angles.T, strict=True))
    return Trajectory(f"wander_{seed}", time, columns, aside=True)


def controls(trajectory, model, finger=FINGER):
    """(steps, nu) that the position servos are told."""
    return prepare_finger(trajectory, model, finger)[1]


def postures(count):
    ranges = [np.linspace(j.low, j.high, count) for j in FINGER.joints.values()]
    return np.array(list(itertools.product(*ranges)))


def pose(model, data, angles):
    for joint, angle in zip(JOINTS, angles, strict=True):
        data.joint(joint).qpos = angle
    mujoco.mj_forward(model, data)


def moment_arms(model, data, tendon):
    """−dL/dq of the three joints [m], from MuJoCo."""
    k, dofs = model.tendon(tendon).id, [model.joint(j).dofadr[0] for j in JOINTS]
    jacobian = np.zeros(model.nv)
    start, count = model.ten_J_rowadr[k], model.ten_J_rownnz[k]
    jacobian[model.ten_J_colind[start : start + count]] = data.ten_J[start : start + count]
    return -jacobian[dofs]


def readings(model, control, **initial):
    """(steps, nsensordata) from the reference pose, and the data at the end."""
    data = mujoco.MjData(model)
    full = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.empty(mujoco.mj_stateSize(model, full))
    mujoco.mj_getState(model, data, state, full)
    _, seen = rollout.rollout(model, data, state, control=control[None])
    return seen[0], data


def sensed(model, seen, name):
    sensor = model.sensor(name)
    return seen[:, sensor.adr[0] : sensor.adr[0] + sensor.dim[0]]


def joint_angles(model, seen):
    """(steps, 3) [rad]."""
    return np.hstack([sensed(model, seen, f"{joint}_angle") for joint in JOINTS])


def beyond_limits(angles):
    """By how much angles exceed the joints' ranges [rad]; negative within."""
    low, high = np.array([(joint.low, joint.high) for joint in FINGER.joints.values()]).T
    return np.maximum(angles - high, low - angles)


def move_away(model):
    model.qpos_spring[model.joint("object").qposadr[0]] = OUT_OF_REACH


def test_each_tendon_pulls_its_way_over_the_whole_range(model):
    data = mujoco.MjData(model)
    for angles in postures(9):
        pose(model, data, angles)
        assert np.all(moment_arms(model, data, "flexor") > 0.002), np.degrees(angles)
        assert np.all(moment_arms(model, data, "extensor") < -0.001), np.degrees(angles)


def test_mean_moment_arms_of_the_flexor_are_the_literatures(model):
    """2 parts of joint thickness and an offset each (models/finger/README.md)."""
    data, means = mujoco.MjData(model), []
    for k, joint in enumerate(FINGER.joints.values()):
        arms = []
        for angle in np.linspace(joint.low, joint.high, 50):
            pose(model, data, np.eye(3)[k] * angle)
            arms.append(moment_arms(model, data, "flexor")[k])
        means.append(np.mean(arms))
    np.testing.assert_allclose(means, [0.0111, 0.0083, 0.0052], atol=0.0006)


def test_spool_angles_are_what_mujocos_tendon_lengths_say(model):
    data = mujoco.MjData(model)
    pose(model, data, np.zeros(3))
    straight = data.ten_length.copy()
    for angles in postures(4):
        pose(model, data, angles)
        turned = spool_angles(FINGER, angles)
        for tendon in TENDONS:
            k = model.tendon(tendon).id
            expected = (straight[k] - data.ten_length[k]) / FINGER.spool_radius
            assert float(turned[tendon]) == pytest.approx(expected, abs=1e-9)


def test_the_straight_finger_is_at_rest(model):
    data = simulated(model)
    np.testing.assert_allclose(data.qacc, 0.0, atol=1e-9)
    for end in ("input", "output"):
        for tendon in TENDONS:
            tension = data.sensor(f"{tendon}_{end}_tension").data[0]
            assert tension == pytest.approx(FINGER.pretension, rel=1e-9)


@pytest.mark.parametrize("tendon", TENDONS)
def test_a_sliding_tendon_loses_the_product_of_the_capstans_at_every_joint(tendon):
    spec = build_finger(FINGER)
    for kind in ("tension", "bend_angle", "slip"):
        add_sensor(spec, f"{tendon}_sheath", kind, kind)
    model = spec.compile()
    move_away(model)
    seen, _ = readings(model, controls(curl(), model))
    tension, bend, slip = (sensed(model, seen, kind) for kind in ("tension", "bend_angle", "slip"))
    places = {"mcp": (0, 2), "pip": (2, 4), "dip": (4, 5)}  # the DIP's second point is the end
    for joint, (first, last) in places.items():
        guides = slice(SHEATH_GUIDES + first, SHEATH_GUIDES + last)
        for way in (1.0, -1.0):
            sliding = np.all(slip[:, guides] == way, axis=1)
            sliding &= tension.min(axis=1) > 0.1
            assert sliding.sum() > 100, (joint, way)
            lost = tension[sliding, guides.start] / tension[sliding, guides.stop]
            product = np.prod(np.exp(way * FINGER.friction * bend[sliding, guides]), axis=1)
            np.testing.assert_allclose(lost, product, rtol=1e-6)
        assert np.ptp(bend[:, guides].sum(axis=1)) > np.radians(10.0), joint


# TENDON_MJ_SEEDS=100 pytest tests/lab/test_finger.py -k minute
@pytest.mark.parametrize("seed", range(int(os.environ.get("TENDON_MJ_SEEDS", "3"))))
@pytest.mark.parametrize("aside", [True, False])
def test_a_minute_of_random_motion_is_sound(seed, aside):
    spec = build_finger(FINGER)
    for tendon in TENDONS:
        add_sensor(spec, f"{tendon}_sheath", "friction_work", f"{tendon}_work")
    model = spec.compile()
    if aside:
        move_away(model)
    seen, data = readings(model, controls(wander(FINGER, seed), model))
    assert np.isfinite(seen).all()
    assert not any(warning.number for warning in data.warning)
    for tendon in TENDONS:
        work = sensed(model, seen, f"{tendon}_work")
        assert np.diff(work, axis=0).min() >= 0.0
        assert work[-1].sum() > 0.5
    assert not any(unsolved_evaluations(model, data).values())
    # hooked on the object and slammed against their limits, the joints give way further
    assert beyond_limits(joint_angles(model, seen)).max() < np.radians(0.5 if aside else 4.0)


@pytest.mark.parametrize("tendon", TENDONS)
def test_the_limits_bear_all_that_a_motor_pulls(model, tendon):
    time = np.linspace(0.0, 2.0, 201)
    most = FINGER.motor_torque * FINGER.gear / FINGER.spool_radius
    pull = {f"{t}_N": np.full(201, FINGER.pretension) for t in TENDONS}
    pull[f"{tendon}_N"] = np.clip(most * time, FINGER.pretension, most)
    answer = simulate_finger(Trajectory("pull", time, pull, aside=True), model)
    assert answer.columns[f"{tendon}_input_tension_N"][-1] > 0.95 * most
    angles = np.stack([answer.columns[f"{joint}_angle_rad"] for joint in JOINTS], axis=-1)
    assert beyond_limits(angles[-1]).max() < np.radians(0.1)


def asked(**columns):
    """Half a second of a trajectory, in the unit of the columns."""
    time = np.linspace(0.0, 0.5, 51)
    return Trajectory("asked", time, {k: np.full(51, v) for k, v in columns.items()}, aside=True)


@pytest.mark.parametrize(
    ("columns", "facts"),
    [
        (
            {"mcp_rad": 0.0, "pip_rad": 0.0, "dip_rad": 30.0},
            ["'dip'", "30 rad (1719 deg)", "0 s", "-0.08727", "1.396 rad"],
        ),
        ({"mcp_rad": -0.2, "pip_rad": 0.0, "dip_rad": 0.0}, ["'mcp'", "-0.2 rad"]),
        ({"flexor_N": 200.0, "extensor_N": 4.0}, ["'flexor'", "200 N", "116.5 N"]),
        ({"flexor_N": 4.0, "extensor_N": -1.0}, ["'extensor'", "-1 N"]),
    ],
)
def test_what_is_out_of_reach_is_refused_or_clamped(model, columns, facts):
    trajectory = asked(**columns)
    with refusing(InvalidValueError, *facts):
        simulate_finger(trajectory, model)
    simulate_finger(clamped(trajectory, FINGER), model)


def test_the_ends_of_the_ranges_are_within_reach(model):
    for end in ("low", "high"):
        ends = {f"{name}_rad": getattr(joint, end) for name, joint in FINGER.joints.items()}
        simulate_finger(asked(**ends), model)


def test_a_motion_by_name_is_the_drive_of_its_trajectory(model):
    for trajectory in (tap(), press()):
        rows, motion = controls(trajectory, model), find_motion("finger", model, trajectory.name)
        times = np.arange(len(rows)) * model.opt.timestep
        np.testing.assert_array_equal([motion.drive(time) for time in times], rows)
        assert motion.duration == trajectory.time[-1]
        assert ("flexor_angle.kp" in motion.parameters) == trajectory.by_tension
    assert find_motion("finger", model).name == "curl"
    default = find_motion("bench", load_model("bench"))
    assert (default.name, default.duration) == ("default motion", np.inf)


def test_half_the_step_hardly_matters():
    answers = []
    for timestep in (FINGER.timestep, FINGER.timestep / 2.0):
        finger = dataclasses.replace(FINGER, timestep=timestep)
        model = build_finger(finger).compile()
        move_away(model)
        seen, _ = readings(model, controls(wander(finger, 0, 20.0), model, finger))
        angles = joint_angles(model, seen)
        answers.append(angles[:: round(FINGER.timestep / timestep)])
    size = min(map(len, answers))
    off = np.degrees(answers[0][:size] - answers[1][:size])
    assert np.sqrt(np.mean(off**2)) < 0.5


def test_the_step_is_stable_with_every_guide_stuck(model):
    """A stuck segment is a spring EA/ℓ; explicit steps follow it up to h = 2/ω."""
    data, fastest = mujoco.MjData(model), 0.0
    dofs = np.ix_(*[[model.joint(j).dofadr[0] for j in JOINTS]] * 2)
    for angles in postures(5):
        pose(model, data, angles)
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, mass)
        stiffness = np.zeros(3)
        for k, joint in enumerate(FINGER.joints.values()):
            for tendon in TENDONS:
                around = joint.span(tendon, angles[k] + np.array([-1e-5, 0.0, 1e-5]))
                arm = (around[2] - around[0]) / 2e-5
                stiffness[k] += FINGER.axial_stiffness * arm**2 / around[1]
        fastest = max(fastest, eigh(np.diag(stiffness), mass[dofs], eigvals_only=True)[-1])
    assert 2.0 / np.sqrt(fastest) > 1.5 * FINGER.timestep


def test_with_friction_the_same_tension_holds_another_force_after_more(model):
    """Held at 14 N from below and from above: without friction there is no difference."""
    forces = {}
    for friction in (None, 0.0):
        answer = simulate_finger(hold(), model, friction=friction)
        force = answer.columns["tip_force_N"]
        forces[friction] = [force[np.searchsorted(answer.time, t)] for t in (2.9, 7.9)]
    assert forces[None][1] > forces[None][0] + 0.5
    assert forces[0.0][1] == pytest.approx(forces[0.0][0], rel=0.05)


def test_pressing_moves_the_object_by_force_over_stiffness(model):
    columns = simulate_finger(press(), model).columns
    force, moved = columns["tip_force_N"], columns["object_displacement_m"]
    assert force.max() > 1.0
    pressing = (force > 0.8 * force.max()) & (np.abs(np.gradient(force)) < 0.01)
    # where the pulp touches an edge of the face, it does not press along the slide
    np.testing.assert_allclose(
        moved[pressing] * FINGER.object_stiffness, force[pressing], rtol=0.15
    )


def test_the_springs_alone_extend_the_finger_again():
    model = load_model("finger_spring")
    columns = simulate_finger(curl(), model, name="finger_spring").columns
    assert "extensor_input_tension_N" not in columns
    for joint in JOINTS:
        angle = np.degrees(columns[f"{joint}_angle_rad"])
        assert angle.max() > 30.0
        assert abs(angle[-1]) < 15.0


@pytest.mark.parametrize(
    ("part", "number", "value"),
    [
        (FINGER, "friction", -0.1),
        (FINGER, "axial_stiffness", 0.0),
        (FINGER, "bend", np.nan),
        (FINGER, "timestep", 0.0),
        (FINGER, "gear", -1),
        (FINGER.mcp, "stiffness", -1.0),
        (FINGER.mcp, "low", 2.0),
    ],
)
def test_numbers_out_of_range_are_refused_by_name(part, number, value):
    with refusing(InvalidValueError, number):
        dataclasses.replace(part, **{number: value})


@pytest.mark.parametrize("geom", [*JOINTS, "object"])
def test_what_touches_is_as_the_builder_makes_it(model, geom):
    file = load_model("finger")
    for field in ("size", "pos", "quat", "contype", "conaffinity", "solref", "solimp", "friction"):
        one, other = (getattr(m.geom(geom), field) for m in (file, model))
        np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-9, err_msg=field)


def test_the_scene_shows_conduits_where_the_guides_are():
    model = load_model("finger", scene=True)
    data = simulated(model)
    for tendon in TENDONS:
        geom, mesh = model.geom(f"{tendon}_conduit").id, model.mesh(f"{tendon}_conduit")
        vertices = model.mesh_vert[mesh.vertadr[0] :][: mesh.vertnum[0]]
        shown = data.geom_xpos[geom] + vertices @ data.geom_xmat[geom].reshape(3, 3).T
        for k in range(1, SHEATH_GUIDES + 1):
            guide = data.site(f"{tendon}_sheath_{k}").xpos
            nearest = np.linalg.norm(shown - guide, axis=1).min()
            assert nearest == pytest.approx(0.0027, abs=2e-5)  # the conduit's inner radius


def test_without_friction_both_ends_of_a_tendon_pull_alike(model):
    summary = summarise(simulate_finger(tap(), model, friction=0.0))
    assert summary["flexor_input_over_output_max"] == pytest.approx(1.0, abs=1e-9)
    assert summary["flexor_input_over_output_min"] == pytest.approx(1.0, abs=1e-9)
    assert summary["tip_force_max_N"] > 0.0
