"""Driven tendons without elasticity on Warp hold at rest, and move as the plugin's do."""

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction
from tests.guarantees.test_constraints import LIMITS, MECHANISMS
from tests.plugin.test_driven import ACTUATORS, TWO_TREES, arm, beside_a_damper
from tests.warp.models import DRIVEN, agrees, controls, fingers, mjw, put, step, tensions, tw
from tests.warp.test_against_plugin import agree, side_by_side

wp = pytest.importorskip("warp")

from tendon_mj.warp.support import simulated_sheaths  # noqa: E402

MOTOR = '<motor tendon="t" ctrlrange="-20 0"/>'
PULL, FRICTION = 20.0, 0.3


def unstated(**options):
    """Every kind of driven finger, none with a stated elasticity."""
    return fingers(**{"kinds": DRIVEN, "axial_stiffness": None} | options)


def slide(tendons=1, step=2e-3, friction=0.4, of_tendon="", damping=5.0, elasticity=None, **rest):
    """A mass on a slide that ropes pull over one bend each."""
    parts = {"motors": "", "stiffness": 0.0, "equality": ""} | rest
    ground = ends = paths = ""
    for i in range(tendons):
        y = 0.02 * i
        ground += f'<site name="a{i}" pos="0 {y} .3"/><site name="b{i}" pos=".5 {y} 0"/>'
        ends += f'<site name="c{i}" pos="0 {y} 0"/>'
        sites = "".join(f'<site site="{k}{i}"/>' for k in "abc")
        paths += f'<spatial name="t{i}" {of_tendon}>{sites}</spatial>'
    spec = mujoco.MjSpec.from_string(
        f"""<mujoco><option timestep="{step}" gravity="0 0 0"/>
      <worldbody>{ground}<body pos="1 0 0"><joint name="j" type="slide" axis="1 0 0"
        stiffness="{parts["stiffness"]}" damping="{damping}"/>
        <geom size=".03" mass="1" contype="0" conaffinity="0"/>{ends}</body></worldbody>
      <tendon>{paths}</tendon><actuator>{parts["motors"]}</actuator>{parts["equality"]}
      </mujoco>"""
    )
    names, law = [f"t{i}" for i in range(tendons)], {"axial_stiffness": elasticity}
    return add_friction(spec, names, friction=friction, **law).compile()


def shown(m, d, steps):
    """Output tensions and speeds, step by step."""
    sheaths, outputs, speeds = tw.sheaths_of(d), [], []
    for _ in range(steps):
        mjw.step(m, d)
        outputs.append(sheaths.output_tension.numpy()[0].copy())
        speeds.append(np.abs(d.qvel.numpy()).max())
    return np.array(outputs), np.array(speeds)


def test_many_tendons_on_a_joint_hold_a_load_that_friction_bears():
    motors = "".join(f'<motor tendon="t{i}"/>' for i in range(8))
    m, d = put(slide(8, motors=motors, stiffness=2e3))
    d.ctrl.fill_(-PULL / 8)
    load = 1.05 * PULL
    d.qpos.fill_(-load / 2e3)
    shown(m, d, 200)
    outputs, speeds = shown(m, d, 50)
    np.testing.assert_allclose(outputs.sum(axis=1), load, rtol=1e-5)
    assert speeds.max() < 1e-7
    assert not tw.sheaths_of(d).groups.flows.numpy().any()  # nothing slides, and no work is done


def test_elastic_tendons_on_a_joint_hold_a_load_together_as_the_plugin_s():
    motors = "".join(f'<motor tendon="t{i}"/>' for i in range(8))
    model = slide(8, motors=motors, stiffness=2e3, elasticity=1e5)
    m, d = put(model)
    data = mujoco.MjData(model)
    data.ctrl[:] = -PULL / 8
    data.qpos[:] = -1.05 * PULL / 2e3
    d.ctrl.fill_(-PULL / 8)
    d.qpos.fill_(-1.05 * PULL / 2e3)
    shown(m, d, 200)
    outputs, speeds = shown(m, d, 50)
    mujoco.mj_step(model, data, 200)
    sums = []
    for _ in range(50):
        mujoco.mj_step(model, data)
        sums.append(sum(data.sensor(f"t{i}_output_tension").data[0] for i in range(8)))
    np.testing.assert_allclose(outputs.sum(axis=1), sums, rtol=5e-3)
    assert speeds.max() < 2e-3  # 5e-3 where each yields by itself


def test_joints_at_their_limits_rest_at_steps_of_10_ms():
    spec = mujoco.MjSpec.from_file(str(MECHANISMS / "joint_limits.xml"))
    model = add_friction(spec, "*", friction=0.01).compile()
    data = mujoco.MjData(model)
    data.ctrl[:] = LIMITS
    mujoco.mj_step(model, data, 1500)
    m, d = tw.put_model(model), tw.put_data(model, data)
    shown(m, d, 20)
    outputs, speeds = shown(m, d, 50)
    assert speeds.max() < 1e-4
    assert np.ptp(outputs, axis=0).max() < 1e-4 * outputs.max()


