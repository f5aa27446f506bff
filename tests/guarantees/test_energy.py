"""The energy of a whole simulation: friction adds none where a step carries what it magnifies."""

import mujoco
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as some

from tendon_mj import add_friction, view_sheath
from tests.guarantees.random_tendon import INTEGRATORS, thorough

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
CARRIED = 0.25  # most of h² a k e^{μφ}
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


def gain(model, angle, friction=0.0):
    """How far the energy rises above any before, over that at the start; most of h² a k e^{μφ}."""
    data = mujoco.MjData(model)
    data.qpos[0] = angle
    mujoco.mj_forward(model, data)
    start = least = data.energy.sum()
    rises = carried = 0.0
    stiffness = model.opt.timestep**2 * model.tendon_stiffness[0] / model.dof_M0[0]
    for _ in range(int(0.3 / model.opt.timestep)):
        bend = view_sheath(model, data, "t").bend_angle.sum() if friction else 0.0
        magnified = stiffness * data.ten_J.ravel()[0] ** 2 * np.exp(friction * bend)
        carried = max(carried, magnified)
        mujoco.mj_step(model, data)
        rises, least = max(rises, data.energy.sum() - least), min(least, data.energy.sum())
    return rises / start, carried


def with_friction(xml, **law):
    return add_friction(mujoco.MjSpec.from_string(xml), "t", **law).compile()


@pytest.mark.filterwarnings("ignore::tendon_mj.TendonWarning")
@thorough
@given(links, some.floats(0.01, 5.0), some.floats(1.0, 2.0), some.floats(-0.6, 0.6))
def test_friction_adds_no_energy_where_a_step_carries_what_it_magnifies(xml, most, ratio, angle):
    own, _ = gain(mujoco.MjModel.from_xml_string(xml), angle)
    rough = with_friction(xml, friction=most / ratio, static_friction=most)
    added, carried = gain(rough, angle, most)
    assume(own < ERROR and carried < CARRIED)
    assert added <= own + ERROR


@pytest.mark.filterwarnings("ignore::tendon_mj.TendonWarning")
def test_beyond_that_a_link_may_gain_energy():
    # the range of the promise is one: what `tendon-mj attach` warns of does happen
    values = {"high": 0.0355, "low": 0.024, "mass": 0.1564, "damping": 0.0, "rest": 0.1}
    xml = link(step=5e-3, integrator="Euler", stiffness=2000.0, **values)
    rough = with_friction(xml, friction=5.0)
    added, carried = max(gain(rough, angle, 5.0) for angle in np.linspace(-0.6, 0.6, 13))
    assert carried > 1.0
    assert added > 0.1
