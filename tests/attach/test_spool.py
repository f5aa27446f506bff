"""Tendon motors that become motors on spools, and tendon motors again."""

import math

import mujoco
import numpy as np
import pytest

from tendon_mj import Spool, TendonWarning, add_friction, add_servo, remove_friction, view_sheath
from tendon_mj.attach.spool import kept_drives
from tendon_mj.errors import InvalidValueError
from tendon_mj.plugin import sheaths
from tests.attach.test_removal import assert_equal
from tests.refusals import refusing, silent
from tests.rigs import simulated

STIFFNESS, RADIUS = 2e4, 0.01
MOTORS = {
    "motor": '<motor name="m" tendon="t" gear="2" ctrlrange="-20 0"/>',
    "limited": '<motor name="m" tendon="t" ctrlrange="-40 0" forcerange="-9 0"/>',
    "position": '<position name="m" tendon="t" gear="1.5" kp="300" kv="20" ctrlrange=".1 .9"/>',
    "damped": '<position name="m" tendon="t" kp="300" dampratio="1" ctrlrange=".1 .5"/>',
    "inherited": '<position name="m" tendon="t" kp="200" kv="20" inheritrange="1"/>',
    "velocity": '<velocity name="m" tendon="t" kv="40" ctrlrange="-.3 0"/>',
    "integrator": '<intvelocity name="m" tendon="t" kp="200" actrange=".1 .5" ctrlrange="-1 1"/>',
    "general": '<general name="m" tendon="t" gaintype="affine" gainprm="-15 -20 1" '
    'biastype="affine" biasprm="-4 -3 -5" dyntype="filter" dynprm=".03" ctrlrange="0 1"/>',
    "two": '<motor name="m" tendon="t" ctrlrange="-9 0"/>'
    '<position name="n" tendon="t" kp="100" kv="9" ctrlrange=".1 .5"/>',
    "geared": '<motor name="m" tendon="t" gear="3" damping=".5" armature=".01" ctrlrange="-9 0"/>',
}
SITES = '<site site="a"/><site site="k"/><site site="b"/>'


def rig(actuators=MOTORS["motor"], first='<site name="a" pos="-.2 0 0"/>', path=SITES, rest=""):
    """A swinging link that a tendon pulls on, beside another one; the motors are on the tendon."""
    return mujoco.MjSpec.from_string(f"""<mujoco><option timestep="0.001" gravity="0 0 0"/>
      <default><joint range="-1 1" armature=".003"/><geom mass=".1"/></default>
      <worldbody><site name="k" pos="-.02 0 .05"/>
        <body name="base"><joint name="turn" axis="0 0 1" stiffness="5" damping=".3"/>
          <geom size=".05" contype="0" conaffinity="0"/>{first}</body>
        <body name="link"><joint name="q" axis="0 1 0" stiffness="1" damping=".05"/>
          <geom type="capsule" fromto="0 0 0 .2 0 0" size=".01" contype="0" conaffinity="0"/>
          <site name="b" pos=".1 0 .03"/></body>
        <body name="other" pos="0 1 0"><joint name="p" axis="0 1 0"/>
          <geom size=".05" contype="0" conaffinity="0"/></body>
      </worldbody>
      <tendon><spatial name="t" range=".2 .4">{path}</spatial></tendon>
      <actuator>{actuators}</actuator>
      <keyframe><key name="bent" qpos=".1 .4 .7" qvel="1 2 3"/><key name="plain"/></keyframe>
      {rest}</mujoco>""")


def wound(spec, friction=0.0, **given):
    spool = Spool(radius=RADIUS, **given.pop("spool", {}))
    return add_friction(
        spec, "t", friction=friction, axial_stiffness=STIFFNESS, spool=spool, **given
    )


def force_of(model, data):
    """Force of all actuators along the tendon, pulling where it is positive."""
    on = np.flatnonzero(model.actuator_trnid[:, 0] == model.joint("t_spool").id)
    return -(model.actuator_gear[on, 0] * data.actuator_force[on]).sum() / -RADIUS


