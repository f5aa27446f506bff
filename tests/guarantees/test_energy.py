"""The energy of a whole simulation: friction adds none."""

import mujoco
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as some

from tendon_mj import add_cable_drive, add_friction
from tests.guarantees.random_tendon import INTEGRATORS, thorough
from tests.guarantees.test_rest import tree

LINK = """<mujoco><option timestep="{step}" integrator="{integrator}" gravity="0 0 0">
    <flag energy="enable"/></option><default><geom contype="0" conaffinity="0"/></default>
  <worldbody><site name="a" pos="-.2 0 .06"/><site name="b" pos="-.07 0 {high}"/>
    <body><joint name="j" axis="0 1 0" damping="{damping}"/>{drum}
      <geom type="capsule" fromto="0 0 0 .2 0 0" size=".01" mass="{mass}"/>
      <site name="c" pos=".05 0 {low}"/><site name="d" pos=".1 0 .02"/></body></worldbody>
  <tendon><spatial name="t" stiffness="{stiffness}" springlength="{rest}">
    <site site="a"/><site site="b"/>{over}<site site="c"/><site site="d"/></spatial></tendon>
  <actuator><motor tendon="t"/></actuator></mujoco>"""
DRUM = '<geom name="g" type="cylinder" size=".015 .05" euler="90 0 0" mass=".01"/>'
RESOLVED = 0.03  # rad that a joint turns by in a step
ERROR = 0.05  # of the energy at the start: what a step that resolves the motion is off by


def link(*, drum=True, **values):
    """A link on a tendon with a spring of its own, and with a motor that is idle."""
    over = '<geom geom="g"/>' if drum else ""
    return LINK.format(drum=DRUM if drum else "", over=over, **values)


links = some.builds(
    link,
    step=some.sampled_from([5e-4, 1e-3, 2e-3, 5e-3]),
    integrator=some.sampled_from(INTEGRATORS),
    high=some.floats(0.03, 0.05),
    low=some.floats(0.02, 0.05),
    mass=some.floats(0.05, 0.5),
    damping=some.sampled_from([0.0, 0.01]),
    stiffness=some.sampled_from([80.0, 600.0, 2000.0]),
    rest=some.sampled_from([0.1, 0.25]),
    drum=some.booleans(),
)


def gain(model, angle):
    """How far the energy rises above any before, over that at the start, inf if that fails; h ω."""
    data = mujoco.MjData(model)
    data.qpos[:] = angle
    mujoco.mj_forward(model, data)
    start = least = data.energy.sum()
    rises = fastest = 0.0
    for _ in range(int(0.3 / model.opt.timestep)):
        mujoco.mj_step(model, data)
        rises, least = max(rises, data.energy.sum() - least), min(least, data.energy.sum())
        fastest = max(fastest, np.abs(data.qvel).max())
    failed = data.warning.number.any()
    return np.inf if failed else rises / start, fastest * model.opt.timestep


def with_friction(xml, **law):
    return add_friction(mujoco.MjSpec.from_string(xml), "t", **law).compile()


@pytest.mark.filterwarnings("ignore::tendon_mj.TendonWarning")
@thorough
@given(links, some.floats(0.01, 5.0), some.floats(1.0, 2.0), some.floats(-0.6, 0.6))
def test_friction_adds_no_energy_to_a_link_on_a_spring(xml, most, ratio, angle):
    own, _ = gain(mujoco.MjModel.from_xml_string(xml), angle)
    assume(own < ERROR)
    rough = with_friction(xml, friction=most / ratio, static_friction=most)
    assert gain(rough, angle)[0] <= own + ERROR


def on_springs(seed, links, tendons, step, integrator, stiffness):
    """A random tree whose tendons are springs, and whose energy is computed."""
    spec = tree(np.random.default_rng(seed), links, tendons, step, integrator)
    spec.option.gravity = np.zeros(3)
    spec.option.enableflags = mujoco.mjtEnableBit.mjENBL_ENERGY
    for tendon in spec.tendons:
        tendon.stiffness[0] = stiffness
    return spec


@pytest.mark.filterwarnings("ignore::tendon_mj.TendonWarning")
@thorough
@given(
    seed=some.integers(0, 2**32 - 1),
    links=some.integers(1, 3),
    step=some.sampled_from([1e-4, 5e-4, 1e-3, 2e-3]),
    integrator=some.sampled_from([0, 1, 2, 3]),
    stiffness=some.sampled_from([300.0, 3000.0, 30000.0]),
    friction=some.floats(0.05, 1.0),
)
def test_friction_adds_no_energy_to_a_tree_on_springs(
    seed, links, step, integrator, stiffness, friction
):
    spec = on_springs(seed, links, 2, step, integrator, stiffness)
    own, turn = gain(spec.compile(), 0.4)
    assume(own < ERROR and turn < RESOLVED)
    rough = add_friction(spec, "*", friction=friction, static_friction=1.5 * friction).compile()
    assert gain(rough, 0.4)[0] <= own + ERROR


