"""Motors with joints of their own, which turn the joints of a model by two elastic cables.

A motor has the coordinate of the joint that it turns, and its actuators. Each cable is a tendon of
the length L over n guides in a row, which the motor winds in at one end and the joint pays out at
the other, or the reverse. It loses along its way what a sheath loses there. With equal guides the
lost motion ξ_B is too large by λ²/12n² (e^λ − 1)/(e^λ − λ − 1) of itself, from which n follows.
"""

from __future__ import annotations

import math
from collections.abc import Container, Sequence
from typing import NamedTuple

import mujoco

from tendon_mj.attach.instances import instances, note_of, take_name
from tendon_mj.attach.keyframes import (
    insert_joints,
    keyframes,
    restore_keyframes,
    without_joints,
)
from tendon_mj.attach.spool import INERTIA, MASS, check_alone, let_turn_freely
from tendon_mj.attach.tendons import listed, only_joint
from tendon_mj.errors import InvalidValueError
from tendon_mj.plugin import UNDRAWN
from tendon_mj.sheath import Law

_LOST_MOTION = 0.01  # relative error of ξ_B from which the number of guides follows
# Custom text ``<cable>.tendon_mj_motor``: armature of the joint, and damping of each of its
# actuators, before they were moved. `attach` gives it the affixes.
_NOTE = ".tendon_mj_motor"
ON_JOINT = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
_OFF = mujoco.mjtLimited.mjLIMITED_FALSE


class Motor(NamedTuple):
    """A motor that can be added."""

    joint: str  # that it turns
    radius: float  # of both drums [m]
    length: float  # of the cables [m]
    armature: float  # [kg m²]
    law: Law  # of each cable
    damping: float  # [N m s/rad]


# A tendon, and the attributes of its sheath that attach it to motor and joint
Cable = tuple[mujoco.MjsTendon, dict[str, str]]


def add_motors(spec: mujoco.MjSpec, motors: Sequence[Motor]) -> list[Cable]:
    """Add motors behind all bodies, and move the actuators of their joints to them."""
    model, before = spec.compile(), keyframes(spec)
    taken = {e.name for kind in (spec.bodies, spec.joints, spec.tendons) for e in kind}
    sites = {site.name for site in spec.sites}
    angles: dict[str, list[float]] = {}
    speeds: dict[str, list[float]] = {}
    cables: list[Cable] = []
    for motor in motors:
        name = take_name(taken, f"{motor.joint}_motor")
        joint = model.joint(motor.joint)
        at, dof = int(joint.qposadr[0]), int(joint.dofadr[0])
        angles[name] = [key.qpos[at] if key.qpos else 0.0 for key in before]
        speeds[name] = [key.qvel[dof] if key.qvel else 0.0 for key in before]
        added, own = _add(spec, motor, name, taken, sites)
        # which actuators may inherit; in radians, as that of a joint without limits is left
        added.range = joint.range
        note = _move_actuators(spec, motor, name, model)
        spec.add_text(name=f"{own[0][0].name}{_NOTE}", data=note)
        cables += own
    insert_joints(spec, before, angles, speeds)
    return cables


def _add(
    spec: mujoco.MjSpec, motor: Motor, name: str, taken: set[str], sites: set[str]
) -> tuple[mujoco.MjsJoint, list[Cable]]:
    """Add a motor's joint and its two cables; nothing of them follows from the model's defaults."""
    turned = spec.joint(motor.joint)
    body = spec.worldbody.add_body(name=name, explicitinertial=True, mass=MASS)
    body.ipos, body.inertia = [0.0, 0.0, 0.0], [INERTIA] * 3
    joint = body.add_joint(name=name, type=turned.type, axis=turned.axis)
    let_turn_freely(joint)
    joint.ref, joint.armature = turned.ref, motor.armature
    joint.damping = [motor.damping, 0.0, 0.0]
    joint.actfrclimited, joint.actfrcrange = turned.actfrclimited, turned.actfrcrange
    guides = _guides(motor.law.friction * motor.law.extra_bend)
    along = [0.0, *((k + 0.5) / guides for k in range(guides)), 1.0]
    path = []
    for k, share in enumerate(along):
        path.append(take_name(sites, f"{name}_{k}"))
        body.add_site(name=path[-1], pos=[share * motor.length, 0.0, 0.0], group=UNDRAWN)
    names = [take_name(taken, f"{motor.joint}_cable{way}") for way in ("", "_back")]
    drums = {"reel_joint": name, "output_joint": motor.joint, "guides": str(guides)}
    cables = []
    for cable, radius in zip(names, (motor.radius, -motor.radius), strict=True):
        radii = {"reel_radius": repr(radius), "output_radius": repr(-radius)}
        cables.append((_add_cable(spec, cable, path), drums | radii))
    return joint, cables


