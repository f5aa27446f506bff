"""All that sheaths and servos know lies in mjData: a simulation can stop anywhere and go on.

Runge-Kutta evaluates the tendon four times a step and commits it once.
"""

import mujoco
import numpy as np
import pytest
from mujoco import rollout

from tests.rigs import (
    ALL_ON_ARM,
    arm,
    compiled,
    restore,
    run,
    servo_model,
    snapshot,
    started,
    two_links,
    unpacked,
)

INTEGRATORS = ["Euler", "implicitfast", "implicit", "RK4"]
LAWS = {"plain": {}, "damped": {"axial_damping": 1.0}, "all effects": ALL_ON_ARM}
SERVOS = {
    "servo": {},
    "clocked servo": {"period": 0.0017, "delay": 0.0061},
    "clever servo": {
        "feedback": "observer",
        "backlash_feedforward": 1.0,
        "rate_feedforward": 1.0,
        "loosening_tension_gain": 9.0,
    },
    "all of a servo": {
        "period": 0.002,
        "delay": 0.005,
        "backlash_feedforward": 1.0,
        "speed_limit": 0.7,
    },
}
LAST, LIMITED = "input at the last site", "at its limit"
each_kind = pytest.mark.parametrize("kind", [*LAWS, *SERVOS, LAST, LIMITED])
each_integrator = pytest.mark.parametrize("integrator", INTEGRATORS)


def busy(kind="plain", integrator="Euler"):
    """An arm with spools, a motor with a servo, or links that a motor pulls from the last site."""
    if kind in (LAST, LIMITED):
        limit = 'limited="true" range="0 .5" solreflimit=".01 1"' if kind == LIMITED else ""
        law = {"friction": 0.3, "arc_guides": 2, "input_end": "last"}
        option = f'timestep="0.001" integrator="{integrator}"'
        pull = '<motor tendon="t" gear="-.5"/>'
        given = {"tendon": limit, "law": law, "actuator": pull, "option": option}
        return compiled(two_links("e d ball@t c wheel@s b a", **given))
    if kind in SERVOS:
        return servo_model(friction=0.3, integrator=integrator, velocity_gain=0.3, **SERVOS[kind])
    law = {"static_friction": 0.35} | LAWS[kind]
    return arm(integrator=integrator, spools=True, timestep=0.001, **law)


def begun(model, seed=5, speed=2.0):
    """Fresh data of the arm that moves, or of the servo, which is driven."""
    return started(model, None if model.nu else seed, speed)


def control(model, data):
    data.ctrl[:] = 35.0 + 14.0 * np.sin(25.0 * data.time)


def drive(model, data, steps):
    return run(model, data, steps, lambda _: control(model, data))


def same(model, one, other):
    np.testing.assert_array_equal(snapshot(model, one), snapshot(model, other))
    for field in ("sensordata", "actuator_force", "qacc"):
        np.testing.assert_array_equal(getattr(one, field), getattr(other, field))


@each_integrator
@each_kind
def test_a_restored_state_and_a_copy_go_on_bit_by_bit(integrator, kind):
    model = busy(kind, integrator)
    data = drive(model, begun(model), 137)
    middle, copy, fresh = snapshot(model, data), mujoco.MjData(model), mujoco.MjData(model)
    mujoco.mj_copyData(copy, model, data)
    other = drive(model, begun(model, 9, 1.0), 50)  # data that has seen something else
    for restored in (other, fresh):
        restore(model, restored, middle)
    drive(model, data, 200)
    for each in (copy, other, fresh):
        same(model, data, drive(model, each, 200))


@each_integrator
@each_kind
def test_a_reset_forgets_everything(integrator, kind):
    model = busy(kind, integrator)
    data = begun(model)
    fresh, start = snapshot(model, mujoco.MjData(model)), data.qvel.copy()
    first = snapshot(model, drive(model, data, 300))
    mujoco.mj_resetData(model, data)
    np.testing.assert_array_equal(snapshot(model, data), fresh)
    data.qvel[:] = start
    np.testing.assert_array_equal(snapshot(model, drive(model, data, 300)), first)


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "implicit"])
@each_kind
def test_a_stop_or_a_copy_between_the_two_halves_of_a_step_does_not_show(integrator, kind):
    model = busy(kind, integrator)
    whole, halves = begun(model), begun(model)
    for _ in range(150):
        drive(model, whole, 1)
        control(model, halves)
        mujoco.mj_step1(model, halves)
        half, halves = halves, mujoco.MjData(model)
        mujoco.mj_copyData(halves, model, half)
        mujoco.mj_step2(model, halves)
    same(model, whole, halves)


@each_integrator
@pytest.mark.parametrize("kind", [*LAWS, *SERVOS])
def test_looking_without_stepping_commits_nothing(integrator, kind):
    model = busy(kind, integrator)
    plain, watched = begun(model), begun(model)
    for _ in range(200):
        drive(model, plain, 1)
        watched.ctrl[:] = 99.0  # what is looked at need not be what is done
        for _ in range(3):
            mujoco.mj_forward(model, watched)
        if kind == "damped" and integrator != "RK4":
            size = 2 * model.nv
            matrix = np.zeros((size, size))
            mujoco.mjd_transitionFD(model, watched, 1e-6, True, matrix, None, None, None)
        drive(model, watched, 1)
    if kind in ("plain", "all effects"):
        same(model, watched, plain)
    np.testing.assert_allclose(watched.qpos, plain.qpos, rtol=1e-11, atol=1e-13)


