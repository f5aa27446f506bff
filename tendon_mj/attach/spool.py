"""A spool at the input of a tendon, turned by the motor that pulled the tendon before.

A tendon's actuator of gear g applies the force g F along the tendon, which pulls where it is
negative. On the hinge of a spool of radius r, positive where it winds in, the gear

    g_h = −g r

lets the same F turn the spool by the torque r T, with T = −g F. The actuator's velocity stays the
same for a tendon that does not stretch, and its length, g_h θ in the place of g L, is shorter by
the constant g L₀, with L₀ the tendon's length at `qpos0`. A force that is affine in it,
F = (g₀ + g₁ ℓ + g₂ v) u + b₀ + b₁ ℓ + b₂ v, stays the same with g₀ + g₁ g L₀ and b₀ + b₁ g L₀.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import NamedTuple

import mujoco
import numpy as np

from tendon_mj.attach.instances import note_of, take_name
from tendon_mj.attach.keyframes import Keyframe, insert_joints, keyframes, without_joints
from tendon_mj.attach.tendon_bend import place_tendons
from tendon_mj.attach.tendons import has_own_spring
from tendon_mj.errors import InvalidValueError, UnsuitedTendonError
from tendon_mj.typing import FloatArray

_GAIN, _BIAS, _DYN = mujoco.mjtGain, mujoco.mjtBias, mujoco.mjtDyn
_TRN, _OBJ = mujoco.mjtTrn, mujoco.mjtObj
_GAINS = (_GAIN.mjGAIN_FIXED, _GAIN.mjGAIN_AFFINE)
_BIASES = (_BIAS.mjBIAS_NONE, _BIAS.mjBIAS_AFFINE)
_DYNAMICS = (_DYN.mjDYN_NONE, _DYN.mjDYN_INTEGRATOR, _DYN.mjDYN_FILTER, _DYN.mjDYN_FILTEREXACT)
# J over r² h² EA/ℓ: by default, and above which a step is stable; from 1 on it does not ring
_WELL_RESOLVED, _STABLE = 4.0, 0.25
_HALF_WIDTH = 0.004  # of a drum, as drawn [m]
MASS, INERTIA = 1e-6, 1e-12  # of its body, which is all armature [kg], [kg m²]
_STEEL = [0.45, 0.47, 0.5, 1.0]
# Custom text ``<tendon>.tendon_mj_spool``, which holds the `_Settings` of each motor on its tendon.
# Copies of a spec and MJCF files keep it digit for digit, and `attach` gives it the affixes.
_NOTE = ".tendon_mj_spool"


@dataclass(frozen=True, kw_only=True)
class Spool:
    """A drum on a hinge, which winds a tendon in as it turns forward.

    Attributes:
        radius: r, of the drum [m].
        armature: J, inertia of drum, rotor and gear about the hinge [kg m²]; by default
            4 r² h² EA/ℓ with h the time step and ℓ the length of the straight span at the input
            end, four times the least with which the spool does not ring on it.
        damping: of the hinge [N m s/rad].

    Raises:
        InvalidValueError: a number that is not finite, or outside its range.
    """

    radius: float
    armature: float | None = None
    damping: float = 0.0

    def __post_init__(self) -> None:
        for name, value, unit, may_be_0 in (
            ("radius", self.radius, "m", False),
            ("armature", 1.0 if self.armature is None else self.armature, "kg m²", False),
            ("damping", self.damping, "N m s/rad", True),
        ):
            if not (math.isfinite(value) and (value > 0.0 or (may_be_0 and value == 0.0))):
                bound = "≥" if may_be_0 else ">"
                raise InvalidValueError(
                    f"Spool: {name} = {value} [{unit}] must be finite and {bound} 0"
                )


class _Settings(NamedTuple):
    """Settings of an actuator."""

    gear: float  # g
    gain: float  # g₀
    bias: float  # b₀
    velocity_bias: float  # b₂, or a damping ratio where it is positive
    inheritrange: float
    low: float  # end of ``ctrlrange``
    high: float


class SpoolDesign(NamedTuple):
    """A spool that can be added."""

    tendon: str
    body: mujoco.MjsBody  # of the site at the input end, which carries it
    pos: FloatArray  # of its hinge, in the frame of that body [m]
    axis: FloatArray
    radius: float  # [m]
    armature: float  # [kg m²]
    damping: float  # [N m s/rad]
    motors: list[tuple[mujoco.MjsActuator, _Settings]]  # that turn it, and their settings
    angles: list[float]  # in the model's keyframes [rad]
    warning: str  # where the step does not follow its inertia; else empty


def design_spool(
    spec: mujoco.MjSpec,
    tendon: mujoco.MjsTendon,
    name: str,
    spool: Spool | None,
    at_last: bool,
    config: Mapping[str, str],
    motors: Sequence[mujoco.MjsActuator],
    compiled: Callable[[], mujoco.MjModel],
) -> SpoolDesign | None:
    """The spool that takes over the actuators of a tendon; ``config`` has EA and T_0."""
    if spool is None:
        return None
    if not motors:
        raise UnsuitedTendonError(
            f"tendon {name!r} has no actuator to turn a spool: leave spool out, and give reel, or "
            "a reel_joint of the model's own"
        )
    for motor in motors:
        _check_movable(motor, name)
    if has_own_spring(tendon):
        raise UnsuitedTendonError(
            f"tendon {name!r} has its own spring, which pulls next to its actuators and cannot "
            "behind a spool: set its stiffness to 0, or leave spool out"
        )
    model = compiled()
    data = mujoco.MjData(model)
    place_tendons(model, data)
    axial_stiffness, step = float(config["axial_stiffness"]), float(model.opt.timestep)
    start, count = int(data.ten_wrapadr[tendon.id]), int(data.ten_wrapnum[tendon.id])
    points = data.wrap_xpos.reshape(-1, 3)[start : start + count]
    first, second = (-1, -2) if at_last else (0, 1)
    span = points[second] - points[first]
    length = max(float(np.linalg.norm(span)), 1e-3)  # two sites on one spot
    unit = spool.radius**2 * step**2 * (axial_stiffness / length)
    armature = _WELL_RESOLVED * unit if spool.armature is None else spool.armature
    least = _STABLE * unit
    element = model.tendon_num[tendon.id] - 1 if at_last else 0
    site = int(model.wrap_objid[model.tendon_adr[tendon.id] + element])
    turn = data.xmat[model.site_bodyid[site]].reshape(3, 3)
    along = turn.T @ (span / np.linalg.norm(span) if span.any() else np.array([1.0, 0.0, 0.0]))
    across = np.cross(along, np.eye(3)[np.argmin(np.abs(along))])
    across /= np.linalg.norm(across)
    angles = []  # at which the tendon is as tight as at `qpos0`
    for key in range(model.nkey):
        mujoco.mj_resetDataKeyframe(model, data, key)
        place_tendons(model, data)
        shorter = float(model.tendon_length0[tendon.id] - data.ten_length[tendon.id])
        angles.append(shorter / spool.radius)
    warning = ""
    if armature < least:
        warning = (
            f"the step of {step:g} s does not follow the spool of {name!r} on its tendon: give it "
            f"an armature of {least:.3g} kg m² at least, or take a smaller "
            "axial_stiffness or step"
        )
    return SpoolDesign(
        tendon=name,
        body=next(s for s in spec.sites if s.id == site).parent,
        pos=model.site_pos[site] + spool.radius * across,
        axis=np.cross(across, along),
        radius=spool.radius,
        armature=armature,
        damping=spool.damping,
        motors=[(motor, _on_spool(motor, model, spool.radius)) for motor in motors],
        angles=angles,
        warning=warning,
    )


def _check_movable(actuator: mujoco.MjsActuator, tendon: str) -> None:
    """Refuse an actuator whose force would not be the same on a spool."""
    reason = ""
    if actuator.plugin.active:
        plugin = actuator.plugin.plugin_name or actuator.plugin.name
        reason = f"is computed by the plugin {plugin!r}"
    elif _DYN.mjDYN_MUSCLE == actuator.dyntype or _GAIN.mjGAIN_MUSCLE == actuator.gaintype:
        reason = "is a muscle, which pulls by its own length and turns no spool"
    for kind, value, known in (
        ("gain", actuator.gaintype, _GAINS),
        ("bias", actuator.biastype, _BIASES),
        ("dynamics", actuator.dyntype, _DYNAMICS),
    ):
        if value not in known:
            reason = reason or (
                f"has the {kind} {value.name}, which may depend on the tendon's length"
            )
    if reason:
        raise UnsuitedTendonError(
            f"tendon {tendon!r} is pulled by actuator {actuator.name!r}, which {reason}: leave "
            "spool out, and its force is the input tension"
        )


def _drive_of(actuator: mujoco.MjsActuator) -> _Settings:
    return _Settings(
        float(actuator.gear[0]),
        float(actuator.gainprm[0]),
        float(actuator.biasprm[0]),
        float(actuator.biasprm[2]),
        float(actuator.inheritrange),
        *map(float, actuator.ctrlrange),
    )


def _set_drive(
    actuator: mujoco.MjsActuator, drive: _Settings, transmission: mujoco.mjtTrn, target: str
) -> None:
    """Let an actuator act on a tendon or a joint."""
    actuator.trntype, actuator.target = transmission, target
    actuator.gear[0], actuator.gainprm[0], actuator.biasprm[0] = drive[:3]
    actuator.biasprm[2], actuator.inheritrange = drive.velocity_bias, drive.inheritrange
    actuator.ctrlrange[:] = drive.low, drive.high


def _on_spool(actuator: mujoco.MjsActuator, model: mujoco.MjModel, radius: float) -> _Settings:
    """Settings of a tendon's actuator on the hinge of a spool; ``model`` is compiled with it."""
    now, k = _drive_of(actuator), actuator.id
    offset = now.gear * float(model.tendon_length0[model.actuator_trnid[k, 0]])
    affine = actuator.gaintype == _GAIN.mjGAIN_AFFINE
    biased = actuator.biastype == _BIAS.mjBIAS_AFFINE
    return _Settings(
        gear=-now.gear * radius,
        gain=now.gain + (float(actuator.gainprm[1]) * offset if affine else 0.0),
        bias=now.bias + (float(actuator.biasprm[1]) * offset if biased else 0.0),
        # a damping ratio is that of the inertia on the tendon, as MuJoCo computed it
        velocity_bias=float(model.actuator_biasprm[k, 2]),
        inheritrange=0.0,
        low=float(model.actuator_ctrlrange[k, 0]),
        high=float(model.actuator_ctrlrange[k, 1]),
    )


