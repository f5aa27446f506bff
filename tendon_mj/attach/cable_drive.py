"""Cables that are not drawn, between the actuators of a model and the joints that they turn."""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple, SupportsFloat, Unpack

import mujoco

from tendon_mj.attach import instances, tendons
from tendon_mj.attach.attachment import Attached, changing
from tendon_mj.attach.friction import add_sheaths, joint_warnings, listed_reasons
from tendon_mj.attach.keywords import check_names, checked_number, takes
from tendon_mj.attach.mjcf import write_sheaths
from tendon_mj.attach.sheath_design import NewSheath
from tendon_mj.errors import InvalidValueError, TendonWarning, UnsuitedTendonError
from tendon_mj.sheath import LAW, Law, OptionalParameters, doubt_of_unit

_TRN, _JOINT = mujoco.mjtTrn, mujoco.mjtJoint
_ON_JOINT = (_TRN.mjTRN_JOINT, _TRN.mjTRN_JOINTINPARENT)
_LAW = {
    name: LAW[name]
    for name in (
        *("friction", "static_friction", "constant_friction", "pretension"),
        *("stribeck_friction", "stribeck_velocity", "direction_asymmetry"),
        *("friction_gradient", "friction_drift"),
    )
}
_CONFIGURED = {*_LAW, "extra_bend"}


class CableDrive(NamedTuple):
    """A cable between actuators and the joints that they turn."""

    tendon: str  # fixed, whose length its drums turn by
    joint: str  # that it turns, where the tendon has to be added; else empty
    radius: float  # of the drums [m]


@takes(_LAW)
def add_cable_drive(
    spec: mujoco.MjSpec,
    actuator: str | Sequence[str],
    *,
    radius: SupportsFloat,
    bend: SupportsFloat,
    friction: SupportsFloat,
    pretension: SupportsFloat = 0.0,
    sensors: Sequence[str] = ("input_tension", "output_tension"),
    **parameters: Unpack[OptionalParameters],
) -> mujoco.MjSpec:
    """Let actuators turn their joints by cables with friction that the model does not draw.

    Actuators, joints, controls and keyframes stay as they are: friction takes its share of the
    force that arrives at a joint, and holds it at rest. The cable of a joint belongs to a fixed
    tendon ``<joint>_cable`` that is added, and has the force of all actuators on the joint; an
    actuator on a fixed tendon keeps that. Two cables pull, one each way. With a pretension, the
    loss is at least that of both cables under it; without one, the other cable is slack. Nothing
    stretches, so there is no lost motion.

    Args:
        spec: changed in place and returned; not at all if the call is refused.
        actuator: name of an actuator on a hinge, a slide or a fixed tendon, several names, or a
            pattern such as ``*``, which leaves out other actuators; a warning says which.
        radius: of the drum on a joint [m]; for a fixed tendon, of cable per unit of its
            coefficients' sum. Of a slide 1 is taken. It gives tensions their newtons, and has no
            part in the share that is lost.
        bend: whole angle by which the cable turns on its way [rad].
        <parameters>
        sensors: kinds to add, named ``<tendon>_<kind>``. The tension is the difference of both
            cables, and above 0 if it turns the joint towards positive angles.

    Returns:
        ``spec``.

    Raises:
        UnknownNameError: no such actuator, parameter or sensor kind, with the nearest name.
        InvalidValueError: a parameter outside its range; an actuator given by its name that turns
            no joint by a cable, or whose cable is there already; a pattern that means no other.

    Warns:
        TendonWarning: of a friction above 2, of a bend above four turns, of actuators that were
            left out, and of what limits or senses a joint's force behind the cable's back.
    """
    tendons.check_spec(spec)
    check_names(_LAW, parameters, "add_cable_drive")
    instances.check_kinds(sensors)
    drum, turned = checked_number("radius", radius), checked_number("bend", bend)
    for name, value, unit in (("radius", drum, "m"), ("bend", turned, "rad")):
        if not 0.0 < value < float("inf"):
            raise InvalidValueError(f"{name} = {value:g} [{unit}] must be finite and > 0")
    given = {"friction": friction, "pretension": pretension, **parameters}
    values = {k: checked_number(k, v) for k, v in given.items() if v is not None}
    law = dataclasses.asdict(Law(axial_stiffness=1.0, extra_bend=turned, **values))
    drives, left_out = _design_all(spec, actuator, drum)
    config = {k: repr(v) for k, v in law.items() if (v or k == "friction") and k in _CONFIGURED}
    new = []
    for drive in drives:
        element = spec.tendon(drive.tendon) if not drive.joint else _add_cable(spec, drive)
        own = {"guides": "1", "inner_guides": "1", "radius": repr(drive.radius)} | config
        new.append(NewSheath(element, drive.tendon, own, "", "", "", True, None))
    add_sheaths(spec, new, None, None, sensors, alone=False)
    doubts = [doubt_of_unit(name, value) for name, value in values.items()]
    left = [f"left as they are: {listed_reasons(left_out)}"] if left_out else []
    for message in filter(None, [*doubts, *left, *joint_warnings(spec, new), _weightless(new)]):
        warnings.warn(f"add_cable_drive: {message}", TendonWarning, stacklevel=2)
    return spec