@each_integrator
def test_a_look_at_another_pose_commits_nothing(integrator):
    model = busy("plain", integrator)
    # from the second step on: the first evaluation of all lays the tendon
    plain, watched = (run(model, begun(model), 1) for _ in range(2))
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
    np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(guides, others)


@each_kind
def test_rollout_in_two_threads_is_the_same_as_step_by_step(kind):
    model = busy(kind, "implicitfast")
    state, steps = mujoco.mjtState.mjSTATE_FULLPHYSICS, 150
    starts = np.empty((12, mujoco.mj_stateSize(model, state)))
    for seed in range(12):
        data = drive(model, begun(model, seed), 10 * seed)
        mujoco.mj_getState(model, data, starts[seed], state)
    controls = np.broadcast_to(
        35.0 + 14.0 * np.sin(np.linspace(0.0, 9.0, steps))[:, None], (steps, model.nu)
    )
    threads = [mujoco.MjData(model) for _ in range(2)]
    states, shown = rollout.rollout(model, threads, starts, controls[None], nstep=steps)
    for seed in (0, 5, 11):
        data, now = mujoco.MjData(model), np.empty_like(starts[0])
        mujoco.mj_setState(model, data, starts[seed], state)
        mujoco.mj_forward(model, data)
        data.qacc_warmstart[:] = 0.0
        mujoco.mj_setState(model, data, starts[seed], state)
        for k in range(steps):
            data.ctrl[:] = controls[k]
            mujoco.mj_step(model, data)
            mujoco.mj_getState(model, data, now, state)
            np.testing.assert_array_equal(states[seed, k], now)
            np.testing.assert_array_equal(shown[seed, k], data.sensordata)


@pytest.mark.parametrize("clock", [{}, {"period": 0.004, "delay": 0.008}])
def test_a_servo_under_runge_kutta_agrees_with_small_steps(clock):
    ends = []
    for integrator, timestep in (("RK4", 2e-4), ("Euler", 2e-5)):
        model = servo_model(integrator=integrator, timestep=timestep, velocity_gain=0.3, **clock)
        data = mujoco.MjData(model)
        data.ctrl[0] = 40.0
        mujoco.mj_step(model, data, round(0.3 / timestep))
        ends.append(float(data.joint("motor").qpos[0]))
    assert ends[0] == pytest.approx(ends[1], rel=2e-3)


def at_end(integrator, timestep):
    """Position and speed after 40 ms, through which the tendon stays taut."""
    law = {"friction": 0.2, "axial_stiffness": 200.0, "pretension": 20.0}
    model = arm(integrator=integrator, timestep=timestep, **law)
    data = run(model, started(model, 2, 0.3), round(0.04 / timestep))
    return np.concatenate([data.qpos, data.qvel])


@pytest.mark.parametrize("damping", [0.0, 1.0])
def test_the_commit_is_that_of_the_step_s_first_evaluation_and_one_a_step(damping):
    model, other = (
        arm(integrator=integrator, timestep=0.002, axial_damping=damping)
        for integrator in ("RK4", "Euler")
    )
    data, look = started(model, 4, 3.0), started(other, 4, 3.0)
    for k in range(100):
        look.qpos[:], look.qvel[:], look.time = data.qpos, data.qvel, data.time
        look.plugin_state[:] = data.plugin_state
        # what Euler commits in this state does not depend on what happens after its evaluation
        mujoco.mj_step(other, look)
        mujoco.mj_step(model, data)
        (scalars, segments, guides), (theirs, commits, slides) = (
            unpacked(m, d) for m, d in ((model, data), (other, look))
        )
        np.testing.assert_array_equal(segments["stored"], commits["stored"])
        for row in ("friction_work", "previous_slip", "trial_flow"):
            np.testing.assert_array_equal(guides[row], slides[row])
        assert scalars.commit_time == theirs.commit_time == pytest.approx(0.002 * k, rel=1e-12)
        assert scalars.has_trial == 0.0


def test_runge_kutta_and_many_small_steps_go_the_same_way():
    best = at_end("RK4", 2.5e-5)
    scale = np.abs(best).max()
    euler = [np.abs(at_end("Euler", h) - best).max() / scale for h in (2e-4, 1e-4, 5e-5)]
    assert 1.8 < euler[0] / euler[1] < 2.2, "first order"
    assert 1.8 < euler[1] / euler[2] < 2.2
    # twenty times the step, and still nearer
    assert np.abs(at_end("RK4", 1e-3) - best).max() / scale < euler[2]


def test_without_friction_runge_kutta_keeps_its_fourth_order():
    def end(timestep):
        model = arm(integrator="RK4", timestep=timestep, friction=0.0)
        return run(model, started(model, 2, 0.3), round(0.032 / timestep)).qpos.copy()

    best = end(1.25e-4)
    coarse, fine = (np.abs(end(h) - best).max() for h in (4e-3, 2e-3))
    assert 14.0 < coarse / fine < 19.0