def add_spools(spec: mujoco.MjSpec, designs: Sequence[SpoolDesign]) -> dict[str, str]:
    """Add spools, move the motors of their tendons to them, and keep their settings in a note.

    Returns tendon → the free name that body, joint and drum of its spool are given.
    """
    if not designs:
        return {}
    taken = {e.name for kind in (spec.bodies, spec.joints, spec.geoms) for e in kind}
    names: dict[str, str] = {}
    before, angles = keyframes(spec), {}
    for design in designs:
        name = take_name(taken, f"{design.tendon}_spool")
        names[design.tendon], angles[name] = name, design.angles
        _add_drum(name, design)
        _forget_drives(spec, design.tendon)
        drives = [_drive_of(motor) for motor, _ in design.motors]
        spec.add_text(name=f"{design.tendon}{_NOTE}", data=" ".join(map(repr, chain(*drives))))
        for motor, drive in design.motors:
            _set_drive(motor, drive, _TRN.mjTRN_JOINT, name)
    insert_joints(spec, before, angles)
    return names


def _add_drum(name: str, design: SpoolDesign) -> None:
    """A drum without weight on a hinge; nothing of it follows from the model's defaults."""
    body = design.body.add_body(name=name, pos=design.pos, explicitinertial=True, mass=MASS)
    body.ipos, body.inertia = [0.0, 0.0, 0.0], [INERTIA] * 3
    body.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[design.radius, 0.0, 0.0],
        fromto=[*(-_HALF_WIDTH * design.axis), *(_HALF_WIDTH * design.axis)],
        mass=MASS,
        rgba=_STEEL,
        material="",
        contype=0,
        conaffinity=0,
    )
    joint = body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=design.axis)
    let_turn_freely(joint)
    joint.armature, joint.damping = design.armature, [design.damping, 0.0, 0.0]


