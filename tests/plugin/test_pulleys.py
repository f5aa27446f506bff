"""Sheaths on tendons that branch at pulleys."""

import mujoco
import numpy as np
import pytest

from tests.plugin.rigs import sheath_view

PULLEYS = """<mujoco><option timestep="0.001" gravity="0 0 0"/>{extension}<worldbody>
  <site name="a" pos="-0.2 0 0"/><site name="b" pos="0 0 0.05"/><site name="k" pos="0.1 0 0"/>
  <site name="p" pos="0.2 0.05 0.05"/><site name="q" pos="0.2 -0.05 0.05"/>
  <body pos="0.3 0.05 0"><joint name="one" type="slide" axis="1 0 0" damping="20"/>
    <geom size="0.01" mass="0.3"/><site name="e"/></body>
  <body pos="0.3 -0.05 0"><joint name="two" type="slide" axis="1 0 0" damping="20"/>
    <geom size="0.01" mass="0.3"/><site name="f"/></body></worldbody>
  <tendon><spatial name="t"><site site="a"/><site site="b"/><site site="k"/>
    <pulley divisor="2"/><site site="{start}"/><site site="p"/><site site="e"/>
    <pulley divisor="4"/><site site="{start}"/><site site="q"/><site site="f"/></spatial></tendon>
  <actuator><motor tendon="t" ctrlrange="-50 0"/></actuator>{sensor}</mujoco>"""


def pulleys_extension(friction):
    """The sheath of that tendon."""
    return f"""<extension><plugin plugin="tendon_mj.sheath"><instance name="s">
      <config key="tendon" value="t"/><config key="friction" value="{friction}"/>
      </instance></plugin></extension>"""


def pulleys(friction=None, start="k"):
    """A tendon with three branches; two begin at a site, where the first one may end."""
    extension = sensor = ""
    if friction is not None:
        extension = pulleys_extension(friction)
        sensor = '<sensor><plugin plugin="tendon_mj.sheath" instance="s"/></sensor>'
    text = PULLEYS.format(extension=extension, sensor=sensor, start=start)
    return mujoco.MjModel.from_xml_string(text)


def test_without_friction_branches_pull_as_mujocos_own():
    runs = []
    for model in (pulleys(), pulleys(0.0)):
        data = mujoco.MjData(model)
        data.ctrl[:] = -12.0
        mujoco.mj_step(model, data, nstep=300)
        runs.append(data.qpos.copy())
    assert np.array_equal(*runs)


@pytest.mark.parametrize("start", ["k", "b"])
def test_each_branch_has_a_friction_state_of_its_own(start):
    model = pulleys(0.3, start)
    data = mujoco.MjData(model)
    data.ctrl[:] = -12.0
    mujoco.mj_step(model, data, nstep=50)
    mujoco.mj_forward(model, data)
    state = sheath_view(model, data)
    stiffness = float(state.state.law.axial_stiffness)
    tension = stiffness * state.segments["tension"]
    angles, divided = state.guides["angle"], state.guides["is_pulley"]
    assert list(divided) == [0.0, 1.0, 0.0, 1.0, 0.0]
    # the first branch slides as the others draw their tendon through it; else it holds
    first = tension[1] if start == "k" else 12.0
    if start == "k":
        assert tension[1] == pytest.approx(12.0 * np.exp(-0.3 * angles[0]))
    assert tension[0] == pytest.approx(12.0)
    assert tension[2] == pytest.approx(first / 2.0)
    assert tension[4] == pytest.approx(first / 4.0)
    assert tension[2] / tension[3] == pytest.approx(np.exp(0.3 * angles[2]), rel=1e-9)
    assert tension[4] / tension[5] == pytest.approx(np.exp(0.3 * angles[4]), rel=1e-9)


def test_the_force_on_a_joint_is_that_of_its_branch():
    model = pulleys(0.3)
    data = mujoco.MjData(model)
    data.ctrl[:] = -12.0
    mujoco.mj_step(model, data, nstep=50)
    mujoco.mj_forward(model, data)
    state = sheath_view(model, data)
    tension = float(state.state.law.axial_stiffness) * state.segments["tension"]
    own = data.qfrc_passive - (-20.0) * data.qvel + data.qfrc_actuator
    for dof, (site, end, segment) in enumerate([("p", "e", 3), ("q", "f", 5)]):
        to = data.site(site).xpos - data.site(end).xpos
        assert own[dof] == pytest.approx(tension[segment] * to[0] / np.linalg.norm(to), rel=1e-9)


