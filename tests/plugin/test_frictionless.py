"""The elastic tendon: MuJoCo's own without friction, its damping, and forces from its energy."""

import mujoco
import numpy as np
import pytest

from tests.rigs import (
    SPOOLED,
    arm,
    arm_xml,
    instance,
    plugin,
    rope,
    run,
    segment_lengths,
    simulated,
    spatial,
    started,
    unpacked,
)

EA, T0 = 500.0, 8.0


@pytest.mark.parametrize(
    ("pretension", "speed", "slackens"), [(T0, [0.5, -0.3, 1.0], False), (0.5, [-3.0] * 3, True)]
)
@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "implicit", "RK4"])
def test_trajectories_equal_those_of_the_spatial_tendon(integrator, pretension, speed, slackens):
    ours = arm(integrator=integrator, friction=0.0, axial_stiffness=EA, pretension=pretension)
    unstretched = float(ours.tendon_length0[0]) / (1.0 + pretension / EA)
    spec = mujoco.MjSpec.from_string(arm_xml(integrator=integrator, views=()))
    spec.delete(spec.plugin("sheath"))
    own = spec.tendon("tendon")
    own.stiffness[0], own.springlength = EA / unstretched, [0.0, unstretched]
    theirs = spec.compile()
    one, other = mujoco.MjData(ours), mujoco.MjData(theirs)
    one.qvel[:] = other.qvel[:] = speed
    paths, slack = np.empty((2, 3000, 3)), 0
    for k in range(3000):
        mujoco.mj_step(ours, one)
        mujoco.mj_step(theirs, other)
        paths[:, k] = one.qpos, other.qpos
        tension = one.sensor("tension").data
        np.testing.assert_allclose(tension, tension[0], rtol=1e-12)
        slack += tension[0] == 0.0
    travel = np.abs(paths).max()
    assert travel > 0.2, "the arm moves"
    assert np.abs(paths[0] - paths[1]).max() <= 1e-9 * travel
    assert one.sensor("unsolved").data[0] == 0
    assert not one.sensor("friction_work").data.any()
    assert slackens <= slack < 3000


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_pretension_is_what_the_tendon_carries_at_qpos0(friction):
    data = simulated(arm(friction=friction, pretension=12.5))
    np.testing.assert_allclose(data.sensor("tension").data, 12.5, rtol=1e-10)


def test_where_a_simulation_starts_does_not_change_how_much_tendon_there_is():
    model = arm(friction=0.0, spools=True, axial_stiffness=EA, pretension=T0)
    there, moved = mujoco.MjData(model), mujoco.MjData(model)
    mujoco.mj_step(model, moved)
    for data in (there, moved):
        data.qpos[:] = [0.05, -0.1, 0.1, 0.3, 0.01]
        data.qvel[:] = 0.0
        mujoco.mj_forward(model, data)
    tension = there.sensor("tension").data
    assert tension.min() > T0
    np.testing.assert_allclose(tension, moved.sensor("tension").data, rtol=1e-9)


def swing(damping, timestep, integrator="Euler"):
    """Displacements of a mass on a tendon without guides, balanced by a spring, over 1 s."""
    law = {"axial_stiffness": 1000, "friction": 0, "pretension": 100, "axial_damping": damping}
    xml = rope(
        "a",
        "b",
        body='pos="1 0 0"',
        joint='type="slide" axis="1 0 0" springref=".2" stiffness="500"',
        geom='size=".1" mass="2"',
        option=f'gravity="0 0 0" timestep="{timestep}" integrator="{integrator}"',
        law=law,
        actuator="",
    )
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    data.qpos[0] = 1e-3
    path = []
    for _ in range(round(1.0 / timestep)):
        path.append(data.qpos[0])
        mujoco.mj_step(model, data)
    return np.array(path)


def exact(damping, timestep):
    """Free oscillation with k = EA/S + k_spring and c/S about the balance."""
    unstretched, mass = 1.0 / (1.0 + 100.0 / 1000.0), 2.0
    stiffness, friction = 1000.0 / unstretched + 500.0, damping / unstretched
    decay = friction / (2 * mass)
    omega = np.sqrt(stiffness / mass - decay**2)
    time = timestep * np.arange(round(1.0 / timestep))
    wave = np.cos(omega * time) + decay / omega * np.sin(omega * time)
    return 1e-3 * np.exp(-decay * time) * wave