def let_turn_freely(joint: mujoco.MjsJoint) -> None:
    """Let nothing that holds a joint follow from the model's defaults."""
    joint.pos, joint.ref, joint.springref, joint.margin = [0.0, 0.0, 0.0], 0.0, 0.0, 0.0
    joint.limited = joint.actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE
    joint.stiffness, joint.springdamper, joint.damping = [0.0] * 3, [0.0, 0.0], [0.0] * 3
    joint.armature, joint.frictionloss, joint.actgravcomp = 0.0, 0.0, False


def remove_spools(spec: mujoco.MjSpec, reel_joints: Mapping[str, str]) -> list[Keyframe]:
    """Delete spools that `add_friction` added, and let their motors pull their tendons as before.

    ``reel_joints``: tendon → joint that winds it in. A spool on which more hangs than was added
    with it is refused, and none is deleted. Returns the keyframes without the spools, for
    `restore_keyframes`.
    """
    spools = []
    for tendon, name in reel_joints.items():
        drives = kept_drives(spec, tendon)
        joint = spec.joint(name) if drives else None
        if joint is None:
            continue
        motors = [a for a in spec.actuators if a.trntype == _TRN.mjTRN_JOINT and a.target == name]
        check_alone(spec, tendon, joint, same_motors=len(motors) == len(drives))
        spools.append((tendon, joint, list(zip(motors, drives, strict=True))))
    if not spools:
        return []
    keys = without_joints(spec, [joint.name for _, joint, _ in spools])
    for tendon, joint, moved in spools:
        for motor, drive in moved:
            _set_drive(motor, drive, _TRN.mjTRN_TENDON, tendon)
        spec.delete(joint.parent)
        _forget_drives(spec, tendon)
    return keys