FED = """<mujoco><option timestep="0.002" gravity="0 0 0"/>
  <extension><plugin plugin="tendon_mj.sheath"><instance name="s">
    <config key="tendon" value="t"/><config key="friction" value="0.3"/>
  </instance></plugin></extension><worldbody>
    <site name="a" pos="0 0 .2"/><site name="b" pos="0 0 0"/><site name="c" pos=".1 0 0"/>
    <site name="end" pos=".1 0 .1"/>
    <body pos=".1 0 .3"><joint name="z" type="slide" axis="0 0 1"/><geom size=".01" mass="5"/>
      <site name="e"/></body></worldbody>
  <tendon><spatial name="t"><site site="a"/><site site="b"/><site site="c"/><site site="end"/>
    {pulley}<site site="e"/></spatial></tendon>
  <actuator><motor tendon="t"/><position joint="z" kp="5000" kv="200"/></actuator>
  <sensor><plugin plugin="tendon_mj.sheath" instance="s"/></sensor></mujoco>"""


@pytest.mark.parametrize("divisor", [None, 1, 2, 3])
@pytest.mark.parametrize("outwards", [1.0, -1.0])
def test_a_branch_draws_its_tendon_through_the_one_that_feeds_it(divisor, outwards):
    """Two quarter turns before a pulley rub as they do without it, and nothing makes energy."""
    pulley = f'<pulley divisor="{divisor}"/><site site="end"/>' if divisor else ""
    model = mujoco.MjModel.from_xml_string(FED.format(pulley=pulley))
    data = mujoco.MjData(model)
    data.ctrl[0] = -10.0
    mujoco.mj_step(model, data)
    work = before = 0.0
    for k in range(1500):
        data.ctrl[1] = outwards * 0.05 * min(1.0, k / 1000)
        mujoco.mj_step(model, data)
        if k == 500:
            before = sheath_view(model, data).guides["friction_work"].sum()
        if 500 < k <= 900:
            power = data.actuator_force[0] * data.ten_velocity[0]
            work += (power + data.actuator_force[1] * data.qvel[0]) * model.opt.timestep
        if k == 900:
            tension_in, tension_out = data.sensordata
            ratio = tension_out * (divisor or 1) / tension_in
            rubbed = sheath_view(model, data).guides["friction_work"].sum() - before
    assert ratio == pytest.approx(np.exp(outwards * 0.3 * np.pi), rel=1e-9)
    assert rubbed == pytest.approx(work, rel=0.02)


def bound_again(before, after):
    """A step of ``after`` from a state of ``before``, and from none; their sheaths' guides."""
    old = mujoco.MjData(before)
    old.ctrl[:] = -12.0
    mujoco.mj_step(before, old, 5)
    guides = []
    for state in (old.plugin_state, np.zeros(after.npluginstate)):
        data = mujoco.MjData(after)
        data.ctrl[:] = -12.0
        data.plugin_state[:] = state
        mujoco.mj_step(after, data)
        guides.append(sheath_view(after, data).guides)
    return guides


@pytest.mark.parametrize("mark", ["is_pulley", "fed_by"])
def test_a_state_of_other_branches_is_bound_to_these(mark):
    kept, fresh = bound_again(pulleys(0.3, "b"), pulleys(0.3, "k"))
    assert np.array_equal(kept[mark], fresh[mark])
    moved = '<pulley divisor="2"/><site site="k"/><site site="p"/><site site="e"/>'
    first = '<site site="p"/><pulley divisor="2"/><site site="k"/><site site="e"/>'
    text = PULLEYS.replace(moved.replace('"k"', '"{start}"'), "{moved}")
    assert text != PULLEYS
    models = []
    for path in (moved, first):
        extension = pulleys_extension(0.3)
        models.append(
            mujoco.MjModel.from_xml_string(
                text.format(extension=extension, sensor="", start="k", moved=path)
            )
        )
    kept, fresh = bound_again(*models)
    assert np.array_equal(kept[mark], fresh[mark])
