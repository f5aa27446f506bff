"""Adds spools to a model, moves the motors to them, and keeps what they were."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import mujoco

from tendon_mj.attach.names import free_name
from tendon_mj.attach.spool.design import SpoolDesign
from tendon_mj.attach.spool.keyframes import insert_joints, keyframes
from tendon_mj.attach.spool.motor import drive_of, set_drive
from tendon_mj.attach.spool.note import keep_drives

_HALF_WIDTH = 0.004  # of a drum, as drawn [m]
_MASS, _INERTIA = 1e-6, 1e-12  # of its body, which is all armature [kg], [kg m²]
_STEEL = [0.45, 0.47, 0.5, 1.0]


def spool_names(spec: mujoco.MjSpec, tendons: Iterable[str]) -> dict[str, str]:
    """Tendon → a free name for the body, the joint and the drum of its spool."""
    taken = {e.name for kind in (spec.bodies, spec.joints, spec.geoms) for e in kind}
    names = {}
    for tendon in tendons:
        names[tendon] = free_name(taken, f"{tendon}_spool")
        taken.add(names[tendon])
    return names


def add_spools(spec: mujoco.MjSpec, designs: Mapping[str, SpoolDesign]) -> None:
    """Add spools, by the name of each, and move the motors of their tendons to them."""
    if not designs:
        return
    before = keyframes(spec)
    for name, design in designs.items():
        _add_drum(name, design)
        keep_drives(spec, design.tendon, [drive_of(motor) for motor, _ in design.motors])
        for motor, drive in design.motors:
            set_drive(motor, drive, mujoco.mjtTrn.mjTRN_JOINT, name)
    insert_joints(spec, before, {name: design.angles for name, design in designs.items()})


def _add_drum(name: str, design: SpoolDesign) -> None:
    """A drum without weight on a hinge; nothing of it follows from the model's defaults."""
    body = design.body.add_body(name=name, pos=design.pos, explicitinertial=True, mass=_MASS)
    body.ipos, body.inertia = [0.0, 0.0, 0.0], [_INERTIA] * 3
    ends = [*(-_HALF_WIDTH * design.axis), *(_HALF_WIDTH * design.axis)]
    body.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[design.radius, 0.0, 0.0],
        fromto=ends,
        mass=_MASS,
        rgba=_STEEL,
        material="",
        contype=0,
        conaffinity=0,
    )
    joint = body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=design.axis)
    joint.pos, joint.ref, joint.springref = [0.0, 0.0, 0.0], 0.0, 0.0
    joint.limited = joint.actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE
    joint.stiffness, joint.springdamper = [0.0] * 3, [0.0, 0.0]
    joint.armature, joint.damping = design.armature, [design.damping, 0.0, 0.0]
    joint.frictionloss, joint.actgravcomp = 0.0, False
