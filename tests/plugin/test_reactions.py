"""Force and torque sensors read the tension of each span, as if it were applied to the bodies.

The reference is a model without tendon, in the same pose and motion, whose bodies are pulled by
`xfrc_applied` along the spans that MuJoCo draws. It has to accelerate as the model with the tendon
does, and its sensors and `cfrc_int` have to read the same.
"""

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction, view_sheath
from tests.plugin.drawn_spans import pieces_of
from tests.rigs import sheath_view, simulated

AGREE = 1e-9
LINKS = 4
PATHS = {
    "sites": ["a", "b0", "m1", "b2", "m2", "b3"],
    "wraps": ["a", "b0", "drum1", "m1", "ball2", "b3"],
    "pulley": ["a", "b0", "m1", "/2", "b1", "b2", "/3", "m2", "b3"],
}
# what drives the tendon, and what its sheath is given
DRIVES = {
    "motor": {},
    "muscle": {},
    "input": {"spring": "input"},
    "cable": {"spring": "cable"},
    "reel": {"axial_stiffness": 2e3, "pretension": 10.0, "reel": "reel"},
    "spools": {"axial_stiffness": 2e3, "pretension": 30.0, "reel_joint": "wound",
               "reel_radius": 0.01, "output_joint": "paid_out", "output_radius": -0.02},
    "equality": {},
    "limit": {},
}  # fmt: skip


def arm(seed, path="", drive=""):
    """A random arm with a load cell in every joint; with a sheathed tendon where one is drawn."""
    rng = np.random.default_rng(seed)
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.option.timestep = 5e-4
    spec.option.tolerance, spec.option.iterations = 1e-14, 1000  # of constraints
    spec.option.integrator = [0, 2, 3][seed % 3]
    spec.worldbody.add_site(name="a", pos=[-0.2, 0.02, 0.05])
    body = spec.worldbody
    for k in range(LINKS):
        body = body.add_body(name=f"link{k}", pos=[0.12 * (k > 0), 0, 0], quat=turned(rng, 0.3))
        kind = mujoco.mjtJoint.mjJNT_BALL if rng.random() < 0.3 else mujoco.mjtJoint.mjJNT_HINGE
        joint = body.add_joint(name=f"joint{k}", type=kind, axis=rng.normal(size=3))
        joint.damping[0], joint.stiffness[0] = 0.02, 1.0
        body.add_geom(
            fromto=[0, 0, 0, 0.1, 0, 0],
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            size=[0.01, 0, 0],
            contype=0,
            conaffinity=0,
        )
        for name, at in (("b", 0.02), ("m", 0.08)):
            body.add_site(name=f"{name}{k}", pos=[at, *rng.uniform(0.02, 0.04, 2)])
        shape = {"size": [0.012, 0.03, 0], "contype": 0, "conaffinity": 0, "mass": 0.01}
        body.add_geom(name=f"drum{k}", type=mujoco.mjtGeom.mjGEOM_CYLINDER, **shape)
        body.add_geom(name=f"ball{k}", type=mujoco.mjtGeom.mjGEOM_SPHERE, **shape)
        cell = body.add_site(name=f"cell{k}", pos=rng.uniform(-0.01, 0.01, 3), quat=turned(rng, 1))
        for kind in ("force", "torque"):
            spec.add_sensor(
                name=f"{kind}{k}",
                type=getattr(mujoco.mjtSensor, f"mjSENS_{kind.upper()}"),
                objtype=mujoco.mjtObj.mjOBJ_SITE,
                objname=cell.name,
            )
    for name in ("wound", "paid_out"):
        spool = spec.worldbody.add_body(name=name)
        joint = spool.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, armature=1e-3)
        joint.damping[0], joint.stiffness[0] = 1.0, 10.0
        spool.add_geom(size=[0.01, 0, 0], mass=0.1, contype=0, conaffinity=0)
    if path:
        draw(spec, PATHS[path], drive)
    return spec


def turned(rng, angle):
    axis = rng.normal(size=3)
    return [np.cos(angle / 2), *np.sin(angle / 2) * axis / np.linalg.norm(axis)]


