"""All that the sheath knows lies in mjData: a simulation can stop anywhere and go on."""

import mujoco
import numpy as np
import pytest
from mujoco import rollout

from tests.plugin.rigs import ALL_ON_ARM, arm, restore, run, snapshot, started, unpacked

INTEGRATORS = ["Euler", "implicitfast", "implicit", "RK4"]
LAWS = {"plain": {}, "damped": {"axial_damping": 1.0}, "all effects": ALL_ON_ARM}
each_law = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)


def busy(integrator="Euler", law=LAWS["plain"]):
    return arm(
        integrator=integrator, spools=True, timestep=0.001, **{"static_friction": 0.35} | law
    )


def same(model, one, other):
    np.testing.assert_array_equal(snapshot(model, one), snapshot(model, other))
    np.testing.assert_array_equal(one.sensordata, other.sensordata)
    np.testing.assert_array_equal(one.qacc, other.qacc)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@each_law
def test_a_restored_state_goes_on_bit_by_bit(integrator, law):
    model = busy(integrator, law)
    data = run(model, started(model, 5, 2.0), 137)
    middle = snapshot(model, data)
    run(model, data, 200)
    other = run(model, started(model, 9, 1.0), 50)  # data that has seen something else
    restore(model, other, middle)
    run(model, other, 200)
    same(model, data, other)
    fresh = mujoco.MjData(model)
    restore(model, fresh, middle)
    run(model, fresh, 200)
    same(model, data, fresh)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@each_law
def test_a_copy_goes_on_bit_by_bit(integrator, law):
    model = busy(integrator, law)
    data = run(model, started(model, 5, 2.0), 137)
    other = mujoco.MjData(model)
    mujoco.mj_copyData(other, model, data)
    run(model, data, 200)
    run(model, other, 200)
    same(model, data, other)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@each_law
def test_a_reset_forgets_everything(integrator, law):
    model = busy(integrator, law)
    data = started(model, 5, 2.0)
    fresh = snapshot(model, mujoco.MjData(model))
    start = data.qvel.copy()
    run(model, data, 300)
    first = snapshot(model, data)
    mujoco.mj_resetData(model, data)
    np.testing.assert_array_equal(snapshot(model, data), fresh)
    data.qvel[:] = start
    run(model, data, 300)
    np.testing.assert_array_equal(snapshot(model, data), first)


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "implicit"])
@each_law
def test_a_stop_between_the_two_halves_of_a_step_does_not_show(integrator, law):
    model = busy(integrator, law)
    whole, halves = started(model, 5, 2.0), started(model, 5, 2.0)
    for _ in range(150):
        mujoco.mj_step(model, whole)
        mujoco.mj_step1(model, halves)
        mujoco.mj_step2(model, halves)
    same(model, whole, halves)


@each_law
def test_a_copy_between_the_two_halves_of_a_step_goes_on_bit_by_bit(law):
    model = busy("Euler", law)
    data = run(model, started(model, 5, 2.0), 100)
    mujoco.mj_step1(model, data)
    other = mujoco.MjData(model)
    mujoco.mj_copyData(other, model, data)
    mujoco.mj_step2(model, data)
    mujoco.mj_step2(model, other)
    run(model, data, 100)
    run(model, other, 100)
    same(model, data, other)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@each_law
def test_looking_without_stepping_commits_nothing(integrator, law):
    model = busy(integrator, law)
    plain, watched = started(model, 5, 2.0), started(model, 5, 2.0)
    for _ in range(200):
        mujoco.mj_step(model, plain)
        for _ in range(3):
            mujoco.mj_forward(model, watched)
        mujoco.mj_step(model, watched)
    same(model, watched, plain)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_look_at_another_pose_commits_nothing(integrator):
    model = busy(integrator)
    # from the second step on: the first evaluation of all lays the tendon
    plain, watched = (run(model, started(model, 5, 2.0), 1) for _ in range(2))
    for _ in range(100):
        mujoco.mj_step(model, plain)
        here, speed, now = watched.qpos.copy(), watched.qvel.copy(), watched.time
        watched.qpos[:] += 0.02
        mujoco.mj_forward(model, watched)
        watched.qpos[:], watched.qvel[:], watched.time = here, speed, now
        mujoco.mj_step(model, watched)
    np.testing.assert_array_equal(watched.qpos, plain.qpos)
    np.testing.assert_array_equal(watched.sensordata, plain.sensordata)
    (_, one, guides), (_, other, others) = unpacked(model, watched), unpacked(model, plain)
    one["prefix_tension"] = other["prefix_tension"]  # the solver's work space
    np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(guides, others)


def test_finite_differences_leave_the_simulation_as_it_was():
    model = busy("Euler")
    data = run(model, started(model, 5, 2.0), 100)
    other = mujoco.MjData(model)
    mujoco.mj_copyData(other, model, data)
    n = 2 * model.nv
    mujoco.mjd_transitionFD(model, data, 1e-6, True, np.zeros((n, n)), None, None, None)
    run(model, data, 100)
    run(model, other, 100)
    np.testing.assert_allclose(data.qpos, other.qpos, rtol=1e-11, atol=1e-12)


@each_law
def test_rollout_is_the_same_in_one_thread_two_threads_and_step_by_step(law):
    model = busy("implicitfast", law)
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    size = mujoco.mj_stateSize(model, kind)
    starts = np.empty((12, size))
    for seed in range(12):
        data = run(model, started(model, seed, 2.0), 10 * seed)
        mujoco.mj_getState(model, data, starts[seed], kind)
    steps = 150
    results = [
        rollout.rollout(model, [mujoco.MjData(model) for _ in range(n)], starts, nstep=steps)
        for n in (1, 2)
    ]
    for one, two in zip(*results, strict=True):
        np.testing.assert_array_equal(one, two)
    states, shown = results[0]
    for seed in (0, 5, 11):
        data = mujoco.MjData(model)
        mujoco.mj_setState(model, data, starts[seed], kind)
        mujoco.mj_forward(model, data)
        data.qacc_warmstart[:] = 0.0
        mujoco.mj_setState(model, data, starts[seed], kind)
        now = np.empty(size)
        for k in range(steps):
            mujoco.mj_step(model, data)
            mujoco.mj_getState(model, data, now, kind)
            np.testing.assert_array_equal(states[seed, k], now)
            np.testing.assert_array_equal(shown[seed, k], data.sensordata)
