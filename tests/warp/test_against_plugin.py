"""A simulation on Warp agrees with the plugin's to single precision."""

import mujoco
import numpy as np
import pytest

from tendon_mj import add_cable_drive, remove_friction
from tendon_mj.plugin import segment_tensions
from tests.attach.test_motor import SLOW, servoed
from tests.plugin.test_reactions import DRIVES, simulate
from tests.rigs import GIVEN, sheathed
from tests.warp.models import agrees, controls, fingers, fingers_xml, mjw, put, step, tensions, tw

pytest.importorskip("warp")

from tendon_mj.warp.support import simulated_sheaths

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


@agrees
def test_every_kind_of_sheath_has_the_plugin_s_tensions(all_kinds):
    _, data, _, d, (plugin, warp, apart) = all_kinds
    for name, rows in tw.sheaths_of(d).segments.items():
        span = np.ptp(plugin[:, rows])
        assert span > 0.5, name
        assert np.abs(plugin[:, rows] - warp[:, rows]).max() < 2 * OF_RANGE * span, name
    agree(plugin, warp, apart)
    assert not tw.sheaths_of(d).unsolved.numpy().any()
    assert np.ptp(data.qpos) > 0.05


@agrees
def test_friction_that_fades_with_speed_is_the_plugin_s_there_and_back():
    model = fingers(stribeck_friction=0.2, stribeck_velocity=0.01)
    m, d = put(model)
    data, back = mujoco.MjData(model), mujoco.MjData(model)
    agree(*side_by_side(model, d, m, data, STEPS))
    tw.get_data_into(back, model, d)
    mujoco.mj_forward(model, data)  # commits the last step
    for name, sheath in simulated_sheaths(model, data).items():
        speeds = sheath.guides["sliding_speed"]
        got = simulated_sheaths(model, back)[name].guides["sliding_speed"]
        assert speeds.max() > 1e-3, name
        np.testing.assert_allclose(got, speeds, atol=1e-3 * speeds.max())


@agrees
def test_a_drum_with_play_winds_and_turns_its_drive_as_the_plugin_s():
    motor = '<actuator><motor joint="reel_joint" ctrlrange="-0.5 0.5"/></actuator>'
    model = fingers(kinds=("reel", "spools"), rest=motor, backlash=4e-3)
    m, d = put(model)
    data = mujoco.MjData(model)
    agree(*side_by_side(model, d, m, data, 300))
    loose = fingers(kinds=("reel", "spools"), rest=motor)
    other = mujoco.MjData(loose)
    for control in controls(loose, 300, 0):
        other.ctrl[:] = control
        mujoco.mj_step(loose, other)
    assert np.abs(other.qpos - data.qpos).max() > 1e-2, "the play makes a difference"


@agrees
def test_sensors_show_what_the_plugin_s_show(all_kinds):
    model, data, _, d, _ = all_kinds
    shown = d.sensordata.numpy()[0]
    for k in range(model.nsensor):
        adr, width = model.sensor_adr[k], model.sensor_dim[k]
        ours, plugin = shown[adr : adr + width], data.sensordata[adr : adr + width]
        exact = 1e-6 if "displacement" in model.sensor(k).name else 0.02
        if "torque" in model.sensor(k).name:
            exact = 1e-3 * np.abs(plugin).max() + 1e-4
        np.testing.assert_allclose(ours, plugin, atol=exact, err_msg=model.sensor(k).name)
    for name in ("cfrc_int", "cfrc_ext"):
        np.testing.assert_allclose(getattr(d, name).numpy()[0], getattr(data, name), atol=0.01)


@agrees
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


def test_a_control_in_a_step_drives_a_tendon_in_it_and_without_friction_as_mujoco_warp_s_own():
    spec = mujoco.MjSpec.from_string(fingers_xml(kinds=("drum",), friction=0.0))
    model = spec.compile()
    plain = remove_friction(spec, "drum").compile()
    m, d = put(model)
    halves = tw.make_data(model)
    stock, stock_d = mjw.put_model(plain), mjw.make_data(plain)
    for control in controls(model, 60):
        step(m, d, control)
        step(stock, stock_d, control)
        mjw.step1(m, halves)
        halves.ctrl.assign(control[None])
        mjw.step2(m, halves)
    np.testing.assert_allclose(d.qpos.numpy(), stock_d.qpos.numpy(), atol=1e-6)
    pulled = tw.sheaths_of(d).tension.numpy()
    assert pulled.max() > 0.1
    np.testing.assert_allclose(tw.sheaths_of(halves).tension.numpy(), pulled, rtol=1e-4)


def test_a_slack_tendon_pulls_where_the_plugin_s_does():
    model = fingers(kinds=("reel",), pretension=0.0, slack=9e-4, constant_friction=0.0)
    m, d = put(model)
    plugin, warp, apart = side_by_side(model, d, m, mujoco.MjData(model), STEPS)
    assert (plugin == 0.0).all(axis=1).any()
    agree(plugin, warp, apart)