def draw(spec, path, drive):
    tendon = spec.add_tendon(name="tendon")
    for name in path:
        if name[0] == "/":
            tendon.wrap_pulley(float(name[1:]))
        elif (name[0] in "ab" and name[:4] != "ball") or name[0] == "m":
            tendon.wrap_site(name)
        else:
            tendon.wrap_geom(name, "")
    if drive in ("motor", "muscle"):
        on_tendon = {"trntype": mujoco.mjtTrn.mjTRN_TENDON, "target": "tendon"}
        actuator = spec.add_actuator(name="pull", **on_tendon)
        actuator.gear[0] = -20.0
        if drive == "muscle":
            actuator.gear[0] = 1.0
            actuator.set_to_muscle(tausmooth=0.0, force=50.0)
            actuator.lengthrange = [0.3, 0.7]
            actuator.ctrlrange, actuator.ctrllimited = [0, 1], 1
    if drive in ("input", "cable"):
        tendon.stiffness[0], tendon.springlength = 300.0, [0.4, 0.4]
    if drive == "equality":
        offset = [-0.02] + [0] * (mujoco.mjNEQDATA - 1)
        spec.add_equality(type=mujoco.mjtEq.mjEQ_TENDON, name1="tendon", data=offset)
    if drive == "limit":
        tendon.limited, tendon.range = 1, [0.0, 0.1]
    add_friction(spec, "tendon", friction=0.2, name="sheath", **DRIVES[drive])


def pulled_without_tendon(seed, model, data):
    """The arm without tendon in the same pose and motion, its bodies pulled along the spans."""
    plain = arm(seed).compile()
    other = mujoco.MjData(plain)
    other.qpos[:], other.qvel[:] = data.qpos, data.qvel
    mujoco.mj_kinematics(plain, other)
    mujoco.mj_comPos(plain, other)
    view, state = view_sheath(model, data, "sheath"), sheath_view(model, data, "sheath").state
    late = -constraint_force(model, data)  # uniform, not yet rubbed
    if state.constrained != 0.0:  # by nothing else
        late += float(state.input_force)
    for piece in pieces_of(model, data, 0):
        for body, at, force in piece.pulls(view.tension[piece.segment] + late / piece.divisor):
            other.xfrc_applied[body, :3] += force
            other.xfrc_applied[body, 3:] += np.cross(at - other.xipos[body], force)
    other.xfrc_applied[0] = 0.0
    for end, radius, joint in ((0, 0.01, "wound"), (-1, -0.02, "paid_out")):
        if state.reel_joint >= 0:
            tension, ea = view.tension[end], view.axial_stiffness
            laid = 1.0 + view.pretension / ea
            torque = -radius * tension * (1.0 + 0.5 * tension / ea) / laid
            other.qfrc_applied[plain.joint(joint).dofadr[0]] = torque
    mujoco.mj_forward(plain, other)
    return other


def constraint_force(model, data):
    """Force along the tendon of its equality, its limit or its `frictionloss` [N]."""
    force = 0.0
    kinds = mujoco.mjtConstraint
    for kind, value in zip(data.efc_type, data.efc_force, strict=True):
        if any(kind == k for k in (kinds.mjCNSTR_EQUALITY, kinds.mjCNSTR_FRICTION_TENDON)):
            force += value
        if kind == kinds.mjCNSTR_LIMIT_TENDON:
            force -= value
    return force


def simulate(seed, path, drive, steps):
    model = arm(seed, path, drive).compile()
    data = mujoco.MjData(model)
    rng = np.random.default_rng(seed + 100)
    goal = rng.uniform(0.3, 1.0) * (0.01 if drive == "reel" else 1.0)
    for k in range(steps):
        if model.nu:
            data.ctrl[0] = goal * min(1.0, k / 300)
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    return model, data


CASES = [
    (seed, path, drive)
    for seed, (path, drive) in enumerate(
        (path, drive)
        for _ in range(2)
        for drive in DRIVES
        for path in PATHS
        if path != "pulley" or drive in ("motor", "muscle", "input", "equality", "limit")
    )
]


