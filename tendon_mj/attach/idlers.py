"""Idlers: cylinders on a bearing that turn with the tendon that runs over them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import mujoco
import numpy as np

_CYLINDER = mujoco.mjtWrap.mjWRAP_CYLINDER.value
_SITE, _JOINT = mujoco.mjtWrap.mjWRAP_SITE.value, mujoco.mjtWrap.mjWRAP_JOINT.value
_PULLEY = mujoco.mjtWrap.mjWRAP_PULLEY.value
_HINGE = mujoco.mjtJoint.mjJNT_HINGE.value
_COUPLING = mujoco.mjtEq.mjEQ_JOINT.value
_ON_JOINT = (mujoco.mjtTrn.mjTRN_JOINT.value, mujoco.mjtTrn.mjTRN_JOINTINPARENT.value)
_COAXIAL = 1e-3  # of the radius, by which an axis may miss another; [rad] by which it may tilt


class Idler(NamedTuple):
    """A cylinder that turns with a tendon, so that the tendon does not slip over it.

    Attributes:
        tendon, geom, joint: ids of the tendon, the cylinder and the hinge on its axis.
        side_site: id of a side site that turns with the cylinder, and so leaves the side of the
            tendon; −1 without one.
    """

    tendon: int
    geom: int
    joint: int
    side_site: int


def idlers(model: mujoco.MjModel) -> list[Idler]:
    """Cylinders that turn freely with the one tendon that runs over them.

    A hinge on the cylinder's axis carries it, and carries neither another point of a tendon's path
    nor anything that holds it: a range, a spring, an actuator, a coupling. Without friction nothing
    turns such a hinge; friction turns it until only the bearing's torque is left to overcome.
    """
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    bodies = {k: _body(model, k) for k in range(model.nwrap)}
    held = _held_joints(model)
    rolling = []
    for tendon in range(model.ntendon):
        first, count = int(model.tendon_adr[tendon]), int(model.tendon_num[tendon])
        for k in range(first, first + count):
            if model.wrap_type[k] != _CYLINDER:
                continue
            geom, side = int(model.wrap_objid[k]), int(model.wrap_prm[k])
            radius, axis = model.geom_size[geom, 0], data.geom_xmat[geom].reshape(3, 3)[:, 2]
            for body in _chain(model, bodies[k]):
                if any(_carries(model, body, bodies[j]) for j in bodies if j != k):
                    break
                for joint in _joints(model, body):
                    hinge, anchor = data.xaxis[joint], data.xanchor[joint]
                    misses = np.linalg.norm(np.cross(data.geom_xpos[geom] - anchor, hinge))
                    tilt = np.linalg.norm(np.cross(axis, hinge))
                    is_hinge = model.jnt_type[joint] == _HINGE and joint not in held
                    if not is_hinge or misses > _COAXIAL * radius or tilt > _COAXIAL:
                        continue
                    turns = side >= 0 and _carries(model, body, int(model.site_bodyid[side]))
                    if turns:
                        arm = np.linalg.norm(np.cross(data.site_xpos[side] - anchor, hinge))
                        turns = bool(arm > _COAXIAL * radius)
                    rolling.append(Idler(tendon, geom, joint, side if turns else -1))
    return rolling


def _held_joints(model: mujoco.MjModel) -> set[int]:
    """Joints with a range, a spring, an actuator, a coupling or a fixed tendon."""
    on_joint = np.isin(model.actuator_trntype, _ON_JOINT)
    couplings = model.eq_type == _COUPLING
    return {
        *map(int, np.flatnonzero((model.jnt_limited != 0) | (model.jnt_stiffness != 0.0))),
        *map(int, model.actuator_trnid[on_joint, 0]),
        *map(int, model.eq_obj1id[couplings]),
        *map(int, model.eq_obj2id[couplings]),
        *map(int, model.wrap_objid[model.wrap_type == _JOINT]),
    }


def _body(model: mujoco.MjModel, element: int) -> int:
    """Body of an element of a tendon's path; the world for one that has none."""
    kind, target = model.wrap_type[element], int(model.wrap_objid[element])
    if kind in (_JOINT, _PULLEY):
        return 0
    return int(model.site_bodyid[target] if kind == _SITE else model.geom_bodyid[target])


def _joints(model: mujoco.MjModel, body: int) -> range:
    first = int(model.body_jntadr[body])
    return range(first, first + int(model.body_jntnum[body]))


def _chain(model: mujoco.MjModel, body: int) -> Iterator[int]:
    """A body and all that carry it, but for the world."""
    while body:
        yield body
        body = int(model.body_parentid[body])


def _carries(model: mujoco.MjModel, body: int, other: int) -> bool:
    return body in _chain(model, other)
