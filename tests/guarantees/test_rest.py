"""What rests, rests: tendons that friction holds bear a load within its band, and nothing moves."""

import mujoco
import numpy as np
import pytest
import scipy
from hypothesis import assume, given
from hypothesis import strategies as some

from tendon_mj import Parameters, add_friction, view_sheath
from tests.guarantees.random_tendon import EXAMPLES, thorough
from tests.rigs import GIVEN, NO_CONTACT, STILL, rope, route, sheathed, started

SETTLES = 20  # steps
pytestmark = pytest.mark.filterwarnings("ignore::tendon_mj.TendonWarning")


def tree(rng, links, tendons, step, integrator):
    """A random tree of links on springs, and tendons from the ground to any of them."""
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.option.timestep, spec.option.integrator = step, integrator
    bodies = [spec.worldbody]
    for k in range(links):
        parent = bodies[rng.integers(len(bodies))]
        body = parent.add_body(name=f"link{k}", pos=rng.uniform(-0.1, 0.1, 3))
        joint = body.add_joint(
            name=f"joint{k}", type=mujoco.mjtJoint.mjJNT_HINGE, axis=rng.normal(size=3)
        )
        joint.damping[0], joint.stiffness[0] = rng.choice([0.002, 0.05]), 0.5
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            fromto=[0, 0, 0, 0.1, 0, 0],
            size=[0.01, 0, 0],
            mass=rng.uniform(0.01, 0.3),
            contype=0,
            conaffinity=0,
        )
        bodies.append(body)
    for t in range(tendons):
        tendon, route = spec.add_tendon(name=f"t{t}"), [bodies[rng.integers(1, links + 1)]]
        while route[-1] is not spec.worldbody:
            route.append(route[-1].parent)
        places = [body for body in reversed(route) for _ in range(rng.integers(1, 3))]
        places += [route[0]] * max(0, 3 - len(places))
        for k, body in enumerate(places):
            tendon.wrap_site(body.add_site(name=f"s{t}_{k}", pos=rng.uniform(-0.05, 0.05, 3)).name)
        spec.add_actuator(trntype=mujoco.mjtTrn.mjTRN_TENDON, target=tendon.name)
    return spec


def moment_arms(model, data, view):
    """(segments, dofs), derivatives of the lengths of a tendon between its sites."""
    tendon, near, far = model.tendon(view.tendon).id, *np.zeros((2, 3, model.nv))
    sites = model.wrap_objid[model.tendon_adr[tendon] :][: model.tendon_num[tendon]]
    arms = np.zeros((len(sites) - 1, model.nv))
    for k in range(len(sites) - 1):
        span = data.site_xpos[sites[k + 1]] - data.site_xpos[sites[k]]
        mujoco.mj_jacSite(model, data, near, None, sites[k])
        mujoco.mj_jacSite(model, data, far, None, sites[k + 1])
        arms[k] = span / np.linalg.norm(span) @ (far - near)
    return arms


def load_within(rng, model, data, views, friction, pulls):
    """Generalised forces that tensions within friction's band balance, gravity included."""
    load = data.qfrc_bias.copy()
    for view, pull in zip(views, pulls, strict=True):
        shares = rng.uniform(-0.6, 0.6, view.bend_angle.size) * friction * view.bend_angle
        load += pull * np.exp(np.append(0.0, np.cumsum(shares))) @ moment_arms(model, data, view)
    return load


def tips_over(model, pose, load, views):
    """Whether a mechanism under constant tensions and a load leaves a pose without any slip."""
    tensions, data = [view.tension.copy() for view in views], mujoco.MjData(model)

    def forces(way):
        data.qpos[:] = pose + way
        mujoco.mj_forward(model, data)
        pulls = (t @ moment_arms(model, data, v) for v, t in zip(views, tensions, strict=True))
        return load + data.qfrc_passive - data.qfrc_bias - sum(pulls)

    ways = 1e-5 * np.eye(model.nv)
    stiffness = np.array([forces(-way) - forces(way) for way in ways]) / 2e-5
    forces(np.zeros(model.nv))
    slips = np.vstack([moment_arms(model, data, view)[1:] for view in views])
    free = scipy.linalg.null_space(slips, rcond=1e-6)
    return np.linalg.eigvalsh(free.T @ (stiffness + stiffness.T) @ free).min(initial=1.0) < 1e-6


