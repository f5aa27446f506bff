"""Takes spools off tendons, and gives the tendons their motors back."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import NamedTuple

import mujoco

from tendon_mj.attach.spool.keyframes import without_joints, write_keyframes
from tendon_mj.attach.spool.motor import Drive, set_drive
from tendon_mj.attach.spool.note import forget_drives, kept_drives
from tendon_mj.errors import InvalidValueError

_TRN, _OBJ = mujoco.mjtTrn, mujoco.mjtObj


class SpoolOnTendon(NamedTuple):
    """A spool that `add_friction` added.

    Attributes:
        joint: its hinge.
        motors: that turn it, and what they were on the tendon.
    """

    joint: mujoco.MjsJoint
    motors: list[tuple[mujoco.MjsActuator, Drive]]


def spools_by_tendon(
    spec: mujoco.MjSpec, reel_joints: Mapping[str, str]
) -> dict[str, SpoolOnTendon]:
    """Tendon → the spool that it has with its sheath.

    Args:
        spec: read, not changed.
        reel_joints: tendon → name of the joint that winds it in.

    Raises:
        InvalidValueError: more hangs on such a spool than was added with it.
    """
    found = {}
    for tendon, name in reel_joints.items():
        drives = kept_drives(spec, tendon)
        joint = spec.joint(name) if drives else None
        if joint is None:
            continue
        motors = [a for a in spec.actuators if a.trntype == _TRN.mjTRN_JOINT and a.target == name]
        _check_alone(spec, tendon, joint, len(motors) == len(drives))
        found[tendon] = SpoolOnTendon(joint, list(zip(motors, drives, strict=True)))
    return found


def _check_alone(
    spec: mujoco.MjSpec, tendon: str, joint: mujoco.MjsJoint, same_motors: bool
) -> None:
    """Refuse to take away a spool that more refers to than was added with it."""
    body, name = joint.parent, joint.name
    problem = "" if same_motors else "other actuators than those of its tendon turn it"
    if len(list(body.bodies)) or len(list(body.sites)) or len(list(body.geoms)) > 1:
        problem = f"its body {body.name!r} carries what was added to it since"
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


def remove_spools(spec: mujoco.MjSpec, spools: Mapping[str, SpoolOnTendon]) -> None:
    """Delete spools, and let their motors pull their tendons as before."""
    if not spools:
        return
    keys = without_joints(spec, _names(spools))
    for tendon, spool in spools.items():
        for motor, drive in spool.motors:
            set_drive(motor, drive, _TRN.mjTRN_TENDON, tendon)
        spec.delete(spool.joint.parent)
        forget_drives(spec, tendon)
    write_keyframes(spec, keys)


def _names(spools: Mapping[str, SpoolOnTendon]) -> Collection[str]:
    return [spool.joint.name for spool in spools.values()]