def _guides(exponent: float) -> int:
    """Number of guides that make an error of ``_LOST_MOTION`` in ξ_B at most."""
    if exponent == 0.0:
        return 1
    share = -math.expm1(-exponent)  # times e^λ, as are the others
    excess = share / (share - exponent * math.exp(-exponent))
    return math.ceil(exponent * math.sqrt(excess / (12.0 * _LOST_MOTION)))


def _add_cable(spec: mujoco.MjSpec, name: str, path: Sequence[str]) -> mujoco.MjsTendon:
    tendon = spec.add_tendon(name=name, group=UNDRAWN)
    for site in path:
        tendon.wrap_site(site)
    switch_off(tendon)
    return tendon


def switch_off(tendon: mujoco.MjsTendon) -> None:
    """Let no force along a tendon follow from the model's defaults."""
    tendon.limited = tendon.actfrclimited = _OFF
    tendon.frictionloss = tendon.armature = 0.0
    tendon.stiffness, tendon.damping = [0.0] * 3, [0.0] * 3


def actuators_on(spec: mujoco.MjSpec, joint: str) -> list[mujoco.MjsActuator]:
    """Actuators that act on a joint."""
    return [a for a in spec.actuators if a.trntype in ON_JOINT and a.target == joint]


def _move_actuators(spec: mujoco.MjSpec, motor: Motor, name: str, model: mujoco.MjModel) -> str:
    """Let the actuators of a joint turn its motor, and return what `_NOTE` has to hold.

    A damping ratio is that of the inertia at the joint, as MuJoCo computed it.
    """
    joint = spec.joint(motor.joint)
    note = [float(joint.armature)]
    joint.armature = max(0.0, joint.armature - motor.armature)
    for actuator in actuators_on(spec, motor.joint):
        actuator.target = name
        note.append(float(actuator.biasprm[2]))
        actuator.biasprm[2] = model.actuator_biasprm[actuator.id, 2]
        if actuator.gaintype == mujoco.mjtGain.mjGAIN_MUSCLE:  # a motor has no limits to find it by
            actuator.lengthrange = model.actuator_lengthrange[actuator.id]
    return " ".join(map(repr, note))


class Added(NamedTuple):
    """A motor that `add_motors` added."""

    note: mujoco.MjsText
    joint: mujoco.MjsJoint
    turns: str  # joint
    cables: list[str]  # spatial tendons
    actuators: list[mujoco.MjsActuator]


def added_motors(spec: mujoco.MjSpec, removed: Container[str]) -> list[Added]:
    """Motors whose cables are among tendons that are to lose their sheaths.

    One is refused that would keep a cable, or on which more hangs than was added with it.
    """
    motors, configs = [], [c for _, c in instances(spec) if "sensor" not in c]
    for config in configs:
        cable, name = config.get("tendon", ""), config.get("reel_joint", "")
        note = note_of(spec, cable, _NOTE)
        cables = [c["tendon"] for c in configs if name and c.get("reel_joint") == name]
        gears = [t.name for t in spec.tendons if name and only_joint(t) == name]
        if note is None or not any(one in removed for one in cables + gears):
            continue
        if not all(one in removed for one in cables + gears):
            raise InvalidValueError(f"{listed(cables + gears)} are of one motor: name all")
        moved, joint = actuators_on(spec, name), spec.joint(name)
        same = len(moved) == len(note.data.split()) - 1
        check_alone(spec, cable, joint, same_motors=same, sites=len(spec.tendon(cable).path))
        motors.append(Added(note, joint, config["output_joint"], cables, moved))
    return motors


def remove_motors(spec: mujoco.MjSpec, motors: Sequence[Added]) -> None:
    """Delete motors without sheaths, and let their actuators turn their joints as before."""
    if not motors:
        return
    keys = without_joints(spec, [motor.joint.name for motor in motors])
    for motor in motors:
        armature, *damping = map(float, motor.note.data.split())
        joint = spec.joint(motor.turns)
        joint.armature, joint.damping = armature, joint.damping + motor.joint.damping
        for actuator, own in zip(motor.actuators, damping, strict=True):
            actuator.target, actuator.biasprm[2] = motor.turns, own
        for element in (*map(spec.tendon, motor.cables), motor.note, motor.joint.parent):
            spec.delete(element)
    if keys:
        restore_keyframes(spec, keys)