@thorough
@given(
    seed=some.integers(0, 2**32 - 1),
    links=some.integers(1, 8),
    tendons=some.sampled_from([1, 2, 5, 12, 40]),
    step=some.sampled_from([1e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2]),
    integrator=some.sampled_from([0, 2, 3]),
    live=some.booleans(),
)
def test_a_load_within_the_band_rests_in_any_pose_beside_any_tendons(
    seed, links, tendons, step, integrator, live
):
    """After other poses, and where friction, the step and the masses were written meanwhile."""
    rng = np.random.default_rng(seed)
    friction = rng.uniform(0.2, 0.6)
    spec = tree(rng, links, tendons, 1e-3 if live else step, integrator)
    stock = spec.compile()
    model = add_friction(spec, "*", friction=0.9 if live else friction).compile()
    data, pulls = mujoco.MjData(model), rng.uniform(5.0, 20.0, tendons)
    data.ctrl[:] = -pulls
    for _ in range(2):
        data.qpos[:], data.qvel[:] = rng.uniform(-1.0, 1.0, model.nq), 0.0
        mujoco.mj_step(model, data)
    data.qpos[:], data.qvel[:] = rng.uniform(-0.8, 0.8, model.nq), 0.0
    model.qpos_spring[:] = data.qpos
    if live:
        model.opt.timestep = step
        model.body_mass[1:] *= 0.5
        parameters = Parameters(model, data)
        for name in (name for name in parameters if name.endswith(".friction")):
            parameters[name] = friction
    mujoco.mj_forward(model, data)
    views = [view_sheath(model, data, f"t{t}") for t in range(tendons)]
    data.qfrc_applied[:] = load_within(rng, model, data, views, friction, pulls)
    for _ in range(SETTLES):
        mujoco.mj_step(model, data)
    # what no tendon holds swings on its spring for a while, or is tipped over by them
    assume(step * np.abs(data.qvel).max() < 1e-9)
    stock.body_mass[:], stock.qpos_spring[:] = model.body_mass, model.qpos_spring
    assume(not tips_over(stock, data.qpos.copy(), data.qfrc_applied, views))
    work = sum(view.friction_work.sum() for view in views)
    for _ in range(max(10, round(0.01 / step))):  # until that has died down, some 2 s
        outputs, speed = [], 0.0
        for _ in range(200):
            mujoco.mj_step(model, data)
            outputs.append([float(view.output_tension) for view in views])
            speed = max(speed, np.abs(data.qvel).max())
        rests = (np.ptp(outputs, axis=0) < 1e-6 * pulls).all()
        if rests and step * speed < 1e-11:
            break
    assert sum(view.friction_work.sum() for view in views) - work < 1e-12 * (1.0 + work)
    assert rests


@thorough
@given(
    seed=some.integers(0, 2**32 - 1),
    links=some.integers(1, 8),
    tendons=some.sampled_from([2, 5, 12]),
    step=some.sampled_from([1e-3, 2e-3, 5e-3]),
    integrator=some.sampled_from([0, 2, 3]),
)
def test_no_guide_bears_more_than_its_friction_whatever_moves(
    seed, links, tendons, step, integrator
):
    rng = np.random.default_rng(seed)
    friction = rng.uniform(0.1, 0.5)
    spec = tree(rng, links, tendons, step, integrator)
    model = add_friction(spec, "*", friction=friction).compile()
    data = mujoco.MjData(model)
    views = [view_sheath(model, data, f"t{t}") for t in range(tendons)]
    pulls, rates = rng.uniform(2.0, 20.0, tendons), rng.uniform(2.0, 16.0, tendons)
    for _ in range(200):
        data.ctrl[:] = -pulls * (1.0 - np.cos(rates * data.time))
        mujoco.mj_step(model, data)
        if data.warning.number.any():
            break
        for view in views:
            near, far, band = (
                view.tension[:-1],
                view.tension[1:],
                np.exp(friction * view.bend_angle),
            )
            rounding = 1e-12 * (near + far)
            assert (far <= band * near + rounding).all()
            assert (near <= band * far + rounding).all()


HELD = rope(
    "a 0 0 .3; b .5 0 0",
    "c",
    tendon="{tendon}",
    body='pos="1 0 0"',
    joint='name="j" type="slide" axis="1 0 0" damping="{damping}"',
    geom='size=".03" mass="1"',
    option='timestep="{step}" gravity="0 0 0" integrator="{integrator}"',
    actuator='{motor}<motor name="load" joint="j"/>',
    rest="{rest}",
)
LENGTH = np.hypot(0.5, 0.3) + 0.502
LIMIT = {"tendon": f'limited="true" range="0 {LENGTH}"', "rest": "", "motor": ""}
EQUALITY = '<equality><tendon tendon1="t"/></equality>'


