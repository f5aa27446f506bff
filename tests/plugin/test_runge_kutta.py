"""Runge-Kutta evaluates the tendon four times a step and commits it once."""

import mujoco
import numpy as np

from tests.plugin.rigs import arm, run, started, unpacked


def at_end(integrator, timestep):
    """Position and speed after 40 ms, through which the tendon stays taut."""
    law = {"friction": 0.2, "axial_stiffness": 200.0, "pretension": 20.0}
    model = arm(integrator=integrator, timestep=timestep, **law)
    data = run(model, started(model, 2, 0.3), round(0.04 / timestep))
    return np.concatenate([data.qpos, data.qvel])


def test_the_commit_is_that_of_the_step_s_first_evaluation():
    model = arm(integrator="RK4", timestep=0.002)
    other = arm(integrator="Euler", timestep=0.002)
    data, look = started(model, 4, 3.0), started(other, 4, 3.0)
    for _ in range(100):
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
        assert scalars.commit_time == theirs.commit_time


def test_time_advances_by_one_commit_a_step():
    model = arm(integrator="RK4", timestep=0.002, axial_damping=1.0)
    data = started(model, 4, 3.0)
    for k in range(50):
        mujoco.mj_step(model, data)
        scalars = unpacked(model, data)[0]
        assert np.isclose(scalars.commit_time, 0.002 * k, rtol=1e-12)
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
