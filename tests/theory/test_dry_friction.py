"""The frictionloss of a driven tendon takes what the capstan equation takes, in any array."""

import math

import mujoco
import numpy as np
import pytest

from experiments.benchmarks.frictionloss import STIFF_SOLIMP
from experiments.rewritten_frictionloss import joint_spec
from tendon_mj import frictionloss

TENSION, BEND, FRICTION = [0.0, -3.0, 10.0, 10.0, 25.0], [1.0, 1.0, 0.0, 2.0, 0.5], 0.2
VELOCITY = [-1.0, -1.0, 1.0, -0.5, 0.1]


@pytest.mark.parametrize(("velocity", "sign"), [(-0.1, -1.0), (0.1, 1.0)])
def test_what_arrives_is_the_capstan_equation(velocity, sign):
    loss = frictionloss(10.0, math.pi, 0.3, velocity)
    arrives = 10.0 + sign * loss  # more pulls at the load where the tendon is pulled out
    assert arrives == pytest.approx(10.0 * math.exp(sign * 0.3 * math.pi), rel=1e-14)


def test_no_tension_no_bend_and_no_friction_take_nothing():
    assert frictionloss(np.array(TENSION), np.array(BEND), 0.2, np.array(VELOCITY))[:3].max() == 0
    assert frictionloss(10.0, 1.0, 0.0, 1.0) == 0.0


@pytest.mark.parametrize("package", ["torch", "jax.numpy"])
def test_another_packages_arrays_have_the_numbers_of_numpy(package):
    xp = pytest.importorskip(package)
    tension, bend, velocity = (np.array(row, np.float32) for row in (TENSION, BEND, VELOCITY))
    for angle in (bend, 2.0):  # a constant bend may be a number
        expected = frictionloss(tension, angle, FRICTION, velocity)
        assert expected.dtype == np.float32
        given = (xp.asarray(x) if isinstance(x, np.ndarray) else x for x in (tension, angle))
        loss = frictionloss(*given, FRICTION, xp.asarray(velocity))
        assert isinstance(loss, type(xp.asarray(tension)))
        assert loss.dtype == xp.asarray(tension).dtype
        np.testing.assert_allclose(np.asarray(loss), expected, rtol=1e-5)


def test_in_mjx_it_moves_a_joint_as_in_mujoco():
    jax = pytest.importorskip("jax")
    mjx = pytest.importorskip("mujoco.mjx")
    model = joint_spec().compile()
    model.tendon_frictionloss[:] = 1e-9  # else the solver has no row for it
    model.tendon_solref_fri[:] = [2.0 * model.opt.timestep, 1.0]
    model.tendon_solimp_fri[:] = STIFF_SOLIMP
    data, put = mujoco.MjData(model), mjx.put_model(model)
    worlds = mjx.make_data(model)

    @jax.jit
    def step(worlds, control):
        loss = frictionloss(worlds.actuator_force, 1.2, FRICTION, worlds._impl.ten_velocity)
        return mjx.step(put.replace(tendon_frictionloss=loss + 1e-9), worlds.replace(ctrl=control))

    for control in 16.0 + 12.0 * np.sin(0.05 * np.arange(100)):
        loss = frictionloss(data.actuator_force, 1.2, FRICTION, data.ten_velocity)
        model.tendon_frictionloss[:] = loss + 1e-9
        data.ctrl[:] = control
        mujoco.mj_step(model, data)
        worlds = step(worlds, np.array([control], np.float32))
    assert abs(data.qpos[0]) > 0.1
    np.testing.assert_allclose(worlds.qpos, data.qpos, atol=1e-4)