def middle(model):
    low, high = model.actuator_ctrlrange.T
    return low + 0.3 * (high - low)


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("kind", [k for k in MOTORS if k not in ("velocity", "integrator")])
def test_at_rest_the_motor_s_force_is_the_tension_with_its_energy(kind, friction):
    model = wound(rig(MOTORS[kind]), friction).compile()
    data = simulated(model, 6000, forward=True, ctrl=middle(model))
    view = view_sheath(model, data, "t")
    assert np.abs(data.qvel).max() < 1e-4
    tension = view.input_tension
    assert tension > 1.0
    assert tension + tension**2 / (2.0 * STIFFNESS) == pytest.approx(
        force_of(model, data), rel=1e-4
    )
    assert view.unsolved == 0


@pytest.mark.parametrize("kind", MOTORS)
def test_without_friction_it_moves_as_the_tendon_motor_did(kind):
    """But for its stretch and the inertia of the spool, small here, and where the motor pushed."""
    paths = []
    specs = [rig(MOTORS[kind]), rig(MOTORS[kind])]
    for spec in specs:
        spec.option.timestep = 1e-4
    wound(specs[1], axial_damping=20.0, spool={"armature": 2e-6})
    plain, light = (spec.compile() for spec in specs)
    for model in (plain, light):
        data = mujoco.MjData(model)
        joint = model.joint("q").qposadr[0]
        path = []
        for k in range(5000):
            data.ctrl[:] = middle(plain) * (1.0 - 0.1 * math.sin(k / 800.0))
            mujoco.mj_step(model, data)
            path.append(data.qpos[joint])
        paths.append(path)
    one, other = np.array(paths)
    assert np.ptp(one) > 0.02
    assert np.abs(one - other).max() < 0.06 * np.ptp(one)


@pytest.mark.parametrize("kind", MOTORS)
def test_controls_and_their_ranges_mean_what_they_did(kind):
    plain, model = rig(MOTORS[kind]).compile(), wound(rig(MOTORS[kind])).compile()
    for field in ("ctrlrange", "ctrllimited", "forcerange", "forcelimited", "dynprm", "actrange"):
        one, other = (getattr(m, f"actuator_{field}") for m in (plain, model))
        np.testing.assert_array_equal(one, other, err_msg=field)
    assert (model.actuator_trnid[:, 0] == model.joint("t_spool").id).all()
    assert (model.actuator_trntype == mujoco.mjtTrn.mjTRN_JOINT.value).all()


def test_as_it_slides_the_capstan_ratio_is_exact():
    model = wound(rig(MOTORS["velocity"]), 0.25).compile()
    data = mujoco.MjData(model)
    seen = set()
    for _ in range(300):
        data.ctrl[:] = -0.1
        mujoco.mj_step(model, data)
        view = view_sheath(model, data, "t")
        sense = float(view.slip[0])
        seen.add(sense)
        if sense != 0.0:
            ratio = math.exp(sense * 0.25 * view.bend_angle[0])
            assert view.input_tension / view.output_tension == pytest.approx(ratio, rel=1e-9)
    assert 1.0 in seen


@pytest.mark.parametrize("between", ["nothing", "compiled", "copied"])
@pytest.mark.parametrize("kind", MOTORS)
def test_adding_and_removing_leaves_every_number_as_it_was(kind, between):
    before, spec = rig(MOTORS[kind]).compile(), wound(rig(MOTORS[kind]), 0.3)
    if between == "compiled":
        spec.compile()
    if between == "copied":
        spec = spec.copy()
    remove_friction(spec, "t")
    assert not [*spec.sensors, *spec.plugins, *spec.texts]
    assert_equal(before, spec.compile())


def test_a_written_model_can_be_undone_too():
    spec = mujoco.MjSpec.from_string(wound(rig(), 0.3).to_xml())
    remove_friction(spec, "t")
    model, before = spec.compile(), rig().compile()
    assert (model.nq, model.nbody) == (before.nq, before.nbody)
    np.testing.assert_array_equal(model.actuator_gear, before.actuator_gear)
    np.testing.assert_array_equal(model.actuator_trntype, before.actuator_trntype)
    np.testing.assert_allclose(model.key_qpos, before.key_qpos)