@pytest.mark.parametrize("step", [2e-3, 1e-3, 5e-4])
@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "RK4"])
@pytest.mark.parametrize(
    "parts",
    [
        LIMIT,
        LIMIT | {"motor": '<motor name="pull" tendon="t"/>'},
        {"tendon": "", "rest": EQUALITY, "motor": ""},
    ],
    ids=["limit", "motor and limit", "equality"],
)
def test_a_rope_that_a_constraint_holds_rests(parts, integrator, step):
    text = HELD.format(damping=20.0, step=step, integrator=integrator, **parts)
    model = add_friction(mujoco.MjSpec.from_string(text), "t", friction=0.3).compile()
    data, outputs = mujoco.MjData(model), []
    for _ in range(round(4.0 / step)):
        data.ctrl[:] = [-5.0, 20.0][-model.nu :]
        mujoco.mj_step(model, data)
        outputs.append(data.sensor("output_tension").data[0])
    assert np.ptp(outputs[-500:]) < 1e-4 * 20.0
    assert outputs[-1] == pytest.approx(20.0, rel=1e-4)


PRESSES = """<mujoco><option timestep="{step}" integrator="{integrator}" cone="{cone}"/><worldbody>
  <geom type="box" size=".05 .05 .01" pos=".06 0 -.05"/>
  <site name="s0" pos="-.06 0 -.012"/><site name="s1" pos="-.01 0 -.01"/>
  <body><joint axis="0 1 0" damping=".005"/>
    <geom type="capsule" fromto="0 0 0 .045 0 0" size=".008" contype="0" conaffinity="0"/>
    <site name="s2" pos=".01 0 -.009"/><site name="s3" pos=".035 0 -.009"/>
    <body pos=".045 0 0"><joint axis="0 1 0" damping=".003" stiffness=".02"/>
      <geom type="capsule" fromto="0 0 0 .03 0 0" size=".007"/>
      <site name="s4" pos=".008 0 -.008"/><site name="s5" pos=".022 0 -.008"/></body></body>
  </worldbody><tendon><spatial name="t">{sites}</spatial></tendon>
  <actuator><motor tendon="t"/></actuator></mujoco>"""


@pytest.mark.parametrize("step", [2e-3, 1e-3, 5e-4])
@pytest.mark.parametrize("integrator", ["Euler", "implicitfast"])
@pytest.mark.parametrize("cone", ["pyramidal", "elliptic"])
def test_a_finger_that_presses_on_a_block_rests(cone, integrator, step):
    sites = "".join(f'<site site="s{k}"/>' for k in range(6))
    text = PRESSES.format(step=step, integrator=integrator, cone=cone, sites=sites)
    model = add_friction(mujoco.MjSpec.from_string(text), "t", friction=0.4).compile()
    data, outputs = mujoco.MjData(model), []
    for k in range(round(3.0 / step)):
        data.ctrl[:] = max(-12.0, -60.0 * k * step) if k * step < 1.5 else -8.0
        mujoco.mj_step(model, data)
        outputs.append(data.sensor("output_tension").data[0])
    assert data.ncon > 0
    assert np.ptp(outputs[-500:]) < 1e-4 * 8.0


SPRUNG = rope(
    "a 0 0 .3; b .5 0 0",
    "c",
    tendon='stiffness="40" springlength="0 0.5"',
    body='pos="1 0 0"',
    joint='name="j" type="slide" axis="1 0 0" damping="5"',
    geom='size=".03" mass="1"',
    option='timestep="{step}" gravity="0 0 0" integrator="{integrator}"',
    actuator="{actuator}",
)


def pulled_by_a_spring(step, integrator, actuator=""):
    text = SPRUNG.format(step=step, integrator=integrator, actuator=actuator)
    spec = mujoco.MjSpec.from_string(text)
    model = add_friction(spec, "t", friction=0.4, spring="input").compile()
    return model, mujoco.MjData(model)


@pytest.mark.parametrize("step", [1e-2, 1e-3])
@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "RK4"])
def test_a_tendon_that_a_spring_pulls_rests_without_any_actuator(integrator, step):
    model, data = pulled_by_a_spring(step, integrator)
    data.qfrc_applied[0] = 24.0
    mujoco.mj_step(model, data, round(3.0 / step))
    outputs, work = [], view_sheath(model, data, "t").friction_work.sum()
    for _ in range(200):
        mujoco.mj_step(model, data)
        outputs.append(float(view_sheath(model, data, "t").output_tension))
    assert np.ptp(outputs) < 1e-6 * 24.0
    assert view_sheath(model, data, "t").friction_work.sum() - work < 1e-12


