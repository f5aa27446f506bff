"""Sheaths beside MuJoCo's equalities, limits, options and quantities of subtrees."""

import mujoco
import numpy as np
import pytest

from tendon_mj import TendonWarning, add_friction, view_sheath
from tests.rigs import (
    STILL,
    arm_xml,
    driven,
    hand,
    reeled,
    restore,
    rope,
    simulated,
    snapshot,
    spatial,
    unpacked,
)

COUPLED = rope(
    "a0 -.3 0 0; b0 -.3 .1 0; b1 0 .1 0",
    "a1",
    "a0 a1",
    name="a",
    joint='name="a" type="slide" axis="1 0 0" stiffness="20" damping="8"',
    geom='size=".01" mass=".2"',
    option=STILL,
    tendons=spatial("b", "b0 b1 b2"),
    actuator='<motor name="pull" tendon="a" gear="-1"/>',
    rest="""<worldbody><body pos="0 .1 .2">
      <joint name="b" type="slide" axis="0 0 1" stiffness="30" damping="8"/>
      <geom size=".01" mass=".2"/><site name="b2"/></body></worldbody>
      <equality><tendon tendon1="b" tendon2="a" polycoef="0 {ratio} 0 0 0" solref=".004 1"/>
      </equality>""",
)

ROPE = rope(
    "g",
    "e",
    "d g e",
    name="rope",
    tendon='range="0 .22" solreflimit=".004 1"',
    body='pos="0 0 .1"',
    joint='name="load" type="slide" axis="0 0 1" stiffness="100" damping="2"',
    geom='size=".01" mass=".2"',
    option=STILL + ' integrator="implicitfast"',
    world="""<body pos="-.1 0 0"><joint name="drive" type="slide" axis="-1 0 0" damping="2"/>
      <geom size=".01" mass=".2"/><site name="d"/></body>""",
    actuator='<motor name="push" joint="drive"/>',
)


def pulled(spec, force, steps=6000):
    model = spec.compile()
    data = mujoco.MjData(model)
    for k in range(steps):
        data.ctrl[0] = force * min(1.0, 2.0 * k / steps)
        mujoco.mj_step(model, data)
    return model, data


@pytest.mark.parametrize("ratio", [1.0, 0.5])
def test_a_cable_that_an_equality_pulls_rubs_and_relieves_the_one_that_pulls_it(ratio):
    spec = mujoco.MjSpec.from_string(COUPLED.format(ratio=ratio))
    with pytest.warns(TendonWarning, match="a"):  # has nothing to rub on
        add_friction(spec, "*", friction=0.2)
    model, data = pulled(spec, 4.0)
    a, b = (view_sheath(model, data, name) for name in "ab")
    arrives = np.exp(-0.2 * np.pi / 2)
    handed = float(b.input_tension)  # of obj1; obj2 bears it times the slope of the polynomial
    assert handed > 1.0
    assert handed == pytest.approx(-float(data.efc_force[0]), rel=1e-2)
    assert b.output_tension / b.input_tension == pytest.approx(arrives, rel=1e-2)
    assert float(a.input_tension) == pytest.approx(4.0 - ratio * handed, rel=1e-2)
    np.testing.assert_allclose(-20 * data.qpos[0], a.output_tension, rtol=1e-2)
    np.testing.assert_allclose(-30 * data.qpos[1], b.output_tension, rtol=1e-2)


def test_an_equality_is_found_behind_others():
    text = COUPLED.format(ratio=0.5)
    others = "<weld body1='there' body2='here' active='false'/>" * 3
    bodies = "<body name='there'/><body name='here'/>"
    among = text.replace("<equality>", f"<equality>{others}")
    among = among.replace("</worldbody>", f"{bodies}</worldbody>", 1)
    runs = []
    for each in (text, among):
        with pytest.warns(TendonWarning, match="a"):
            spec = add_friction(mujoco.MjSpec.from_string(each), "*", friction=0.2)
        model, data = pulled(spec, 4.0, 1000)
        runs.append(view_sheath(model, data, "a").input_tension)
    assert runs[0] == pytest.approx(runs[1], rel=1e-9)


@pytest.mark.parametrize("given", [{}, {"axial_stiffness": 2e4}])
def test_a_rope_by_its_range_is_as_long_and_loses_what_the_capstan_says(given):
    spec = add_friction(mujoco.MjSpec.from_string(ROPE), "rope", friction=0.3, **given)
    model, data = pulled(spec, 10.0)
    view, ends = view_sheath(model, data, "rope"), []
    for _ in range(500):  # at rest friction holds within what it could, all but the last per cent
        mujoco.mj_step(model, data)
        ends.append((float(view.input_tension), float(view.output_tension)))
    pull, load = np.mean(ends, axis=0)
    assert pull == pytest.approx(10.0, rel=1e-3)
    assert load / pull == pytest.approx(np.exp(-0.3 * np.pi / 2), rel=2e-2)
    assert -100 * data.joint("load").qpos[0] == pytest.approx(load, rel=2e-3)
    assert float(data.ten_length[0]) == pytest.approx(0.22, abs=1e-3)
    drawn = float(data.joint("drive").qpos[0])
    model.tendon_range[0, 1] -= 0.01
    mujoco.mj_step(model, data, 4000)
    assert float(data.ten_length[0]) == pytest.approx(0.21, abs=1e-3)
    assert data.joint("drive").qpos[0] < drawn - 5e-3


@pytest.mark.parametrize("text", [COUPLED.format(ratio=1.0), ROPE])
@pytest.mark.filterwarnings("ignore::tendon_mj.TendonWarning")
def test_without_friction_the_model_moves_as_without_a_sheath(text):
    plain = pulled(mujoco.MjSpec.from_string(text), 5.0, 2000)[1]
    spec = add_friction(mujoco.MjSpec.from_string(text), "*", friction=0.0)
    np.testing.assert_array_equal(plain.qpos, pulled(spec, 5.0, 2000)[1].qpos)
    assert np.abs(plain.qpos).max() > 0.01


def test_a_state_that_is_handed_on_continues_bit_for_bit():
    model, data = pulled(add_friction(mujoco.MjSpec.from_string(ROPE), "rope", friction=0.3), 8.0)
    other = mujoco.MjData(model)
    restore(model, other, snapshot(model, data))
    for d in (data, other):
        d.ctrl[0] = 3.0
        mujoco.mj_step(model, d, 50)
    np.testing.assert_array_equal(data.qpos, other.qpos)
    np.testing.assert_array_equal(data.plugin_state, other.plugin_state)


@pytest.mark.parametrize("given", [{"pretension": 0.0}, {"slack": 1e-2}])
def test_a_limit_past_a_held_tendon_is_reported_with_the_length_that_it_allows(given):
    spec = mujoco.MjSpec.from_string(ROPE)
    with pytest.warns(TendonWarning, match="rope.*limit.*mm"):
        add_friction(spec, "rope", friction=0.3, axial_stiffness=2e4, **given)


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
    data = simulated(model, 3, ctrl=1e-3)
    assert data.sensor("input_tension").data[0] > 25.0


def test_one_that_is_driven_counts_that_it_was_left_out():
    model = driven()
    model.opt.disableflags |= OFF
    data = simulated(model, 3)
    assert unpacked(model, data, "wrapped_sheath")[0].unsolved == 3.0


def moving(xml):
    model = mujoco.MjModel.from_xml_string(xml)
    data = simulated(model, qvel=np.linspace(0.5, 1.5, model.nv))
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
