"""What a simulation on Warp shows is what the plugin's shows, to single precision."""

import mujoco
import numpy as np
import pytest

from tendon_mj import remove_friction
from tests.engine.given_models import GIVEN, sheathed
from tests.warp.models import controls, fingers, fingers_xml, mjw, put, step, tensions, tw

STEPS = 80
OF_RANGE = 1e-3  # largest difference of a tension over the range of all


def side_by_side(model, d, m, data, steps, seed=0):
    """Tensions and qpos of the plugin and of Warp, step by step."""
    plugin, warp, apart = [], [], 0.0
    for control in controls(model, steps, seed):
        data.ctrl[:] = control
        mujoco.mj_step(model, data)
        step(m, d, control)
        plugin.append(tensions(model, data))
        warp.append(tw.sheaths_of(d).tension.numpy()[0].copy())
        apart = max(apart, np.abs(d.qpos.numpy()[0] - data.qpos).max())
    return np.array(plugin), np.array(warp), apart


def agree(plugin, warp, apart):
    assert np.ptp(plugin) > 1.0
    assert np.abs(plugin - warp).max() < OF_RANGE * np.ptp(plugin)
    assert apart < 1e-4


@pytest.fixture(scope="module")
def all_kinds():
    """Every kind of sheath in one model, after a while: model, data and both on the device."""
    model = fingers()
    m, d = put(model)
    data = mujoco.MjData(model)
    return model, data, m, d, side_by_side(model, d, m, data, STEPS)


def test_every_kind_of_sheath_has_the_plugin_s_tensions(all_kinds):
    _, data, _, d, (plugin, warp, apart) = all_kinds
    for name, rows in tw.sheaths_of(d).segments.items():
        span = np.ptp(plugin[:, rows])
        assert span > 0.5, name
        assert np.abs(plugin[:, rows] - warp[:, rows]).max() < 2 * OF_RANGE * span, name
    agree(plugin, warp, apart)
    assert not tw.sheaths_of(d).unsolved.numpy().any()
    assert np.ptp(data.qpos) > 0.05


def test_sensors_show_what_the_plugin_s_show(all_kinds):
    model, data, _, d, _ = all_kinds
    shown = d.sensordata.numpy()[0]
    for k in range(model.nsensor):
        adr, width = model.sensor_adr[k], model.sensor_dim[k]
        ours, plugin = shown[adr : adr + width], data.sensordata[adr : adr + width]
        exact = 1e-6 if "displacement" in model.sensor(k).name else 0.02
        np.testing.assert_allclose(ours, plugin, atol=exact, err_msg=model.sensor(k).name)


def test_a_simulation_goes_on_where_the_plugin_s_was(all_kinds):
    model, data, m, _, _ = all_kinds
    mujoco.mj_forward(model, data)
    d = tw.put_data(model, data)
    agree(*side_by_side(model, d, m, data, 30, seed=1))


def test_an_evaluation_more_in_a_step_changes_nothing():
    model = fingers()
    m, once = put(model)
    twice = tw.make_data(model)
    for control in controls(model, 15):
        step(m, once, control)
        twice.ctrl.assign(control[None])
        mjw.forward(m, twice)
        mjw.step(m, twice)
    assert (once.qpos.numpy() == twice.qpos.numpy()).all()
    assert (tw.sheaths_of(once).tension.numpy() == tw.sheaths_of(twice).tension.numpy()).all()


def test_without_friction_a_driven_tendon_moves_as_mujoco_warp_s_own():
    spec = mujoco.MjSpec.from_string(fingers_xml(kinds=("drum",), friction=0.0))
    model = spec.compile()
    plain = remove_friction(spec, "drum").compile()
    m, d = put(model)
    stock, stock_d = mjw.put_model(plain), mjw.make_data(plain)
    for control in controls(model, 60):
        step(m, d, control)
        step(stock, stock_d, control)
    np.testing.assert_allclose(d.qpos.numpy(), stock_d.qpos.numpy(), atol=1e-6)


def test_a_control_between_the_halves_of_a_step_drives_a_tendon_in_that_step():
    model = fingers(kinds=("drum",))
    m, whole = put(model)
    halves = tw.make_data(model)
    for control in controls(model, 10):
        step(m, whole, control)
        mjw.step1(m, halves)
        halves.ctrl.assign(control[None])
        mjw.step2(m, halves)
    pulled = tw.sheaths_of(whole).tension.numpy()
    assert pulled.max() > 0.1
    np.testing.assert_allclose(tw.sheaths_of(halves).tension.numpy(), pulled, rtol=1e-4)


@pytest.mark.filterwarnings("ignore::tendon_mj.TendonWarning")  # of guides on the last body
@pytest.mark.parametrize("name", GIVEN[:1])
def test_a_model_of_others_has_the_plugin_s_tensions(name):
    model = sheathed(name, friction=0.15, axial_stiffness=1e5)
    m, d = put(model)
    agree(*side_by_side(model, d, m, mujoco.MjData(model), 60))