def test_a_pull_that_reverses_at_a_limit_moves_the_joint_as_in_the_plugin():
    sites = "".join(
        f'<site name="a{k}" pos="-.1 0 {3 * z}"/>' for k, z in enumerate((0.015, -0.015))
    )
    sites += "".join(f'<site name="b{k}" pos="-.02 0 {z}"/>' for k, z in enumerate((0.015, -0.015)))
    paths = "".join(
        f'<spatial name="t{k}"><site site="a{k}"/><site site="b{k}"/><site site="c{k}"/></spatial>'
        for k in range(2)
    )
    spec = mujoco.MjSpec.from_string(
        f"""<mujoco><option timestep="5e-3" gravity="0 0 0" integrator="implicitfast"/>
      <worldbody>{sites}<body><joint name="j" axis="0 -1 0" armature="3.4e-4" damping=".004"
          range="-5 5"/><geom size=".01" mass=".01"/>
        <site name="c0" pos=".02 0 .015"/><site name="c1" pos=".02 0 -.015"/></body></worldbody>
      <tendon>{paths}</tendon>
      <actuator><motor tendon="t0"/><motor tendon="t1"/></actuator></mujoco>"""
    )
    model = add_friction(spec, "*", friction=0.5, extra_bend=2.0).compile()
    waits, steps = np.arange(3, 20), 25
    m, d = tw.put_model(model), tw.make_data(model, nworld=len(waits))
    pulls = np.where(np.arange(steps)[:, None, None] < waits[:, None], [-23.0, 0.0], [0.0, -23.0])
    for pull in pulls.astype(np.float32):
        wp.copy(d.ctrl, wp.array(pull, dtype=wp.float32))
        mjw.step(m, d)
    for world, own in enumerate(np.swapaxes(pulls, 0, 1)):
        data = mujoco.MjData(model)
        for pull in own:
            data.ctrl[:] = pull
            mujoco.mj_step(model, data)
        assert d.qpos.numpy()[world, 0] == pytest.approx(data.qpos[0], abs=1e-5)


LENGTH = float(np.hypot(0.5, 0.3)) + 0.5
ROPES = {
    "limit": {"of_tendon": f'limited="true" range="0 {LENGTH + 0.002}"'},
    "equality": {"equality": '<equality><tendon tendon1="t0"/></equality>'},
}


@pytest.mark.parametrize("rope", ROPES)
def test_a_rope_that_a_constraint_holds_comes_to_rest_under_its_load(rope):
    model = slide(friction=FRICTION, damping=20.0, motors='<motor joint="j"/>', **ROPES[rope])
    m, d = put(model)
    d.ctrl.fill_(PULL)
    shown(m, d, 800)
    outputs, _ = shown(m, d, 50)
    np.testing.assert_allclose(outputs, PULL, rtol=1e-5)


GROWING = """<mujoco><option timestep=".002" gravity="0 0 0"/>
<worldbody>
<site name="a" pos="-.06 0 .03"/><site name="b" pos="-.03 0 -.003"/>
<body><joint name="j" axis="0 1 0" damping=".001" armature="2e-5"/>
<geom type="capsule" fromto="0 0 0 .04 0 0" size=".008" mass=".02"/>
<site name="c" pos=".03 0 -.003"/></body></worldbody>
<tendon><spatial name="t"><site site="a"/><site site="b"/><site site="c"/></spatial></tendon>
<actuator><motor tendon="t"/><motor joint="j"/></actuator></mujoco>"""


def test_friction_holds_where_the_moment_arm_has_grown_since_the_first_evaluation():
    model = add_friction(mujoco.MjSpec.from_string(GROWING), "t", friction=FRICTION).compile()
    m, d = put(model)
    plain = mujoco.MjData(model)

    def pulled(load, towards):
        """One step under a load at a stiffness around an angle [N, rad]."""
        plain.qpos[:], plain.qvel[:] = d.qpos.numpy()[0], d.qvel.numpy()[0]
        mujoco.mj_fwdPosition(model, plain)
        torque = load * plain.ten_J[0] + 5.0 * (towards - plain.qpos[0]) - 0.02 * plain.qvel[0]
        d.ctrl.assign(np.array([[-PULL, torque]], np.float32))
        mjw.step(m, d)

    for k in range(600):
        pulled(PULL, 1.2 * (1.0 - np.cos(np.pi * min(1.0, 2e-3 * k))) / 2.0)
    d.qvel.zero_()
    angle, outputs = float(d.qpos.numpy()[0, 0]), []
    for _ in range(200):
        pulled(1.05 * PULL, angle)
        outputs.append(tw.sheaths_of(d).output_tension.numpy()[0, 0])
    np.testing.assert_allclose(outputs[20:], 1.05 * PULL, rtol=1e-4)
    assert not tw.sheaths_of(d).groups.flows.numpy().any()


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast"])
def test_friction_holds_beside_a_damper_between_two_trees_of_bodies(integrator):
    m, d = put(beside_a_damper(TWO_TREES, integrator))
    speeds = []
    for k in range(200):
        d.ctrl.assign(np.array([[20.0, 0.0]], np.float32))
        applied = 1.5 + 0.2 * np.sin(0.1 * k), 0.5 * np.sin(0.15 * k)
        d.qfrc_applied.assign(np.array([applied], np.float32))
        mjw.step(m, d)
        speeds.append(d.qvel.numpy()[0])
    held, other = np.abs(speeds).max(axis=0)
    assert held < 1e-5 * other