@pytest.mark.filterwarnings("ignore::tendon_mj.TendonWarning")
@pytest.mark.parametrize("seed", [13, 19, 37, 41, 54, 60])
def test_friction_magnifies_no_spring_within_a_step_of_runge_kutta(seed):
    spec = on_springs(seed, 2, 1, 1e-3, 1, 3e4)
    assert gain(spec.compile(), 0.4)[0] < ERROR
    rough = add_friction(spec, "*", friction=1.5, static_friction=2.25).compile()
    assert gain(rough, 0.4)[0] < ERROR


def given_and_taken(stock, model, controls, steps):
    """Energy that friction gives to joints and takes from them while pulls change [J]."""
    data, plain = mujoco.MjData(model), mujoco.MjData(stock)
    gives = takes = 0.0
    for control, count in zip(controls, steps, strict=True):
        data.ctrl[:] = control
        for _ in range(count):
            plain.qpos[:], plain.qvel[:] = data.qpos, data.qvel
            mujoco.mj_forward(stock, plain)
            mujoco.mj_step(model, data)
            friction = data.qfrc_passive - plain.qfrc_passive
            work = model.opt.timestep * friction @ data.qvel
            gives, takes = gives + max(0.0, work), takes + max(0.0, -work)
    return gives, takes


def largest_turn(model, controls, steps):
    """Largest angle that a joint turns by in a step."""
    data, speed = mujoco.MjData(model), 0.0
    for control, count in zip(controls, steps, strict=True):
        data.ctrl[:] = control
        for _ in range(count):
            mujoco.mj_step(model, data)
            speed = max(speed, np.abs(data.qvel).max())
    return model.opt.timestep * (np.inf if data.warning.number.any() else speed)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_pull_that_reverses_at_a_limit_gets_no_energy_from_friction(integrator):
    spec = mujoco.MjSpec.from_string(
        f"""<mujoco><option timestep="2e-3" integrator="{integrator}" gravity="0 0 0"/><worldbody>
        <body><joint name="j" axis="0 1 0" armature="3.4e-4" damping=".004" range="-.1 .1"/>
        <geom size=".01" mass=".01"/></body></worldbody>
        <actuator><motor name="a" joint="j"/></actuator></mujoco>"""
    )
    stock = spec.compile()
    model = add_cable_drive(spec, "a", radius=0.015, bend=2.5, friction=0.4).compile()
    for wait in range(5, 30):
        gives, takes = given_and_taken(stock, model, [[0.35], [-0.35]], [wait, 15])
        assert gives < 1e-2 * takes


@pytest.mark.filterwarnings("ignore::tendon_mj.TendonWarning")
@thorough
@given(
    seed=some.integers(0, 2**32 - 1),
    links=some.integers(1, 3),
    tendons=some.integers(1, 2),
    step=some.sampled_from([5e-4, 1e-3, 2e-3]),
    integrator=some.sampled_from([0, 2, 3]),
    stiffness=some.sampled_from([0.0, 300.0, 3000.0, 30000.0]),
)
def test_pulls_that_change_get_no_energy_from_friction(
    seed, links, tendons, step, integrator, stiffness
):
    """Motors of joints between limits, and servos of free ones."""
    rng = np.random.default_rng(seed)
    spec = tree(rng, links, tendons, step, integrator)
    for joint in spec.joints:
        joint.limited, joint.damping[0] = not stiffness, rng.uniform(0.001, 0.005)
        joint.range = rng.uniform(0.02, 0.5) * np.array([-1.0, 1.0])
    for actuator in spec.actuators if stiffness else ():
        actuator.set_to_position(kp=stiffness)
    stock = spec.compile()
    model = add_friction(spec, "*", friction=rng.uniform(0.05, 0.8)).compile()
    controls = rng.uniform(-1.0, 0.0, (40, tendons)) * (rng.random((40, tendons)) < 0.6)
    controls = controls * 0.02 + stock.tendon_length0 if stiffness else controls * 20.0
    steps = rng.integers(1, 40, 40)
    assume(largest_turn(stock, controls, steps) < RESOLVED)
    gives, takes = given_and_taken(stock, model, controls, steps)
    assert gives <= ERROR * takes + 2e-5  # J; pulls do some 0.1 J
