"""All that the servo knows lies in mjData too: it stops and goes on bit by bit."""

import mujoco
import numpy as np
import pytest
from mujoco import rollout

from tests.plugin.rigs import restore, servo_model, snapshot

INTEGRATORS = ["Euler", "implicitfast", "RK4"]
KINDS = {
    "plain": {},
    "clocked": {"period": 0.0017, "delay": 0.0061},
    "clever": {
        "feedback": "observer",
        "backlash_feedforward": 1.0,
        "rate_feedforward": 1.0,
        "loosening_tension_gain": 9.0,
    },
    "all": {"period": 0.002, "delay": 0.005, "backlash_feedforward": 1.0, "speed_limit": 0.7},
}


def busy(kind, integrator="Euler"):
    return servo_model(friction=0.3, integrator=integrator, velocity_gain=0.3, **KINDS[kind])


def drive(model, data, steps):
    for _ in range(steps):
        data.ctrl[0] = 35.0 + 14.0 * np.sin(25.0 * data.time)
        mujoco.mj_step(model, data)
    return data


def same(model, one, other):
    np.testing.assert_array_equal(snapshot(model, one), snapshot(model, other))
    np.testing.assert_array_equal(one.actuator_force, other.actuator_force)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("kind", KINDS)
def test_a_restored_state_and_a_copy_go_on_bit_by_bit(kind, integrator):
    m = busy(kind, integrator)
    data = drive(m, mujoco.MjData(m), 211)
    middle, copy = snapshot(m, data), mujoco.MjData(m)
    mujoco.mj_copyData(copy, m, data)
    other = drive(m, mujoco.MjData(m), 50)
    restore(m, other, middle)
    for d in (data, copy, other):
        drive(m, d, 150)
    same(m, data, copy)
    same(m, data, other)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("kind", KINDS)
def test_a_reset_forgets_everything(kind, integrator):
    m = busy(kind, integrator)
    fresh = snapshot(m, mujoco.MjData(m))
    data = drive(m, mujoco.MjData(m), 300)
    first = snapshot(m, data)
    mujoco.mj_resetData(m, data)
    np.testing.assert_array_equal(snapshot(m, data), fresh)
    np.testing.assert_array_equal(snapshot(m, drive(m, data, 300)), first)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("kind", KINDS)
def test_looking_without_stepping_commits_nothing(kind, integrator):
    m = busy(kind, integrator)
    plain, watched = mujoco.MjData(m), mujoco.MjData(m)
    for _ in range(200):
        drive(m, plain, 1)
        watched.ctrl[0] = 99.0  # what is looked at need not be what is done
        mujoco.mj_forward(m, watched)
        drive(m, watched, 1)
    np.testing.assert_allclose(watched.qpos, plain.qpos, rtol=1e-11, atol=1e-13)


@pytest.mark.parametrize("kind", KINDS)
def test_a_stop_between_the_two_halves_of_a_step_does_not_show(kind):
    m = busy(kind)
    whole, halves = drive(m, mujoco.MjData(m), 100), drive(m, mujoco.MjData(m), 100)
    for _ in range(100):
        drive(m, whole, 1)
        halves.ctrl[0] = 35.0 + 14.0 * np.sin(25.0 * halves.time)
        mujoco.mj_step1(m, halves)
        mujoco.mj_step2(m, halves)
    same(m, whole, halves)


@pytest.mark.parametrize("kind", KINDS)
def test_rollout_is_the_same_in_one_thread_and_in_two(kind):
    m = busy(kind)
    full = mujoco.mjtState.mjSTATE_FULLPHYSICS
    starts = np.empty((10, mujoco.mj_stateSize(m, full)))
    for k in range(10):
        mujoco.mj_getState(m, drive(m, mujoco.MjData(m), 20 * k), starts[k], full)
    control = 35.0 + 14.0 * np.sin(np.linspace(0.0, 9.0, 200))[None, :, None]
    results = [
        rollout.rollout(m, [mujoco.MjData(m) for _ in range(n)], starts, control=control)
        for n in (1, 2)
    ]
    for one, two in zip(*results, strict=True):
        np.testing.assert_array_equal(one, two)


@pytest.mark.parametrize("kind", ["plain", "clocked"])
def test_runge_kutta_agrees_with_small_steps(kind):
    ends = []
    for integrator, timestep in (("RK4", 2e-4), ("Euler", 2e-5)):
        m = servo_model(
            friction=0.0,
            integrator=integrator,
            timestep=timestep,
            velocity_gain=0.3,
            **({"period": 0.004, "delay": 0.008} if kind == "clocked" else {}),
        )
        data = mujoco.MjData(m)
        data.ctrl[0] = 40.0
        mujoco.mj_step(m, data, round(0.3 / timestep))
        ends.append(float(data.joint("motor").qpos[0]))
    assert ends[0] == pytest.approx(ends[1], rel=2e-3)


def test_a_tension_that_is_no_number_leaves_the_motor_alone():
    m = busy("plain")
    data = drive(m, mujoco.MjData(m), 10)
    data.ctrl[0] = np.nan
    mujoco.mj_step(m, data)
    assert np.isfinite(data.qpos).all()
    drive(m, data, 10)
    assert np.isfinite(data.plugin_state).all()