@agrees
@pytest.mark.parametrize("integrator", ["Euler", "implicitfast"])
def test_every_kind_of_drive_has_the_plugin_s_tensions_and_sensors(integrator):
    model = unstated(integrator=integrator)
    m, d = put(model)
    data = mujoco.MjData(model)
    plugin, warp, apart = side_by_side(model, d, m, data, 120)
    agree(plugin, warp, apart)
    for name, rows in tw.sheaths_of(d).segments.items():
        assert np.abs(plugin[:, rows] - warp[:, rows]).max() < 1e-3 * np.ptp(plugin[:, rows]), name
    largest = 1e-3 * np.abs(data.sensordata).max()
    np.testing.assert_allclose(d.sensordata.numpy()[0], data.sensordata, atol=largest)


@agrees
@pytest.mark.parametrize(
    "law",
    [
        {},
        {"static_friction": 0.4, "constant_friction": 0.3},
        {"stribeck_friction": 0.1, "stribeck_velocity": 0.05},
    ],
)
@pytest.mark.parametrize("drive", ["motor", "position", "general", "two"])
def test_an_arm_s_tensions_are_the_plugin_s(drive, law):
    model = arm(ACTUATORS[drive], 0.2, option='timestep=".001" integrator="implicitfast"', **law)
    m, d = put(model)
    agree(*side_by_side(model, d, m, mujoco.MjData(model), 150))


@pytest.mark.parametrize("path", ["a b c /2 c d /2 c d", "a b c d /2 b c d", "a b c /3 a d"])
def test_branches_at_pulleys_have_the_plugin_s_tensions(path):
    model = arm(MOTOR, 0.2, path=path, static_friction=0.3, constant_friction=0.2)
    m, d = put(model)
    agree(*side_by_side(model, d, m, mujoco.MjData(model), 150))


def test_without_friction_the_model_moves_as_mujoco_warp_s_own_to_the_bit():
    model, plain = (arm(ACTUATORS["position"], friction) for friction in (0.0, None))
    m, d = put(model)
    stock, stock_d = mjw.put_model(plain), mjw.make_data(plain)
    for control in controls(plain, 40):
        step(m, d, control)
        step(stock, stock_d, control)
    assert (d.qpos.numpy() == stock_d.qpos.numpy()).all()


def test_a_world_goes_there_and_back_unchanged_and_is_reset_alone():
    model = unstated(kinds=("drum", "bent", "limit"))
    data, again, inputs = mujoco.MjData(model), mujoco.MjData(model), controls(model, 40)
    for row in inputs[:20]:
        data.ctrl[:] = row
        mujoco.mj_step(model, data)
    m, d = tw.put_model(model), tw.put_data(model, data, 2)
    tw.get_data_into(again, model, d, 1)
    result, expected = (simulated_sheaths(model, each) for each in (again, data))
    for name, one in expected.items():
        guides = result[name].guides
        np.testing.assert_array_equal(guides["previous_slip"], one.guides["previous_slip"])
        np.testing.assert_allclose(result[name].unknown, one.unknown, rtol=1e-12)
        assert (guides["way"] == one.guides["way"]).all()
        for field in ("constraint_force", "previous_constraint", "finished"):
            assert result[name].state[field] == one.state[field]
    for row in inputs[20:30]:
        step(m, d, row)
    tw.get_data_into(data, model, d, 0)
    tw.reset_data(m, d, wp.array([True, False], dtype=wp.bool))
    fresh = tw.make_data(model)
    for row in inputs[30:]:
        data.ctrl[:] = row
        mujoco.mj_step(model, data)
        step(m, d, row)
        step(m, fresh, row)
    sheaths = tw.sheaths_of(d)
    assert (sheaths.tension.numpy()[0] == tw.sheaths_of(fresh).tension.numpy()[0]).all()
    np.testing.assert_allclose(sheaths.tension.numpy()[1], tensions(model, data), rtol=1e-3)


def test_each_world_with_friction_of_its_own_is_as_it_is_alone():
    model, friction = unstated(), np.array([0.0, 0.1, 0.35])
    m, inputs = tw.put_model(model), controls(model, 20)

    def run(friction):
        d = tw.make_data(model, len(friction))
        tw.sheaths_of(d).set("friction", friction[:, None])
        for row in inputs:
            step(m, d, row)
        return np.concatenate([d.qpos.numpy(), tw.sheaths_of(d).tension.numpy()], axis=1)

    together = run(friction)
    for row, one in zip(together, friction, strict=True):
        assert (row == run(one[None])[0]).all()
    assert np.ptp(together, axis=0).max() > 0.1
