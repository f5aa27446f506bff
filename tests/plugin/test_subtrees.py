"""Velocities of subtrees are there for whoever reads them, with a sheath or without."""

import mujoco
import numpy as np
import pytest

from tests.plugin.rigs import arm_xml


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
