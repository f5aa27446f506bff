"""The sheath's generalised force is the gradient of its elastic energy at frozen flow."""

import mujoco
import numpy as np
import pytest

from tests.plugin.rigs import SPOOLED, arm, run, started, unpacked

# free, ball, slide and hinge joints, a branch, a body without joints, and a mocap-like fixed one
TREE = """
<mujoco>
  <option gravity="0 0 0" timestep="0.001"/>
  <extension><plugin plugin="tendon_mj.sheath">
    <instance name="sheath">
      <config key="tendon" value="tendon"/><config key="axial_stiffness" value="400"/>
      <config key="friction" value="0.3"/><config key="pretension" value="60"/>
      <config key="constant_friction" value="0.2"/>
    </instance>
  </plugin></extension>
  <default><geom type="box" size=".05 .03 .02" contype="0" conaffinity="0"/></default>
  <worldbody>
    <site name="w" pos="-.2 .1 .3"/>
    <body name="free" pos=".1 0 .2"><freejoint/><geom/><site name="a" pos=".04 .02 .01"/>
      <body pos=".2 0 0"><joint type="ball"/><geom pos=".1 0 0"/><site name="b" pos=".1 .05 0"/>
        <body pos=".1 0 .1"><geom/><site name="c" pos=".05 -.03 .02"/></body>
        <body pos=".2 .1 0"><joint type="slide" axis="1 1 0"/><joint axis="0 0 1"/><geom/>
          <site name="d" pos=".03 .05 .01"/></body>
      </body>
    </body>
    <body pos=".7 .2 .3"><site name="e"/></body>
    <body pos=".8 .5 .3"><joint axis="0 1 0" pos="0 0 -.1"/><joint type="slide"/><geom/>
      <site name="f" pos=".02 0 .05"/></body>
  </worldbody>
  <tendon><spatial name="tendon">
    <site site="w"/><site site="a"/><site site="b"/><site site="c"/><site site="d"/>
    <site site="e"/><site site="f"/>
  </spatial></tendon>
</mujoco>
"""


def energy_at(model, data, qpos, stored, stiffness, spools):
    """U = Σ EA/2 ε² s with the segments' unstretched lengths frozen but for what spools wind."""
    other = mujoco.MjData(model)
    other.qpos[:] = qpos
    mujoco.mj_kinematics(model, other)
    points = other.site_xpos[model.wrap_objid]
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    stored = stored.copy()
    for segment, adr, radius in spools:
        stored[segment] -= radius * (qpos[adr] - data.qpos[adr])
    strain = np.maximum(lengths / stored - 1.0, 0.0)
    return np.sum(0.5 * stiffness * strain**2 * stored)


def gradient(model, data, spools=()):
    _, segments, guides = unpacked(model, data)
    scalars = unpacked(model, data)[0]
    stored = segments["stored"] + np.diff(np.concatenate([[0.0], guides["flow"], [0.0]]))
    stored[0] -= scalars.trial_wound_in - scalars.wound_in
    stored[-1] -= scalars.trial_wound_out - scalars.wound_out
    slope, h = np.empty(model.nv), 1e-6
    for i in range(model.nv):
        ends = []
        for way in (h, -h):
            qpos, nudge = data.qpos.copy(), np.zeros(model.nv)
            nudge[i] = way
            mujoco.mj_integratePos(model, qpos, nudge, 1.0)
            stiffness = scalars.law.axial_stiffness
            ends.append(energy_at(model, data, qpos, stored, stiffness, spools))
        slope[i] = (ends[0] - ends[1]) / (2 * h)
    return slope


@pytest.mark.parametrize("seed", range(4))
def test_the_force_is_minus_the_gradient_on_every_kind_of_joint(seed):
    model = mujoco.MjModel.from_xml_string(TREE)
    data = started(model, seed, 0.5)
    for _ in range(10):
        run(model, data, 5)
        mujoco.mj_forward(model, data)
        force = data.qfrc_passive
        assert np.abs(force).max() > 1e-2
        np.testing.assert_allclose(
            force, -gradient(model, data), rtol=1e-6, atol=1e-7 * np.abs(force).max() + 1e-8
        )


@pytest.mark.parametrize("seed", range(3))
def test_a_spool_bears_the_tension_and_its_share_of_strain_energy(seed):
    model = arm(spools=True)
    ea = 500.0
    data = started(model, seed, 0.5)
    springs = model.jnt_stiffness.copy()
    ends = [("reel", 0), ("drum", -1)]
    spools = [
        (segment, model.joint(name).qposadr[0], radius)
        for (name, segment), radius in zip(
            ends, (SPOOLED["reel_radius"], SPOOLED["output_radius"]), strict=True
        )
    ]
    for _ in range(10):
        run(model, data, 20)
        mujoco.mj_forward(model, data)
        force = data.qfrc_passive + springs * (data.qpos - model.qpos_spring)
        np.testing.assert_allclose(force, -gradient(model, data, spools), rtol=1e-6, atol=1e-6)
        for (name, segment), (_, _, radius) in zip(ends, spools, strict=True):
            tension = data.sensor("tension").data[segment]
            torque = radius * (tension + tension**2 / (2 * ea))
            assert force[model.joint(name).dofadr[0]] == pytest.approx(-torque, rel=1e-12)


SECOND = '<spatial name="{name}"><site site="f"/><site site="d"/><site site="a"/></spatial>'
SECOND_NAME = '"tendon" value="second"'


def test_two_sheaths_on_one_body_add_up():
    first = TREE[TREE.index("<spatial") : TREE.index("</tendon>")]
    instance = TREE[TREE.index("<instance") : TREE.index("</plugin>")]
    more = instance.replace('"sheath"', '"more"').replace('"tendon" value="tendon"', SECOND_NAME)
    alone = TREE.replace(first, SECOND.format(name="tendon"))
    both = TREE.replace(first, first + SECOND.format(name="second"))
    both = both.replace(instance, instance + more)
    forces = []
    for source in (both, alone, TREE):
        model = mujoco.MjModel.from_xml_string(source)
        data = started(model)
        mujoco.mj_forward(model, data)
        forces.append(data.qfrc_passive.copy())
    np.testing.assert_allclose(forces[0], forces[1] + forces[2], rtol=1e-12, atol=1e-12)