def _weightless(sheaths: Sequence[NewSheath]) -> str:
    """Warning of joints whose actuators bear the weight of bodies without a command."""
    joints = [joint for sheath in sheaths for joint in tendons.crossed_joints(sheath.tendon)]
    names = [joint.name for joint in joints if joint.actgravcomp]
    if not names:
        return ""
    return (
        f"actuatorgravcomp of joint {tendons.listed(names)} bears weight there past the cable, "
        "which does not rub under it: turn it off, and let the control bear that"
    )


def attach_cable_drives(
    spec: mujoco.MjSpec, source: Path, actuator: Sequence[str], path: Path, **cable: Any
) -> Attached:
    """Give actuators of a model cables, and write the model as a new file.

    ``spec`` was read from ``source``, and is changed; ``cable`` are options of `add_cable_drive`.
    Raises `TendonError` where it or MuJoCo refuse the model, or the file cannot be written.
    """
    with changing(source, "add_cable_drive") as said:
        add_cable_drive(spec, actuator, **cable)
        write_sheaths(source, spec, path)
    return Attached(path, (), tuple(said), ())


def _design_all(
    spec: mujoco.MjSpec, actuator: str | Sequence[str], radius: float
) -> tuple[list[CableDrive], dict[str, str]]:
    """Cable drives that a call adds; actuators that a pattern leaves out → why."""
    chosen = tendons.choose(list(spec.actuators), actuator, "actuator")
    sheathed = instances.sheaths_by_tendon(spec)
    taken = {tendon.name for tendon in spec.tendons}
    drives: dict[tuple[mujoco.mjtTrn, str], CableDrive] = {}
    left_out: dict[str, str] = {}
    for element, name, by_name in chosen:
        on = element.trntype if element.trntype not in _ON_JOINT else _TRN.mjTRN_JOINT
        if (on, element.target) in drives:
            continue
        try:
            drive = _design(spec, element, radius)
            if drive.tendon in sheathed:
                raise UnsuitedTendonError(
                    f"has a cable already, in sheath {sheathed[drive.tendon].name!r}"
                )
        except UnsuitedTendonError as error:
            if by_name:
                raise InvalidValueError(f"actuator {name!r} {error}") from None
            left_out[name] = str(error)
            continue
        if drive.joint:
            drive = drive._replace(tendon=instances.take_name(taken, drive.tendon))
        drives[on, element.target] = drive
    if not drives:
        raise InvalidValueError(
            f"none of the actuators matching {tendons.listed(actuator)} can have a cable drive:"
            f" {listed_reasons(left_out)}"
        )
    return list(drives.values()), left_out


def _design(spec: mujoco.MjSpec, actuator: mujoco.MjsActuator, radius: float) -> CableDrive:
    """The drive of an actuator, on the tendon that its joint has or will have."""
    if actuator.trntype == _TRN.mjTRN_TENDON:
        tendon = spec.tendon(actuator.target)
        if tendons.path_of(tendon).is_spatial:
            raise UnsuitedTendonError(
                f"pulls tendon {tendon.name!r}, which is drawn: give that friction by add_friction"
            )
        return CableDrive(tendon.name, "", radius)
    if actuator.trntype not in _ON_JOINT:
        raise UnsuitedTendonError("acts on neither a joint nor a tendon, so no cable turns a drum")
    joint = spec.joint(actuator.target)
    if joint.type not in (_JOINT.mjJNT_HINGE, _JOINT.mjJNT_SLIDE):
        raise UnsuitedTendonError(
            f"acts on joint {joint.name!r}, which is no hinge or slide, so that no drum turns it"
        )
    own = 1.0 if joint.type == _JOINT.mjJNT_SLIDE else radius
    for tendon in instances.sheaths_by_tendon(spec):
        points = list(spec.tendon(tendon).path)
        if len(points) == 1 and points[0].target.name == joint.name:
            return CableDrive(tendon, "", own)
    return CableDrive(f"{joint.name}_cable", joint.name, own)


def _add_cable(spec: mujoco.MjSpec, drive: CableDrive) -> mujoco.MjsTendon:
    """Add the fixed tendon of a joint; nothing of it follows from the model's defaults."""
    tendon = spec.add_tendon(name=drive.tendon)
    tendon.wrap_joint(drive.joint, 1.0)
    tendon.limited = tendon.actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE
    tendon.frictionloss = tendon.armature = 0.0
    tendon.stiffness, tendon.damping = [0.0] * 3, [0.0] * 3
    return tendon