@pytest.mark.parametrize("kind", ["xfrc_applied", "qfrc_applied"])
def test_a_force_that_changes_within_the_band_moves_nothing(kind):
    motor = '<motor name="pull" tendon="t"/>'
    text = HELD.format(damping=5.0, step=5e-3, integrator="Euler", tendon="", rest="", motor=motor)
    model = add_friction(mujoco.MjSpec.from_string(text), "t", friction=0.4).compile()
    data, rng = mujoco.MjData(model), np.random.default_rng(0)
    data.ctrl[0] = -20.0
    forces = data.xfrc_applied[1:2, 0] if kind == "xfrc_applied" else data.qfrc_applied
    forces[:] = 20.0
    mujoco.mj_step(model, data, 400)
    place = data.qpos[0]
    for _ in range(500):
        forces[:] = 20.0 + rng.uniform(-2.0, 2.0)
        mujoco.mj_step(model, data)
    assert data.qpos[0] == pytest.approx(place, abs=1e-9)


def limited_finger(integrator):
    """Three joints, of which tendons on both sides press some against their limits."""
    spec = mujoco.MjSpec()
    spec.option.timestep, spec.option.integrator = 2e-3, integrator
    parent = spec.worldbody
    for k in range(3):
        parent = parent.add_body(name=f"link{k}", pos=[0.1 if k else 0.0, 0.0, 0.0])
        joint = parent.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 1, 0], range=[-1, 1])
        joint.damping[0], joint.armature, joint.limited = 0.005, 1e-5, True
        parent.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            fromto=[0, 0, 0, 0.1, 0, 0],
            size=[0.01, 0, 0],
            mass=0.05,
            contype=0,
            conaffinity=0,
        )
    for t, side in enumerate([0.012, -0.012] * 2):
        tendon = spec.add_tendon(name=f"t{t}")
        places = [(spec.worldbody, [-0.2, 0, 0]), (spec.worldbody, [-0.02, 0, side])]
        places += [(spec.body(f"link{k}"), [x, 0, side]) for k in range(3) for x in (0.02, 0.08)]
        for k, (body, place) in enumerate(places):
            tendon.wrap_site(body.add_site(name=f"s{t}_{k}", pos=place).name)
        spec.add_actuator(trntype=mujoco.mjtTrn.mjTRN_TENDON, target=tendon.name)
    return spec


@pytest.mark.parametrize("integrator", [0, 3])
@pytest.mark.parametrize("written", ["opt.timestep", "dof_armature", "dof_damping"])
def test_joints_at_their_limits_rest_where_step_mass_or_damping_is_written(written, integrator):
    model = add_friction(limited_finger(integrator), "*", friction=0.3).compile()
    data = mujoco.MjData(model)
    data.ctrl[:] = -30.0, -28.0, -12.0, -14.0
    mujoco.mj_step(model, data, 4000)
    views = [view_sheath(model, data, f"t{t}") for t in range(4)]
    place, work = data.qpos.copy(), sum(view.friction_work.sum() for view in views)
    owner, name = (model.opt, "timestep") if "." in written else (model, written)
    value, rng = np.copy(getattr(owner, name)), np.random.default_rng(0)
    assert data.nefc > 0
    for _ in range(500):
        setattr(owner, name, value * 2.0 ** rng.uniform(-1.0, 1.0))
        mujoco.mj_step(model, data)
    assert data.qpos == pytest.approx(place, abs=1e-8)
    assert sum(view.friction_work.sum() for view in views) - work < 1e-12


@pytest.mark.parametrize("step", [2e-3, 5e-4])
@pytest.mark.parametrize("friction", [0.1, 1.0, 1.9])
def test_two_weights_on_a_rope_over_a_corner_fall_as_the_capstan_says(friction, step):
    """a = M g/(M + m e^{μφ}), for a rope by its limit, with e^{μφ} to 20; m lies on a table."""
    ratio = np.exp(friction * np.pi / 2)
    heavy = 2.0 * ratio
    text = f"""<mujoco><option timestep="{step}"/>{NO_CONTACT}<worldbody><site name="top"/>
      <body pos="-.5 0 0"><joint name="light" type="slide" axis="-1 0 0"/>
        <geom size=".01" mass="1"/><site name="a"/></body>
      <body pos="0 0 -.5"><joint name="heavy" type="slide" axis="0 0 -1"/>
        <geom size=".01" mass="{heavy}"/><site name="b"/></body></worldbody>
      <tendon><spatial name="rope" limited="true" range="0 1" solreflimit=".004 1">
        <site site="a"/><site site="top"/><site site="b"/></spatial></tendon></mujoco>"""
    model = add_friction(mujoco.MjSpec.from_string(text), "rope", friction=friction).compile()
    data, speeds = mujoco.MjData(model), []
    while data.time < 0.3:
        mujoco.mj_step(model, data)
        speeds.append(data.qvel.copy())
        view = view_sheath(model, data, "rope")
    fall = heavy * 9.81 / (heavy + ratio)
    half = len(speeds) // 2
    measured = (speeds[-1][1] - speeds[half][1]) / (step * (len(speeds) - 1 - half))
    assert measured == pytest.approx(fall, rel=1e-4)
    assert view.output_tension / view.input_tension == pytest.approx(ratio, rel=1e-12)


