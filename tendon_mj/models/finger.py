"""A finger driven through sheaths, from its parameters.

Three joints, a flexor and an extensor, each from a motor's spool through a sheath that bends in the
forearm and back at the wrist, along the palm and over guides on the phalanges.
`models/finger/finger.xml` is the one with the defaults.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, field
from functools import cache, partial
from typing import Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.attach import add_friction, add_sensor, add_sites, add_tendon, arc_points
from tendon_mj.errors import InvalidValueError
from tendon_mj.models.bench import check_parameters
from tendon_mj.models.load import models_folder
from tendon_mj.typing import FloatArray, IntArray

JOINTS = ("mcp", "pip", "dip")
TENDONS = ("flexor", "extensor")
FORWARD, UP = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
FLEXION = np.array([0.0, 1.0, 0.0])  # turned about it, a finger along +x goes down
SIDE = {"flexor": -1.0, "extensor": 1.0}  # of the finger where the tendon is, up being the back
_CAN_BE_0 = ("friction", "pretension", "stiffness", "damping", "armature", "bend")
_OBJECT_POSE = ("object_x", "object_z", "object_angle")
# of a tendon, in drawings and charts: blue and vermilion of Okabe and Ito's palette
TENDON_COLOUR = {
    "flexor": (0 / 255, 114 / 255, 178 / 255, 1.0),
    "extensor": (213 / 255, 94 / 255, 0 / 255, 1.0),
}
_COLOUR = {
    "skin": (0.82, 0.6, 0.48, 1.0),
    "flesh": (0.94, 0.82, 0.76, 1.0),
    "bone": (0.98, 0.96, 0.9, 1.0),
}
_STEEL, _OBJECT = [0.45, 0.47, 0.5, 1.0], [0.3, 0.33, 0.38, 1.0]
_CONTACT = 3  # group of the geoms that touch, which viewers do not show
_FOR_SHOW: dict[str, Any] = {"group": 1, "mass": 0.0, "contype": 0, "conaffinity": 0}  # for the eye
_PHALANX = 1  # contact bit: phalanges touch the object and nothing else
_OBJECT_SIZE = (0.007, 0.012, 0.008)  # half edges of the object [m]
_RAIL = np.array([0.0, 0.0165, 0.0])  # of the rod that guides the object, behind the finger [m]
_PIN = 0.0013, 0.0012, 0.006  # radius, front and back of the pins that guides are drawn with [m]
# so light joints would otherwise give way to the motors' pull; 2 steps are the stiffest that MuJoCo
# takes
_LIMIT_STEPS, _LIMIT_SOLIMP = 2.0, (0.99, 0.999, 0.01, 0.5, 2.0)
_TENDON_RADIUS = 0.0004  # as drawn [m]


@dataclass(frozen=True, kw_only=True)
class FingerJoint:
    """A joint of the finger and the phalanx after it."""

    length: float  # of the phalanx [m]
    radius: float  # of the phalanx with its soft tissue [m]
    mass: float  # of the phalanx [kg]
    low: float  # range of the joint, flexion positive [rad]
    high: float
    stiffness: float  # passive [N m/rad]
    damping: float  # passive [N m s/rad]
    armature: float  # inertia of the joint besides the phalanges' [kg m²]
    flexor_offset: float  # of the guides, to the palm's side of the joint's axis [m]
    flexor_before: float  # along the finger, from the guide to the axis [m]
    flexor_after: float  # from the axis to the next guide [m]
    extensor_offset: float  # of the guides, to the back of the axis [m]
    extensor_reach: float  # along the finger, from the axis to the guide on either side [m]

    def __post_init__(self) -> None:
        check_parameters(vars(self), may_be_0=_CAN_BE_0, signed=("low",), where="joint: ")
        if self.high <= self.low:
            raise InvalidValueError(f"joint: low = {self.low} must be below high = {self.high}")

    def guides(self, tendon: str) -> tuple[FloatArray, FloatArray]:
        """The guide before the axis and the one after it, from the axis, at angle 0 [m]."""
        if tendon == "flexor":
            before, after, offset = self.flexor_before, self.flexor_after, self.flexor_offset
        else:
            before = after = self.extensor_reach
            offset = self.extensor_offset
        side = SIDE[tendon] * offset * UP
        return side - before * FORWARD, side + after * FORWARD

    def span(self, tendon: str, angle: ArrayLike) -> FloatArray:
        """Length of tendon between the joint's two guides at angles [rad], in their shape [m]."""
        before, after = self.guides(tendon)
        q = np.asarray(angle, float)
        x = np.cos(q) * after[0] + np.sin(q) * after[2]
        z = np.cos(q) * after[2] - np.sin(q) * after[0]
        length: FloatArray = np.hypot(x - before[0], z - before[2])
        return length


