"""A driven tendon's input tension is the plugin's: all parts of what pulls, after all limits."""

import mujoco
import numpy as np
import pytest

from tests.plugin.test_driven import ACTUATORS, arm
from tests.warp.models import VERSION, controls, mjw, put, step, tw

wp = pytest.importorskip("warp")

DRIVES = {name: (actuator, "") for name, actuator in ACTUATORS.items()} | {
    "damped": ('<general tendon="t" gear="2" damping="9" ctrlrange="-5 0"/>', 'damping=".4"'),
    "one of two damped": (
        '<motor tendon="t" ctrlrange="-3 0"/>'
        '<general tendon="t" gear=".5" damping="20" ctrlrange="-20 0"/>',
        "",
    ),
    "both damped": (
        '<general tendon="t" gear="2" damping="4" ctrlrange="-3 0"/>'
        '<general tendon="t" damping="8" ctrlrange="-5 0"/>',
        "",
    ),
    "cogging": (
        '<dcmotor tendon="t" resistance="1" motorconst="2" cogging="2 30 0" ctrlrange="-5 0"/>',
        "",
    ),
    "LuGre": (
        '<dcmotor tendon="t" resistance="1" motorconst="2" lugre="1000 10 3 4 .1" '
        'ctrlrange="-5 0"/>',
        "",
    ),
    "limited in sum": (
        '<motor tendon="t" ctrlrange="-8 0"/><motor tendon="t" gear="2" ctrlrange="-6 0"/>',
        'actuatorfrcrange="-7 0" actuatorfrclimited="true"',
    ),
}


def input_tensions(model, m, d, steps=60):
    """The plugin's and Warp's, step by step."""
    data, plugin, warp = mujoco.MjData(model), [], []
    for control in controls(model, steps):
        data.ctrl[:] = control
        mujoco.mj_step(model, data)
        step(m, d, control)
        plugin.append(data.sensordata[0])
        warp.append(tw.sheaths_of(d).input_tension.numpy()[0, 0])
    return np.array(plugin), np.array(warp)


def agree(plugin, warp):
    assert np.ptp(plugin) > 1.0
    np.testing.assert_allclose(warp, plugin, atol=2e-3 * np.ptp(plugin))


@pytest.mark.parametrize("drive", DRIVES)
def test_the_input_tension_is_the_plugin_s(drive):
    actuator, tendon = DRIVES[drive]
    model = arm(actuator, 0.2, tendon)
    m, d = put(model)
    agree(*input_tensions(model, m, d))
    np.testing.assert_array_equal(tw.sheaths_of(d).unsolved.numpy(), 0)


def test_forces_of_actuators_are_those_without_a_sheath():
    actuator, tendon = DRIVES["LuGre"]
    m, d = put(arm(actuator, 0.0, tendon))
    plain = arm(actuator, tendon=tendon)
    stock, stock_d = mjw.put_model(plain), mjw.make_data(plain)
    for control in controls(plain, 30):
        step(m, d, control)
        step(stock, stock_d, control)
        np.testing.assert_allclose(
            d.actuator_force.numpy(), stock_d.actuator_force.numpy(), rtol=1e-4, atol=1e-4
        )


@wp.kernel
def add(value: float, force: wp.array2d[float]) -> None:
    world, actuator = wp.tid()
    force[world, actuator] += value


def test_what_a_callback_of_one_s_own_adds_to_an_actuator_pulls():
    model = arm(ACTUATORS["limited"], 0.2)
    m, d = put(model)
    ours = m.callback.act_bias

    def biased(m, d):
        wp.launch(add, dim=d.actuator_force.shape, inputs=[-2.0, d.actuator_force])
        ours(m, d)

    m.callback.act_bias = biased
    for control in (-4.0, -20.0):  # the second beyond the limit; MuJoCo Warp 4.0 limits the sum
        step(m, d, np.array([control]))
        pulls = -d.actuator_force.numpy()
        assert pulls >= 6.0
        np.testing.assert_allclose(tw.sheaths_of(d).input_tension.numpy(), pulls, rtol=1e-6)


def test_the_damping_that_each_world_s_actuator_has_on_the_device_counts():
    if VERSION < (4, 0):
        pytest.skip("MuJoCo Warp before 4.0 has it in tendon_damping")
    actuator, tendon = DRIVES["damped"]
    model = arm(actuator, 0.2, tendon)
    m, d = put(model)
    model.actuator_damping[:] = 30.0
    m.actuator_damping.fill_(30.0)
    agree(*input_tensions(model, m, d))