@pytest.mark.parametrize("input_end", ["first", "last"])
def test_one_line_closes_two_equal_fingers_alike(input_end):
    """Whichever end is the input: the stretch of a rope by its limit is spread along it."""
    finger = """<body name="{0}" pos=".03 {1}.03 0">
      <joint name="{0}" axis="0 0 {2}1" stiffness=".15" damping=".01"/>
      <geom type="capsule" fromto="0 0 0 .05 0 0" size=".006" mass=".02"/>
      <site name="eye_{0}" pos=".012 {2}.008 0"/>
      <site name="knot_{0}" pos=".045 {2}.006 0"/></body>"""
    text = f"""<mujoco><option {STILL} integrator="implicitfast"/>{NO_CONTACT}<worldbody>
      <site name="hole_a" pos="0 .02 0"/><site name="hole_b" pos="0 -.02 0"/>
      <body pos="-.06 0 0"><joint name="carriage" type="slide" axis="-1 0 0" damping="5"/>
        <geom name="sheave" type="cylinder" size=".008 .004" mass=".1"/>
        <site name="behind" pos="-.02 0 0"/></body>
      {finger.format("a", "", "-")}{finger.format("b", "-", "")}</worldbody>
      <tendon><spatial name="line" limited="true" range="0 .298">
      {route("knot_a eye_a hole_a sheave@behind hole_b eye_b knot_b")}</spatial></tendon>
      <actuator><motor joint="carriage"/></actuator></mujoco>"""
    spec = mujoco.MjSpec.from_string(text)
    model = add_friction(spec, "line", friction=0.15, input_end=input_end).compile()
    data = mujoco.MjData(model)
    while data.time < 4.0:
        data.ctrl[0] = 3.0 * data.time
        mujoco.mj_step(model, data)
    first, second = data.qpos[1:]
    assert first > 0.3
    assert first == pytest.approx(second, rel=1e-4)
    tension = view_sheath(model, data, "line").tension
    np.testing.assert_allclose(tension, tension[::-1], rtol=1e-3)


@pytest.mark.long
def test_a_load_does_not_drift_in_a_hundred_thousand_steps():
    text = HELD.format(damping=5.0, step=1e-3, integrator="Euler", tendon="", rest="",
                       motor='<motor name="pull" tendon="t"/>')  # fmt: skip
    model = add_friction(mujoco.MjSpec.from_string(text), "t", friction=0.4).compile()
    data = mujoco.MjData(model)
    data.ctrl[:] = -20.0, 21.0
    mujoco.mj_step(model, data, SETTLES)
    place = data.qpos[0]
    mujoco.mj_step(model, data, 100_000)
    assert data.qpos[0] == pytest.approx(place, abs=1e-12)
    assert view_sheath(model, data, "t").friction_work.sum() < 1e-12


@pytest.mark.parametrize("name", GIVEN)
def test_in_models_of_others_no_tension_alternates(name):
    """Under constant activations, once the hand has come to rest or not."""
    model = sheathed(name, friction=0.2)
    rng = np.random.default_rng(0)
    for _ in range(max(1, EXAMPLES // 13)):  # 3 draws as a part of the suite
        data = started(model)
        data.ctrl[:] = rng.uniform(*model.actuator_ctrlrange.T)
        tensions = []
        for _ in range(round(2.0 / model.opt.timestep)):
            mujoco.mj_step(model, data)
            tensions.append(data.sensordata.copy())
        change = np.diff(np.array(tensions)[-40:], axis=0)
        turns = (change[1:] * change[:-1] < 0.0) & (np.abs(change[1:]) > 1e-2)
        assert turns.mean(axis=0).max(initial=0.0) < 0.5