@cache
def _default_joint(name: str) -> FingerJoint:
    """A joint with the numbers of `models/finger/parameters.toml`."""
    text = (models_folder() / "finger" / "parameters.toml").read_text(encoding="utf-8")
    return FingerJoint(**{key: entry["value"] for key, entry in tomllib.loads(text)[name].items()})


@dataclass(frozen=True, kw_only=True)
class Finger:
    """Parameters of the finger; the defaults are those of `models/finger/parameters.toml`."""

    mcp: FingerJoint = field(default_factory=partial(_default_joint, "mcp"))
    pip: FingerJoint = field(default_factory=partial(_default_joint, "pip"))
    dip: FingerJoint = field(default_factory=partial(_default_joint, "dip"))
    friction: float = 0.15  # μ of both tendons, static = dynamic [-]
    axial_stiffness: float = 2000.0  # EA of each tendon [N]
    pretension: float = 4.0  # T_0 of each tendon in the reference pose, the finger straight [N]
    bend: float = np.pi * 2.0 / 3.0  # of each sheath, half in the forearm, half at the wrist [rad]
    forearm_length: float = 0.14  # of sheath [m]
    wrist_length: float = 0.06
    forearm_guides: int = 3  # sites that stand for each part of the sheath
    wrist_guides: int = 3
    palm_length: float = 0.0681  # from the wrist to the MCP's axis [m]
    free_length: float = 0.03  # from the spool to the sheath [m]
    spool_radius: float = 0.008  # r [m]
    rotor_inertia: float = 5e-7  # of each motor [kg m²]
    gear: float = 30.0  # turns of the rotor per turn of the spool
    motor_damping: float = 0.01  # seen at the spool [N m s/rad]
    servo_stiffness: float = 50.0  # of the motors' position control, at the spool [N m/rad]
    servo_damping: float = 0.3  # of that control [N m s/rad]
    servo_margin: float = 1.0  # by which its range exceeds that of the joints [rad]
    motor_torque: float = 0.03  # most that a rotor gives [N m]
    object_stiffness: float = 2000.0  # k_e of the object's spring [N/m]
    object_mass: float = 0.05  # [kg]
    object_x: float = 0.033  # position of the middle of the object's face, from the MCP's axis [m]
    object_z: float = -0.048
    object_angle: float = -np.pi / 12.0  # in which it is pressed, below the straight finger [rad]
    timestep: float = 0.001  # [s]

    def __post_init__(self) -> None:
        numbers = {name: value for name, value in vars(self).items() if name not in JOINTS}
        check_parameters(numbers, may_be_0=_CAN_BE_0, signed=_OBJECT_POSE)

    @property
    def joints(self) -> dict[str, FingerJoint]:
        """The joints by name, from the palm outwards."""
        return {name: getattr(self, name) for name in JOINTS}

    @property
    def resting_torque(self) -> float:
        """Torque of a tendon on its spool under the pretension, r (T_0 + T_0²/2EA)/(1 + ε_0)."""
        strain = self.pretension / self.axial_stiffness
        return self.spool_radius * self.pretension * (1.0 + 0.5 * strain) / (1.0 + strain)