@pytest.mark.parametrize(("seed", "path", "drive"), CASES)
@pytest.mark.parametrize("steps", [40, 3000], ids=["moving", "later"])
def test_sensors_read_what_the_spans_pull(seed, path, drive, steps):
    check_sensors(*simulate(seed, path, drive, steps), seed, drive)


@pytest.mark.parametrize("path", PATHS)
def test_they_read_the_tendon_s_own_frictionloss(path):
    spec = arm(50, path, "motor")
    spec.tendon("tendon").frictionloss = 3.0
    spec.tendon("tendon").damping[0] = 5.0
    model = spec.compile()
    data = simulated(model, 40, forward=True, ctrl=0.6)
    assert abs(constraint_force(model, data)) > 0.1
    check_sensors(model, data, 50, "motor")


def check_sensors(model, data, seed, drive):
    other = pulled_without_tendon(seed, model, data)
    view = view_sheath(model, data, "sheath")
    if drive != "spools":  # which swing, and let the tendon go slack now and then
        assert view.input_tension > 0.1
        assert np.ptp(view.tension) > 1e-2  # friction acts
    largest = np.abs(data.sensordata).max()
    acceleration = max(1.0, np.abs(other.qacc).max())
    np.testing.assert_allclose(data.qacc, other.qacc, rtol=0, atol=1e-8 * acceleration)
    names = [f"{kind}{k}" for kind in ("force", "torque") for k in range(LINKS)]
    for name in names:
        read, meant = data.sensor(name).data, other.sensor(name).data
        np.testing.assert_allclose(read, meant, rtol=0, atol=AGREE * largest, err_msg=name)
    np.testing.assert_allclose(data.cfrc_int, other.cfrc_int, rtol=0, atol=AGREE * largest)


def test_a_second_look_at_the_sensors_changes_nothing():
    model, data = simulate(0, "sites", "motor", 100)
    before, inner = data.sensordata.copy(), data.cfrc_int.copy()
    mujoco.mj_sensorAcc(model, data)
    np.testing.assert_array_equal(data.sensordata, before)
    np.testing.assert_array_equal(data.cfrc_int, inner)
    mujoco.mj_rnePostConstraint(model, data)  # as MuJoCo has it, with one tension
    assert np.abs(data.cfrc_int - inner).max() > 1e-3
    mujoco.mj_sensorAcc(model, data)
    np.testing.assert_array_equal(data.sensordata, before)
    np.testing.assert_array_equal(data.cfrc_int, inner)


def test_cutoffs_and_delays_of_sensors_hold():
    spec = arm(0, "sites", "motor")
    spec.sensor("force1").cutoff = 1.0
    late = spec.sensor("force2")
    late.nsample, late.delay = 20, 0.005
    plain = simulate(0, "sites", "motor", 60)[0]
    model = spec.compile()
    one, two = mujoco.MjData(plain), mujoco.MjData(model)
    history = []
    for k in range(60):
        for m, d in ((plain, one), (model, two)):
            d.ctrl[0] = 0.5 * min(1.0, k / 300)
            mujoco.mj_step(m, d)
        history.append(one.sensor("force2").data.copy())
        meant = np.clip(one.sensor("force1").data, -1.0, 1.0)
        np.testing.assert_array_equal(two.sensor("force1").data, meant)
    assert np.abs(one.sensor("force1").data).max() > 1.0
    np.testing.assert_allclose(two.sensor("force2").data, history[-11], rtol=1e-9)


@pytest.mark.parametrize("drive", ["motor", "cable", "reel", "spools"])
def test_inverse_dynamics_give_back_the_actuators_forces(drive):
    model, data = simulate(3, "wraps", drive, 200)
    actuators = data.qfrc_actuator.copy()
    mujoco.mj_inverse(model, data)
    largest = np.abs(data.qfrc_passive).max()
    np.testing.assert_allclose(data.qfrc_inverse, actuators, rtol=0, atol=1e-9 * largest)