@pytest.mark.parametrize(
    ("gear", "flags", "disabled", "winds"),
    [
        (-1.7, 0, 0b10, -1.7),
        (1.0, mujoco.mjtDisableBit.mjDSBL_CLAMPCTRL, 0, 1.0),
        (1.0, mujoco.mjtDisableBit.mjDSBL_ACTUATION, 0, 0.0),
        (1.0, 0, 0b01, 0.0),
    ],
)
def test_a_reel_winds_what_the_plugin_s_does(gear, flags, disabled, winds):
    # without actuation MuJoCo Warp's implicitfast moves a model without sheaths otherwise, too
    model = fingers(kinds=("reel",), integrator="Euler")
    model.actuator_gear[0, 0] = gear
    model.actuator_ctrllimited[0], model.actuator_ctrlrange[0] = bool(flags), (0.0, 1e-4)
    model.opt.disableflags |= int(flags)
    model.opt.disableactuator = disabled
    m, d = put(model)
    data = mujoco.MjData(model)
    for control in np.linspace(0.0, 5e-4, 40):
        data.ctrl[:] = control
        mujoco.mj_step(model, data)
        step(m, d, control)
    assert data.sensor("reel_reel_displacement").data[0] == pytest.approx(5e-4 * winds)
    shown = tw.sheaths_of(d).tension.numpy()[0]
    np.testing.assert_allclose(shown, tensions(model, data), rtol=2e-3)


def write_spring(model, m, k, rest):
    """Write stiffness and rest length to the first tendon, here and on the device."""
    model.tendon_stiffness[0], model.tendon_lengthspring[0] = k, rest
    m.tendon_stiffness.assign(model.tendon_stiffness[None])
    m.tendon_lengthspring.assign(model.tendon_lengthspring[None])


def test_what_is_written_to_a_cable_s_spring_acts_and_stays_after_a_reset():
    model = fingers(kinds=("cable",))
    m, d = put(model)
    data, rng = mujoco.MjData(model), np.random.default_rng(0)
    for _ in range(4):
        write_spring(model, m, rng.uniform(100, 600), rng.uniform(0.45, 0.5))
        agree(*side_by_side(model, d, m, data, 15))
    stiffness = tw.sheaths_of(d).parameters["axial_stiffness"].numpy()[0, 0]
    product = model.tendon_stiffness[0] * model.tendon_lengthspring[0, 1]
    assert stiffness == pytest.approx(product, rel=1e-6)
    mujoco.mj_resetData(model, data)
    tw.reset_data(m, d)
    agree(*side_by_side(model, d, m, data, 15))
    for each in (m, model):
        each.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_SPRING.value
    plugin, warp, apart = side_by_side(model, d, m, data, 5)
    assert not plugin.any()
    assert not warp.any()
    assert apart < 1e-4


@agrees
def test_a_second_look_at_the_sensors_changes_nothing():
    model = fingers(kinds=("cable",))
    m, d = put(model)
    step(m, d, np.zeros(model.nu))
    mjw.forward(m, d)
    before, inner = d.sensordata.numpy().copy(), d.cfrc_int.numpy().copy()
    mjw.sensor_acc(m, d, skip_rne_postconstraint=True)
    np.testing.assert_array_equal(d.cfrc_int.numpy(), inner)
    mjw.rne_postconstraint(m, d)  # as MuJoCo Warp has it, with one tension
    assert np.abs(d.cfrc_int.numpy() - inner).max() > 0.02
    mjw.sensor_acc(m, d)
    np.testing.assert_array_equal(d.cfrc_int.numpy(), inner)
    np.testing.assert_array_equal(d.sensordata.numpy(), before)


@agrees
@pytest.mark.parametrize(
    ("seed", "path", "drive"),
    [
        (0, "sites", "equality"),
        (1, "wraps", "cable"),
        (3, "wraps", "motor"),
        (6, "sites", "spools"),
    ],
)
def test_sensors_of_force_and_torque_of_an_arm_in_space_are_the_plugin_s(seed, path, drive):
    model, data = simulate(seed, path, drive, 100)
    m, d = tw.put_model(model), tw.put_data(model, data)
    mjw.forward(m, d)
    tension = segment_tensions(model, data, "sheath")[1]
    assert np.ptp(tension) > 0.05 * tension.max()  # friction acts
    within = 1e-4 * np.abs(data.sensordata).max()
    if drive == "spools":  # a wound cable turns what its path is rounded by into tension
        rounded = np.abs(d.site_xpos.numpy()[0] - data.site_xpos).max()
        stiffness = DRIVES[drive]["axial_stiffness"] / data.ten_length[0]
        within += stiffness * rounded * len(tension)
    np.testing.assert_allclose(d.sensordata.numpy()[0], data.sensordata, atol=within)


@pytest.mark.filterwarnings("ignore::tendon_mj.TendonWarning")  # of guides on the last body
@pytest.mark.parametrize("name", GIVEN[:1])
def test_a_model_of_others_has_the_plugin_s_tensions(name):
    model = sheathed(name, friction=0.15, axial_stiffness=1e3)
    m, d = put(model)
    agree(*side_by_side(model, d, m, mujoco.MjData(model), 60))


@agrees
def test_motors_with_joints_of_their_own_lose_the_same_motion():
    spec = servoed(kp=5.0, armature=1e-3, stiffness=0.5)
    spec.actuator("m").ctrlrange = [-0.5, 0.5]
    model = add_cable_drive(spec, "m", **SLOW).compile()
    m, d = put(model)
    agree(*side_by_side(model, d, m, mujoco.MjData(model), STEPS))