def sheath_points(finger: Finger, tendon: str) -> FloatArray:
    """Points of the tendon from the spool over the guides of forearm and wrist, (k, 3) [m].

    From the last of them it runs straight along the palm to the finger.
    """
    half = 0.5 * finger.bend
    forearm = arc_points(finger.forearm_length, half, finger.forearm_guides, normal=-FLEXION)
    heading = np.cos(half) * FORWARD + np.sin(half) * UP
    wrist = arc_points(
        finger.wrist_length, -half, finger.wrist_guides, forearm[-1], heading, -FLEXION
    )
    path = np.vstack([-finger.free_length * FORWARD, forearm[1:-1], wrist[1:-1]])
    side = finger.mcp.guides(tendon)[0][2] * UP
    shifted: FloatArray = path - wrist[-1] - finger.palm_length * FORWARD + side
    return shifted


def spool_angles(finger: Finger, angles: ArrayLike) -> dict[str, FloatArray]:
    """Angles that the spools must turn by for joint angles, friction and stretch neglected.

    θ = −ΔL(q)/r, positive where tendon is wound in: (…) for (…, 3) of MCP, PIP, DIP [rad].
    """
    q = np.asarray(angles, float)
    turned = {}
    for tendon in TENDONS:
        longer = np.zeros(q.shape[:-1])
        for k, joint in enumerate(finger.joints.values()):
            longer = longer + joint.span(tendon, q[..., k]) - joint.span(tendon, 0.0)
        turned[tendon] = -longer / finger.spool_radius
    return turned


def build_finger(finger: Finger, *, spring_return: bool = False) -> mujoco.MjSpec:
    """The finger as an editable model.

    For every tendon t of `flexor`, `extensor`: tendon `t`, sheath `t_sheath`, spool `t_motor`;
    actuators `t_angle`, where the spool is to be [rad], which bears the pretension besides, and
    `t_torque` of the rotor [N m] on top, which drives alone once the other's kp and kv are 0;
    sensors `t_input_tension`, `t_output_tension` [N] (both in `t_sheath`), `t_motor_angle` [rad].
    Hinges `mcp`, `pip`, `dip` with sensors `mcp_angle`, … [rad]; sensor `tip_force` [N]; slide
    `object` with sensor `object_displacement` [m]. With ``spring_return`` there is no extensor: the
    joints' springs alone extend the finger.
    """
    spec = mujoco.MjSpec()
    spec.modelname = "finger_spring" if spring_return else "finger"
    spec.compiler.degree = False
    spec.option.timestep = finger.timestep
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    tendons = TENDONS[:1] if spring_return else TENDONS
    _add_phalanges(spec, finger)
    _add_object(spec, finger)
    for tendon in tendons:
        _add_motor(spec, finger, tendon)
        _add_path(spec, finger, tendon)
        add_friction(
            spec,
            tendon,
            name=f"{tendon}_sheath",
            friction=finger.friction,
            axial_stiffness=finger.axial_stiffness,
            pretension=finger.pretension,
            reel_joint=f"{tendon}_motor",
            reel_radius=finger.spool_radius,
            sensors=(),
        )
    _add_finger_sensors(spec, tendons)
    _balance_springs(spec, finger)
    return spec


def _add_phalanges(spec: mujoco.MjSpec, finger: Finger) -> None:
    body, start = spec.worldbody, np.zeros(3)
    for name, joint in finger.joints.items():
        body = body.add_body(name=name, pos=start)
        start = joint.length * FORWARD
        hinge = body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=FLEXION)
        hinge.range, hinge.limited = [joint.low, joint.high], True
        hinge.stiffness[0], hinge.damping[0] = joint.stiffness, joint.damping
        hinge.armature = joint.armature
        hinge.solref_limit = [_LIMIT_STEPS * finger.timestep, 1.0]
        hinge.solimp_limit = _LIMIT_SOLIMP
        end = joint.length if name != JOINTS[-1] else joint.length - joint.radius
        body.add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            size=[joint.radius, 0.0, 0.0],
            fromto=[0.0, 0.0, 0.0, end, 0.0, 0.0],
            mass=joint.mass,
            group=_CONTACT,
            contype=_PHALANX,
            conaffinity=0,
        )
        _draw_phalanx(spec, body, joint)
    tip = finger.dip
    body.add_site(
        name="tip",
        type=mujoco.mjtGeom.mjGEOM_CAPSULE,
        size=[1.2 * tip.radius, 0.0, 0.0],
        fromto=[0.0, 0.0, 0.0, tip.length - tip.radius, 0.0, 0.0],
        rgba=[0.0, 0.0, 0.0, 0.0],
    )