def check_alone(
    spec: mujoco.MjSpec, tendon: str, joint: mujoco.MjsJoint, *, same_motors: bool, sites: int = 0
) -> None:
    """Refuse to take away a spool that more refers to than was added with it."""
    body, name = joint.parent, joint.name
    problem = "" if same_motors else "other actuators than those of its tendon turn it"
    if len(list(body.bodies)) or len(list(body.sites)) != sites or len(list(body.geoms)) > 1:
        problem = f"its body {body.name!r} carries elements that were added to it"
    own = {_OBJ.mjOBJ_JOINT: {name}, _OBJ.mjOBJ_GEOM: {g.name for g in body.geoms}}
    own[_OBJ.mjOBJ_BODY] = own[_OBJ.mjOBJ_XBODY] = {body.name}
    for sensor in spec.sensors:
        if sensor.objname in own.get(sensor.objtype, ()) or (
            sensor.refname in own.get(sensor.reftype, ())
        ):
            problem = f"sensor {sensor.name!r} shows it"
    for equality in spec.equalities:
        if name in (equality.name1, equality.name2) and (equality.type == mujoco.mjtEq.mjEQ_JOINT):
            problem = f"equality {equality.name!r} constrains it"
    if problem:
        raise InvalidValueError(
            f"the spool {name!r} of tendon {tendon!r} cannot be taken away: {problem}"
        )


def kept_drives(spec: mujoco.MjSpec, tendon: str) -> list[_Settings]:
    """Settings of a tendon's motors before they turned its spool; none without a note of them."""
    note = note_of(spec, tendon, _NOTE)
    numbers = [] if note is None else list(map(float, note.data.split()))
    width = len(_Settings._fields)
    return [_Settings(*numbers[k : k + width]) for k in range(0, len(numbers), width)]


def _forget_drives(spec: mujoco.MjSpec, tendon: str) -> None:
    note = note_of(spec, tendon, _NOTE)
    if note is not None:
        spec.delete(note)
