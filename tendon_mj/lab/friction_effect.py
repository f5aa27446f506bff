"""What friction changes in a motion: the tendons that lose most, and a sentence."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection, Sequence
from fnmatch import fnmatchcase

import mujoco
import numpy as np

from tendon_mj.errors import UnknownNameError
from tendon_mj.lab.frames import POSE, Frames
from tendon_mj.lab.units import ROUNDING, EngineeringUnit, force_unit, plain
from tendon_mj.plugin import sheaths
from tendon_mj.typing import FloatArray

_BEARS = 0.5  # loss of a tendon over its largest, in frames of which the sentence may be
_LEAST = 0.05  # of a difference in place that is written [° or mm]


def sheathed_tendons(model: mujoco.MjModel, pattern: str) -> list[str]:
    """Tendons in sheaths that a name or a pattern with ``*``, ``?`` or ``[…]`` means."""
    known = [sheath.tendon for sheath in sheaths(model).values()]
    chosen = [name for name in known if name == pattern] or [
        name for name in known if fnmatchcase(name, pattern)
    ]
    if not chosen:
        raise UnknownNameError("tendon in a sheath", pattern, known)
    return chosen


def most_first(
    model: mujoco.MjModel, frames: Frames, tendons: Collection[str] | None = None
) -> Frames:
    """Frames whose cables are in the order of the most that friction takes of their tension.

    Those that lose alike are in the order of their tension. ``tendons`` are all that are kept.
    """
    names = sheaths(model)
    kept = {n: c for n, c in frames.cables.items() if tendons is None or names[n].tendon in tendons}

    def size(name: str) -> tuple[float, float]:
        first, last = kept[name].end_tensions.T
        return float(np.abs(first - last).max()), float(np.abs(first).max())

    ordered = sorted(kept, key=size, reverse=True)
    return dataclasses.replace(frames, cables={name: kept[name] for name in ordered})


def friction_sentence(model: mujoco.MjModel, frames: Frames, twin: Frames | None) -> str:
    """What friction takes of a tension, and of the motion of a joint that the tendon crosses.

    It is of a moment at which friction takes more than half of what it takes at most of the tension
    of that tendon, and at which the joint lags farthest behind where it is in the ``twin``, without
    friction. Empty where friction takes nothing.
    """
    losses = {n: np.abs(np.diff(c.end_tensions)[:, 0]) for n, c in frames.cables.items()}
    losses = {name: loss for name, loss in losses.items() if loss.max() > 0.0}
    if not losses:
        return ""
    sheath = next(iter(losses))
    frame, turned, farthest = int(np.argmax(losses[sheath])), "", _LEAST
    joints, verb, unit = _moved_joints(model)
    if twin is not None and len(joints):
        places = model.jnt_qposadr[joints]
        here, free = (unit.factor * f.poses[:, places] for f in (frames, twin))
        less = np.abs(here - here[0]) < np.abs(free - free[0])
        apart = np.abs(here - free) * (less if less.any() else 1.0)
        crossed = _crossed(model, frames, joints)
        for name, loss in losses.items():
            bears = loss >= _BEARS * loss.max()
            shown = apart * crossed[model.tendon(sheaths(model)[name].tendon).id] * bears[:, None]
            k, j = np.unravel_index(np.argmax(shown), shown.shape)
            if shown[k, j] > farthest:
                sheath, frame, farthest = name, int(k), float(shown[k, j])
                size = "less" if less[k, j] else "more"
                turned = (
                    f", and {model.joint(joints[j]).name or f'joint {joints[j]}'} {verb} by"
                    f" {plain(farthest, 2)}{unit.symbol} {size} than without friction (to"
                    f" {_at(here[k, j], unit)}, not {_at(free[k, j], unit)})"
                )
    first, last = frames.cables[sheath].end_tensions[frame].tolist()
    smaller, larger = sorted((first, last), key=abs)
    arrives = max(0.0, math.copysign(1.0, larger) * smaller)
    forces = force_unit([arrives, larger])
    share = plain(forces.factor * arrives) if arrives else "none"
    return (
        f"At {frames.time[frame]:.1f} s, {share} of {plain(forces.factor * abs(larger))}"
        f" {forces.symbol} arrive at the {'output' if abs(first) >= abs(last) else 'input'} of"
        f" {sheaths(model)[sheath].tendon}{turned}."
    )


def _at(place: float, unit: EngineeringUnit) -> str:
    return f"{place:z.1f}{unit.symbol}".replace("-", "−")


def free_joints(model: mujoco.MjModel, kind: mujoco.mjtJoint) -> list[int]:
    """Joints of a kind that no actuator moves directly, or only by a cable that is not drawn."""
    driven = {*model.actuator_trnid[model.actuator_trntype == mujoco.mjtTrn.mjTRN_JOINT.value, 0]}
    for tendon in (model.tendon(sheath.tendon).id for sheath in sheaths(model).values()):
        path = slice(model.tendon_adr[tendon], model.tendon_adr[tendon] + model.tendon_num[tendon])
        driven -= {*model.wrap_objid[path][model.wrap_type[path] == mujoco.mjtWrap.mjWRAP_JOINT]}
    return [int(k) for k in np.flatnonzero(model.jnt_type == kind.value) if k not in driven]


def _moved_joints(model: mujoco.MjModel) -> tuple[list[int], str, EngineeringUnit]:
    """Hinges, or slides if there are none, that no actuator moves; what they do, and a unit."""
    hinges = free_joints(model, mujoco.mjtJoint.mjJNT_HINGE)
    if hinges:
        return hinges, "turns", EngineeringUnit("°", math.degrees(1.0))
    return free_joints(model, mujoco.mjtJoint.mjJNT_SLIDE), "moves", EngineeringUnit(" mm", 1e3)


def _crossed(model: mujoco.MjModel, frames: Frames, joints: Sequence[int]) -> FloatArray:
    """(ntendon, joints) 1 if a joint moves a tendon in a pose, else 0."""
    data, crossed = mujoco.MjData(model), np.zeros((model.ntendon, len(joints)))
    for frame in (0, len(frames.poses) // 2):
        mujoco.mj_setState(model, data, frames.poses[frame], POSE)
        mujoco.mj_fwdPosition(model, data)
        for j, dof in enumerate(model.jnt_dofadr[joints]):
            data.qvel[:] = 0.0
            data.qvel[dof] = 1.0
            mujoco.mj_fwdVelocity(model, data)
            crossed[:, j] += np.abs(data.ten_velocity) > ROUNDING
    return np.asarray(crossed > 0.0, float)