def _draw_phalanx(spec: mujoco.MjSpec, body: mujoco.MjsBody, joint: FingerJoint) -> None:
    """Bone, flesh and skin of the package's finger, as long and thick as this phalanx."""
    own = _default_joint(body.name)
    across = joint.radius / own.radius
    for part, rgba in _COLOUR.items():
        name = f"{body.name}_{part}"
        vertices, faces = _shapes()[name]
        scale = [joint.length / own.length, across, across]
        spec.add_mesh(name=name, uservert=vertices, userface=faces, scale=scale)
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, rgba=rgba, **_FOR_SHOW)


@cache
def _shapes() -> dict[str, tuple[FloatArray, IntArray]]:
    """Vertices and faces of the package's finger by name."""
    spec = mujoco.MjSpec.from_file(str(models_folder() / "finger" / "shapes.xml"))
    return {mesh.name: (np.array(mesh.uservert), np.array(mesh.userface)) for mesh in spec.meshes}


def _add_object(spec: mujoco.MjSpec, finger: Finger) -> None:
    """A block on a spring k_e, which gives way as the face is pressed; its weight is carried."""
    tilt = 0.5 * (0.5 * np.pi - finger.object_angle)
    inwards = -np.cos(finger.object_angle) * FORWARD - np.sin(finger.object_angle) * UP
    face = finger.object_x * FORWARD + finger.object_z * UP
    body = spec.worldbody.add_body(name="object", pos=face + _OBJECT_SIZE[2] * inwards)
    body.quat = [np.cos(tilt), 0.0, np.sin(tilt), 0.0]
    body.gravcomp = 1.0
    slide = body.add_joint(name="object", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=-UP)
    slide.stiffness[0] = finger.object_stiffness
    slide.damping[0] = 2.0 * np.sqrt(finger.object_stiffness * finger.object_mass)
    body.add_geom(
        name="object",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=_OBJECT_SIZE,
        mass=finger.object_mass,
        rgba=_OBJECT,
        contype=0,
        conaffinity=_PHALANX,
        solref=[4.0 * finger.timestep, 1.0],
    )
    box, rod = mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_CYLINDER
    body.add_geom(type=box, pos=_RAIL, size=[0.003, 0.0065, 0.003], rgba=_STEEL, **_FOR_SHOW)
    ends = [*_RAIL, *(_RAIL - 0.05 * UP)]
    body.add_geom(type=rod, fromto=ends, size=[0.0022, 0.0, 0.0], rgba=_STEEL, **_FOR_SHOW)