@pytest.mark.parametrize(("prefix", "suffix"), [("left_", ""), ("l_", "_l")])
def test_the_motors_are_found_again_after_attach(prefix, suffix):
    parent = mujoco.MjSpec()
    parent.option.timestep, parent.option.gravity = 0.001, [0.0, 0.0, 0.0]
    parent.attach(
        wound(rig(), 0.3), prefix=prefix, suffix=suffix, frame=parent.worldbody.add_frame()
    )
    tendon = f"{prefix}t{suffix}"
    model = parent.compile()
    assert sheaths(model).popitem()[1].tendon == tendon
    data = simulated(model, 3000, ctrl=-5.0)
    assert view_sheath(model, data, tendon).input_tension == pytest.approx(10.0, rel=1e-2)
    remove_friction(parent, tendon)
    actuator = parent.actuators[0]
    assert (actuator.target, actuator.gear[0]) == (tendon, 2.0)
    assert not [*parent.texts, *parent.plugins]
    parent.compile()


def test_in_keyframes_the_spool_has_wound_in_as_much_as_the_pose_spares():
    model = wound(rig(), pretension=6.0).compile()
    data = mujoco.MjData(model)
    spool = model.joint("t_spool")
    assert spool.qposadr[0] == 1, "it is on the first body, so the others move on"
    for key, (turn, q, p) in enumerate([(0.1, 0.4, 0.7), (0.0, 0.0, 0.0)]):
        mujoco.mj_resetDataKeyframe(model, data, key)
        mujoco.mj_forward(model, data)
        assert [data.joint(j).qpos[0] for j in ("turn", "q", "p")] == [turn, q, p]
        assert view_sheath(model, data, "t").input_tension == pytest.approx(6.0, rel=1e-9)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    assert data.joint("t_spool").qpos[0] != 0.0
    assert list(data.qvel) == [1.0, 0.0, 2.0, 3.0]


def test_the_spool_is_what_was_asked_for_and_takes_nothing_from_the_model_s_defaults():
    model = wound(rig(), spool={"armature": 3e-4, "damping": 2e-4}).compile()
    joint = model.joint("t_spool")
    dof = joint.dofadr[0]
    assert (model.dof_armature[dof], model.dof_damping[dof]) == (3e-4, 2e-4)
    assert not model.jnt_limited[joint.id]
    assert model.body("t_spool").mass[0] == pytest.approx(1e-6)
    assert model.body("t_spool").parentid[0] == model.body("base").id
    data = simulated(model)
    # the drum touches the first span at its first site, and winds in as it turns forward
    arm = data.site("a").xpos - data.body("t_spool").xpos
    span = data.site("k").xpos - data.site("a").xpos
    assert np.linalg.norm(arm) == pytest.approx(RADIUS)
    rim = np.cross(data.xaxis[joint.id], arm) / RADIUS
    assert rim @ span / np.linalg.norm(span) == pytest.approx(-1.0)


def test_the_default_inertia_is_one_that_the_step_resolves():
    for step, stiffness in ((1e-3, 2e4), (2e-3, 5e3)):
        spec = rig()
        spec.option.timestep = step
        add_friction(spec, "t", friction=0.2, axial_stiffness=stiffness, spool=Spool(radius=RADIUS))
        model = spec.compile()
        first = np.linalg.norm(np.array([-0.02, 0.0, 0.05]) - np.array([-0.2, 0.0, 0.0]))
        armature = model.dof_armature[model.joint("t_spool").dofadr[0]]
        expected = 4.0 * RADIUS**2 * step**2 * stiffness / first
        assert armature == pytest.approx(expected, rel=1e-9)


def test_an_inertia_that_the_step_does_not_follow_is_said():
    with pytest.warns(TendonWarning, match=r"spool of 't'.*an armature of 2\.\d"):
        wound(rig(), spool={"armature": 1e-7})
    with silent():
        wound(rig(), spool={"armature": 3e-6})


def test_a_servo_can_turn_it():
    spec = wound(rig(), 0.2, pretension=2.0, spool={"armature": 1e-4})
    add_servo(spec, "t", tension_gain=10.0, velocity_gain=0.02, motor_inertia=1e-4)
    spec.compile()
    with refusing(InvalidValueError, "servo", "'t'"):
        remove_friction(spec, "t")


