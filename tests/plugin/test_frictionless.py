"""Without friction the sheath is MuJoCo's own spatial tendon."""

import mujoco
import numpy as np
import pytest

from tests.plugin.rigs import arm, plain_arm, run

EA, T0 = 500.0, 8.0


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "implicit", "RK4"])
def test_trajectories_equal_those_of_the_spatial_tendon(integrator):
    ours = arm(integrator=integrator, friction=0.0, axial_stiffness=EA, pretension=T0)
    unstretched = float(ours.tendon_length0[0]) / (1.0 + T0 / EA)
    theirs = plain_arm(EA / unstretched, unstretched, integrator=integrator)
    one, other = mujoco.MjData(ours), mujoco.MjData(theirs)
    one.qvel[:] = other.qvel[:] = [0.5, -0.3, 1.0]
    paths = np.empty((2, 3000, 3))
    for k in range(3000):
        mujoco.mj_step(ours, one)
        mujoco.mj_step(theirs, other)
        paths[:, k] = one.qpos, other.qpos
    travel = np.abs(paths).max()
    assert travel > 0.2, "the arm moves"
    assert np.abs(paths[0] - paths[1]).max() <= 1e-9 * travel
    assert one.sensor("unsolved").data[0] == 0


def test_a_slack_tendon_pushes_neither_here_nor_there():
    ours = arm(friction=0.0, axial_stiffness=EA, pretension=0.5)
    unstretched = float(ours.tendon_length0[0]) / (1.0 + 0.5 / EA)
    theirs = plain_arm(EA / unstretched, unstretched)
    one, other = mujoco.MjData(ours), mujoco.MjData(theirs)
    one.qvel[:] = other.qvel[:] = [-3.0, -3.0, -3.0]
    slack = 0
    for _ in range(1000):
        mujoco.mj_step(ours, one)
        mujoco.mj_step(theirs, other)
        slack += one.sensor("input_tension").data[0] == 0.0
        np.testing.assert_allclose(one.qpos, other.qpos, rtol=0, atol=1e-9)
    assert 0 < slack < 1000


def test_the_tension_is_the_same_all_along():
    model = arm(friction=0.0)
    data = mujoco.MjData(model)
    data.qvel[:] = 1.0
    for _ in range(200):
        run(model, data, 1)
        tension = data.sensor("tension").data
        np.testing.assert_allclose(tension, tension[0], rtol=1e-12)
        assert not data.sensor("friction_work").data.any()


def test_pretension_is_what_the_tendon_carries_at_qpos0():
    for friction in (0.0, 0.3):
        model = arm(friction=friction, pretension=12.5)
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        np.testing.assert_allclose(data.sensor("tension").data, 12.5, rtol=1e-10)


def test_where_a_simulation_starts_does_not_change_how_much_tendon_there_is():
    model = arm(friction=0.0, spools=True, axial_stiffness=EA, pretension=T0)
    there, moved = mujoco.MjData(model), mujoco.MjData(model)
    mujoco.mj_step(model, moved)
    for data in (there, moved):
        data.qpos[:] = [0.05, -0.1, 0.1, 0.3, 0.01]
        data.qvel[:] = 0.0
        mujoco.mj_forward(model, data)
    tension = there.sensor("tension").data
    assert tension.min() > T0
    np.testing.assert_allclose(tension, moved.sensor("tension").data, rtol=1e-9)
