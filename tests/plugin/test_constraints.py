"""Sheaths beside MuJoCo's equalities, limits, options and quantities of subtrees."""

import mujoco
import numpy as np
import pytest

from tendon_mj import TendonWarning, add_friction, view_sheath
from tendon_mj.plugin import sheaths
from tests.rigs import (
    STILL,
    arm_xml,
    driven,
    hand,
    reeled,
    rope,
    sheath_view,
    simulated,
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


@pytest.mark.parametrize("others", ["", "<weld body1='there' body2='here' active='false'/>" * 3])
@pytest.mark.parametrize("ratio", [1.0, 0.5])
def test_a_cable_that_an_equality_pulls_rubs_and_relieves_the_one_that_pulls_it(ratio, others):
    text = COUPLED.format(ratio=ratio).replace("<equality>", f"<equality>{others}")
    bodies = "<body name='there'/><body name='here'/>"
    spec = mujoco.MjSpec.from_string(text.replace("</worldbody>", f"{bodies}</worldbody>", 1))
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


def test_behind_a_guide_that_nothing_moves_tension_follows_the_capstan_law_too():
    """As at a peg on the link on which the cable ends, under the growing force of an equality."""
    text = COUPLED.format(ratio=1.0).replace("b0 b1 b2", "b0 b1 b2 b3")
    text = text.replace('<site name="b2"/>', '<site name="b2"/><site name="b3" pos=".05 0 .02"/>')
    spec = add_friction(mujoco.MjSpec.from_string(text), "b", friction=0.2)
    model, data = pulled(spec, 4.0)
    view = view_sheath(model, data, "b")
    bends = np.array(view.bend_angle)
    assert bends.min() > 0.5
    ratios = view.tension[1:] / view.tension[:-1]
    np.testing.assert_allclose(ratios, np.exp(-0.2 * bends), rtol=1e-3)


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


@pytest.mark.parametrize("given", [{"pretension": 0.0}, {"slack": 1e-2}])
def test_a_limit_past_a_held_tendon_is_reported_with_the_length_that_it_allows(given):
    spec = mujoco.MjSpec.from_string(ROPE)
    with pytest.warns(TendonWarning, match="rope.*limit.*mm"):
        add_friction(spec, "rope", friction=0.3, axial_stiffness=2e4, **given)


OFF = mujoco.mjtDisableBit.mjDSBL_SPRING | mujoco.mjtDisableBit.mjDSBL_DAMPER


def held_hand():
    return hand(friction=0.1).compile()


@pytest.mark.parametrize(("make", "control", "least"), [(held_hand, 0, 0.0), (reeled, 1e-3, 25)])
def test_a_sheath_that_is_wound_acts_all_the_same(make, control, least):
    model = make()
    model.jnt_stiffness[:], model.dof_damping[:] = 0.0, 0.0
    plain = simulated(model, 20, qvel=0.01, ctrl=control)
    model.opt.disableflags |= OFF
    data = simulated(model, 20, qvel=0.01, ctrl=control)
    np.testing.assert_allclose(data.qpos, plain.qpos, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(data.sensordata, plain.sensordata, rtol=1e-9, atol=1e-12)
    assert data.sensor("input_tension").data[0] >= least
    assert not any(sheath_view(model, data, name).state.unsolved for name in sheaths(model))


def test_one_that_is_driven_acts_all_the_same():
    model = driven()
    model.tendon_damping[:] = 0.0
    model.tendon_lengthspring[:] = [0.0, 10.0]  # none of which is left
    model.jnt_stiffness[:], model.dof_damping[:] = 0.0, 0.0
    plain = simulated(model, 20, qvel=0.5, ctrl=-3.0)
    model.opt.disableflags |= OFF
    data = simulated(model, 20, qvel=0.5, ctrl=-3.0)
    np.testing.assert_allclose(data.qpos, plain.qpos, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(data.sensordata, plain.sensordata, rtol=1e-9, atol=1e-12)
    assert not unpacked(model, data, "wrapped_sheath")[0].unsolved
    assert unpacked(model, data, "wrapped_sheath")[1]["tension"][0] == pytest.approx(3.0)


def test_velocities_of_subtrees_are_those_of_the_bodies_by_sensor_and_on_demand():
    sensors = '<subtreelinvel body="upper"/><subtreeangmom body="upper"/>'
    text = arm_xml(views=("input_tension",)).replace("<sensor>", f"<sensor>{sensors}", 1)
    model = mujoco.MjModel.from_xml_string(text)
    data = simulated(model, qvel=np.linspace(0.5, 1.5, model.nv))
    shown = data.sensordata[:6].copy()
    assert np.abs(shown).reshape(2, 3).max(axis=1).min() > 0.0
    mujoco.mj_subtreeVel(model, data)
    upper = model.body("upper").id
    asked = [data.subtree_linvel[upper], data.subtree_angmom[upper]]
    np.testing.assert_array_equal(shown, np.concatenate(asked))
    jacobian, total = np.zeros((3, model.nv)), np.zeros(3)
    for body in range(1, model.nbody):
        mujoco.mj_jacBodyCom(model, data, jacobian, None, body)
        total += model.body_mass[body] * jacobian @ data.qvel
    np.testing.assert_allclose(model.body_subtreemass[upper] * shown[:3], total, rtol=1e-12)