MUSCLE = '<muscle name="n" tendon="t" force="60" lengthrange=".1 .5"/>'
GENERAL = '<general name="n" tendon="t" {}/>'
REFUSED = {
    "no actuator": ('<motor joint="q"/>', {}, ("'t'", "actuator")),
    "a muscle": (MUSCLE, {}, ("'t'", "'n'", "muscle")),
    "a muscle too": (MOTORS["motor"] + MUSCLE, {}, ("'t'", "'n'", "muscle")),
    "gain": (GENERAL.format('gaintype="user"'), {}, ("'n'", "mjGAIN_USER")),
    "bias": (GENERAL.format('biastype="user"'), {}, ("'n'", "mjBIAS_USER")),
    "dynamics": (GENERAL.format('dyntype="user" actdim="2"'), {}, ("'n'", "mjDYN_USER")),
    "stiffness": (MOTORS["motor"], {"axial_stiffness": None}, ("axial_stiffness [N]",)),
    "a reel": (MOTORS["motor"], {"reel": "r"}, ("spool", "reel")),
    "joint": (MOTORS["motor"], {"reel_joint": "q", "reel_radius": 0.1}, ("spool", "reel_joint")),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_would_not_pull_as_before_is_refused_by_name_and_reason(case):
    actuators, given, facts = REFUSED[case]
    spec = rig(actuators)
    before = spec.to_xml() if case != "no actuator" else None
    arguments = {"friction": 0.1, "axial_stiffness": 1e4, "spool": Spool(radius=0.01)} | given
    with refusing(ValueError, *facts):
        add_friction(spec, "t", **arguments)
    assert before is None or spec.to_xml() == before


@pytest.mark.parametrize("slack", [0.0, 0.01])
def test_a_spring_beside_the_motor_is_refused(slack):
    spec = rig()
    spec.tendon("t").stiffness[0] = 50.0
    with refusing(InvalidValueError, "'t'", "spring"):
        wound(spec, slack=slack)


@pytest.mark.parametrize(
    ("given", "fact"),
    [
        ({"radius": 0.0}, "radius = 0.0 [m]"),
        ({"radius": math.nan}, "radius = nan [m]"),
        ({"radius": 0.1, "armature": 0.0}, "armature = 0.0 [kg m²]"),
        ({"radius": 0.1, "damping": -1.0}, "damping = -1.0 [N m s/rad]"),
    ],
)
def test_a_spool_checks_its_numbers(given, fact):
    with refusing(InvalidValueError, fact):
        Spool(**given)


def test_a_pattern_gives_each_tendon_a_spool_and_leaves_out_those_that_cannot():
    more = (
        '<motor name="m" tendon="t"/><motor name="n" tendon="u"/>'
        '<muscle name="o" tendon="v" force="60" lengthrange=".1 .5"/>'
    )
    others = "".join(f'<spatial name="{t}">{SITES}</spatial>' for t in "uv")
    rest = f"<tendon>{others}</tendon>"
    before, spec = rig(more, rest=rest).compile(), rig(more, rest=rest)
    with pytest.warns(TendonWarning, match="'v': is pulled by actuator 'o'"):
        add_friction(spec, "*", friction=0.1, axial_stiffness=1e4, spool=Spool(radius=0.01))
    model = spec.compile()
    assert [model.joint(f"{t}_spool").id for t in "tu"] == [1, 2]
    remove_friction(spec, "*")
    assert_equal(before, spec.compile())


NEEDS = {
    "shown": lambda spec: spec.add_sensor(
        name="shown",
        type=mujoco.mjtSensor.mjSENS_JOINTPOS,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        objname="t_spool",
    ),
    "actuators": lambda spec: spec.add_actuator(
        name="brake", trntype=mujoco.mjtTrn.mjTRN_JOINT, target="t_spool"
    ),
    "body": lambda spec: spec.body("t_spool").add_geom(
        type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.01, 0, 0]
    ),
    "coupled": lambda spec: spec.add_equality(
        name="coupled",
        type=mujoco.mjtEq.mjEQ_JOINT,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        name1="t_spool",
        name2="p",
    ),
}


@pytest.mark.parametrize("need", NEEDS)
def test_a_spool_that_more_hangs_on_is_not_taken_away(need):
    spec = wound(rig())
    NEEDS[need](spec)
    with refusing(InvalidValueError, "'t_spool'", "'t'", need):
        remove_friction(spec, "t")
    assert len(sheaths(spec.compile())) == 1
    assert kept_drives(spec, "t")


def test_a_reel_joint_of_the_model_s_own_stays():
    spec = rig()
    spec.delete(spec.actuators[0])
    given = {"axial_stiffness": 1e4, "pretension": 1.0, "reel_joint": "q", "reel_radius": 0.01}
    before = spec.compile()
    add_friction(spec, "t", friction=0.1, **given)
    remove_friction(spec, "t")
    assert_equal(before, spec.compile())