def _add_motor(spec: mujoco.MjSpec, finger: Finger, tendon: str) -> None:
    """A spool that winds the tendon in when it turns forward, and its actuators."""
    side, name = SIDE[tendon], f"{tendon}_motor"
    centre = sheath_points(finger, tendon)[0] + side * finger.spool_radius * UP
    body = spec.worldbody.add_body(name=name, pos=centre, explicitinertial=True, mass=0.02)
    body.ipos, body.inertia = np.zeros(3), np.full(3, 1e-6)
    drum, crank = mujoco.mjtGeom.mjGEOM_CYLINDER, mujoco.mjtGeom.mjGEOM_CAPSULE
    width = [*(-0.004 * FLEXION), *(0.004 * FLEXION)]
    arm = [0.0, -0.005, 0.0, 0.0, -0.005, 0.8 * side * finger.spool_radius]
    for kind, radius, ends, rgba in (
        (drum, finger.spool_radius, width, _STEEL),
        (crank, 0.0015, arm, TENDON_COLOUR[tendon]),
    ):
        size = [radius, 0.0, 0.0]
        body.add_geom(type=kind, size=size, fromto=ends, rgba=rgba, contype=0, conaffinity=0)
    hinge = body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=side * FLEXION)
    hinge.armature = finger.rotor_inertia * finger.gear**2
    hinge.damping[0] = finger.motor_damping
    most = finger.motor_torque * finger.gear
    joint = {"trntype": mujoco.mjtTrn.mjTRN_JOINT, "target": name}
    position = spec.add_actuator(name=f"{tendon}_angle", **joint)
    position.set_to_position(kp=finger.servo_stiffness, kv=finger.servo_damping)
    position.biasprm[0] = finger.resting_torque  # so that 0 rad is where the servo rests
    position.forcerange, position.forcelimited = [-most, most], True
    lows, highs = zip(*((joint.low, joint.high) for joint in finger.joints.values()), strict=True)
    angles = [spool_angles(finger, joints)[tendon] for joints in (lows, highs)]
    position.ctrlrange = [min(angles) - finger.servo_margin, max(angles) + finger.servo_margin]
    position.ctrllimited = True
    torque = spec.add_actuator(name=f"{tendon}_torque", **joint)
    torque.set_to_motor()
    torque.gear[0] = finger.gear
    torque.ctrlrange, torque.ctrllimited = [-finger.motor_torque, finger.motor_torque], True


def _add_path(spec: mujoco.MjSpec, finger: Finger, tendon: str) -> None:
    """The tendon over its sites: the sheath's, then one before and one after every joint."""
    names = add_sites(spec, f"{tendon}_sheath", sheath_points(finger, tendon))
    parent, axis = spec.worldbody, 0.0
    for name, joint in finger.joints.items():
        before, after = joint.guides(tendon)
        body = spec.body(name)
        for on, end, pos in ((parent, "before", before + axis * FORWARD), (body, "after", after)):
            on.add_site(name=f"{tendon}_{name}_{end}", pos=pos)
            if on != spec.worldbody:
                _draw_pin(on, pos)
        names += [f"{tendon}_{name}_before", f"{tendon}_{name}_after"]
        parent, axis = body, joint.length
    element = add_tendon(spec, tendon, names)
    element.width, element.rgba = _TENDON_RADIUS, TENDON_COLOUR[tendon]


def _draw_pin(body: mujoco.MjsBody, guide: FloatArray) -> None:
    radius, front, back = _PIN
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        fromto=[*(guide + front * FLEXION), *(guide + back * FLEXION)],
        size=[radius, 0.0, 0.0],
        rgba=_STEEL,
        **_FOR_SHOW,
    )


def _add_finger_sensors(spec: mujoco.MjSpec, tendons: tuple[str, ...]) -> None:
    position, joint = mujoco.mjtSensor.mjSENS_JOINTPOS, mujoco.mjtObj.mjOBJ_JOINT
    motors = [f"{tendon}_motor" for tendon in tendons]
    for name in (*JOINTS, *motors):
        spec.add_sensor(name=f"{name}_angle", type=position, objtype=joint, objname=name)
    touch, site = mujoco.mjtSensor.mjSENS_TOUCH, mujoco.mjtObj.mjOBJ_SITE
    spec.add_sensor(name="tip_force", type=touch, objtype=site, objname="tip")
    spec.add_sensor(name="object_displacement", type=position, objtype=joint, objname="object")
    for tendon in tendons:
        for kind in ("input_tension", "output_tension"):
            add_sensor(spec, f"{tendon}_sheath", kind, f"{tendon}_{kind}")


def _balance_springs(spec: mujoco.MjSpec, finger: Finger) -> None:
    """Let the springs rest where they bear pretension and weight in the reference pose."""
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for name, joint in finger.joints.items():
        dof = int(model.joint(name).dofadr[0])
        torque = float(data.qfrc_passive[dof] - data.qfrc_bias[dof])
        if joint.stiffness > 0.0:
            spec.joint(name).springref = -torque / joint.stiffness