@pytest.mark.parametrize("damping", [2.0, 10.0])
@pytest.mark.parametrize("integrator", ["Euler", "RK4"])
def test_a_mass_on_a_tendon_decays_as_it_must(damping, integrator):
    errors = [
        np.abs(swing(damping, h, integrator) - exact(damping, h)).max() / 1e-3
        for h in (5e-4, 2.5e-4, 1.25e-4)
    ]
    assert errors[2] < 2e-2
    assert errors[2] < 0.6 * errors[1] < 0.36 * errors[0]


@pytest.mark.parametrize("seed", range(4))
def test_damping_takes_energy_and_gives_none(seed):
    ends = []
    for damping in (0.0, 1.0, 4.0):
        model = arm(axial_damping=damping, friction=0.0, timestep=1e-4)
        data = started(model, seed, 1.0)
        data.qvel[:] += 1.0
        unstretched = float(model.tendon_length0[0]) / (1.0 + T0 / EA)

        def energy(model=model, data=data, unstretched=unstretched):
            # with damping the sensor shows more than the spring, so measure the strain itself
            mujoco.mj_forward(model, data)
            strain = max(0.0, segment_lengths(model, data).sum() / unstretched - 1.0)
            return data.energy.sum() + 0.5 * EA * strain**2 * unstretched

        start = energy()
        run(model, data, 3000)
        ends.append(energy() - start)
        assert np.all(data.sensor("tension").data >= 0.0)
    assert abs(ends[0]) < 5e-3
    assert ends[2] < ends[1] < ends[0]
    assert ends[1] < -1e-3


# free, ball, slide and hinge joints, a branch, a body without joints, and a mocap-like fixed one
TREE = """
<mujoco>
  <option gravity="0 0 0" timestep="0.001"/>
  <extension>{plugins}</extension>
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
  <tendon>{tendons}</tendon>
</mujoco>
"""
PATHS = {"first": "w a b c d e f", "second": "f d a"}


def tree(*tendons):
    """The tree with a sheath on each of some tendons."""
    law = {"axial_stiffness": 400, "friction": 0.3, "pretension": 60, "constant_friction": 0.2}
    names = ("sheath", "more")
    plugins = plugin(
        *(instance(name, tendon=t, **law) for name, t in zip(names, tendons, strict=False))
    )
    drawn = "".join(spatial(t, PATHS[t]) for t in tendons)
    return mujoco.MjModel.from_xml_string(TREE.format(plugins=plugins, tendons=drawn))


def energy_at(model, data, qpos, stored, stiffness, spools):
    """U = Σ EA/2 ε² s with the segments' unstretched lengths frozen but for what spools wind."""
    other = mujoco.MjData(model)
    other.qpos[:] = qpos
    mujoco.mj_kinematics(model, other)
    lengths = segment_lengths(model, other)
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
    model = tree("first")
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
    data = started(model, seed, 0.5)
    radii = np.array([SPOOLED["reel_radius"], SPOOLED["output_radius"]]) / (1.0 + T0 / EA)
    ends = (("reel", 0, radii[0]), ("drum", -1, radii[1]))
    spools = [(segment, model.joint(name).qposadr[0], radius) for name, segment, radius in ends]
    for _ in range(10):
        run(model, data, 20)
        mujoco.mj_forward(model, data)
        force = data.qfrc_passive + model.jnt_stiffness * (data.qpos - model.qpos_spring)
        np.testing.assert_allclose(force, -gradient(model, data, spools), rtol=1e-6, atol=1e-6)
        for name, segment, radius in ends:
            tension = data.sensor("tension").data[segment]
            torque = radius * (tension + tension**2 / (2 * EA))
            assert force[model.joint(name).dofadr[0]] == pytest.approx(-torque, rel=1e-12)


def test_two_sheaths_on_one_body_add_up():
    both, first, second = (
        simulated(tree(*tendons)).qfrc_passive
        for tendons in (("first", "second"), ("first",), ("second",))
    )
    np.testing.assert_allclose(both, first + second, rtol=1e-12, atol=1e-12)
