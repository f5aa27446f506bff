"""Sheaths beside MuJoCo's own options and quantities: springs off, velocities of subtrees."""

import mujoco
import numpy as np
import pytest

from tests.plugin.rigs import arm_xml, driven, hand, reeled, unpacked

OFF = mujoco.mjtDisableBit.mjDSBL_SPRING | mujoco.mjtDisableBit.mjDSBL_DAMPER


def test_a_sheath_that_is_wound_acts_all_the_same():
    model = hand(friction=0.1).compile()
    model.jnt_stiffness[:], model.dof_damping[:] = 0.0, 0.0
    plain, data = mujoco.MjData(model), mujoco.MjData(model)
    plain.qvel[:] = data.qvel[:] = 0.01
    mujoco.mj_step(model, plain, 20)
    model.opt.disableflags |= OFF
    mujoco.mj_step(model, data, 20)
    np.testing.assert_allclose(data.qpos, plain.qpos, rtol=1e-9, atol=1e-12)
    assert unpacked(model, data)[0].unsolved == 0.0


def test_reels_wind_all_the_same():
    model = reeled()
    model.opt.disableflags |= OFF
    data = mujoco.MjData(model)
    data.ctrl[:] = 1e-3
    mujoco.mj_step(model, data, 3)
    assert data.sensor("input_tension").data[0] > 25.0


def test_one_that_is_driven_counts_that_it_was_left_out():
    model = driven()
    model.opt.disableflags |= OFF
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 3)
    assert unpacked(model, data, "wrapped_sheath")[0].unsolved == 3.0


def moving(xml):
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    data.qvel[:] = np.linspace(0.5, 1.5, model.nv)
    mujoco.mj_forward(model, data)
    return model, data


def with_sensor(sensor):
    xml = arm_xml(views=("input_tension",))
    return xml.replace("<sensor>", f"<sensor>{sensor}", 1)


@pytest.mark.parametrize("kind", ["subtreelinvel", "subtreeangmom"])
def test_a_sensor_of_a_subtree_shows_its_velocity(kind):
    model, data = moving(with_sensor(f'<{kind} name="seen" body="upper"/>'))
    shown = data.sensor("seen").data.copy()
    mujoco.mj_subtreeVel(model, data)
    row = {"subtreelinvel": data.subtree_linvel, "subtreeangmom": data.subtree_angmom}[kind]
    np.testing.assert_array_equal(shown, row[model.body("upper").id])
    assert np.abs(shown).max() > 0.0


def test_whoever_asks_for_them_gets_them():
    model, data = moving(with_sensor(""))
    mujoco.mj_subtreeVel(model, data)
    momentum = model.body_subtreemass[1] * data.subtree_linvel[1]
    jacobian, total = np.zeros((3, model.nv)), np.zeros(3)
    for body in range(1, model.nbody):
        mujoco.mj_jacBodyCom(model, data, jacobian, None, body)
        total += model.body_mass[body] * jacobian @ data.qvel
    np.testing.assert_allclose(momentum, total, rtol=1e-12)
