"""Bend of the tendons of a compiled model, its extremes, and the idlers over which none slips."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.typing import FloatArray

_POSES = 100  # in which all joints are anywhere, and in as many more at an end
_FITTEST, _GENERATIONS = 60, 30  # of a search: poses in which it begins, and rounds
_JOINT_TYPE = mujoco.mjtJoint
_SCALAR = (_JOINT_TYPE.mjJNT_HINGE.value, _JOINT_TYPE.mjJNT_SLIDE.value)
_FREE = _JOINT_TYPE.mjJNT_FREE.value
_COUPLING = mujoco.mjtEq.mjEQ_JOINT.value
_PULLEY = -2  # in `mjData.wrap_obj`
_WRAP = mujoco.mjtWrap
_ON_JOINT = (mujoco.mjtTrn.mjTRN_JOINT.value, mujoco.mjtTrn.mjTRN_JOINTINPARENT.value)
_COAXIAL = 1e-3  # of the radius, by which an axis may miss another; [rad] by which it may tilt
# of the path's extent: points nearer than this are one, as both tangent points inside a geom are
_ONE_SPOT = 1e-10


def place_tendons(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Let the paths of all tendons be those of the pose."""
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_tendon(model, data)


def bend_at(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    qpos: FloatArray,
    tendons: Sequence[int],
    without: Collection[int] = (),
) -> FloatArray:
    """Bend of spatial tendons in a pose [rad]; over pulleys that of the most bent branch.

    ``data`` takes the pose. The bend at geoms ``without`` does not count.
    """
    data.qpos[:] = qpos
    place_tendons(model, data)
    points, objects = data.wrap_xpos.reshape(-1, 3), data.wrap_obj.ravel()
    bends = np.zeros(len(tendons))
    for column, tendon in enumerate(tendons):
        start, count = int(data.ten_wrapadr[tendon]), int(data.ten_wrapnum[tendon])
        own = slice(start, start + count)
        pulleys = np.flatnonzero(objects[own] == _PULLEY)
        branches = zip(np.split(points[own], pulleys), np.split(objects[own], pulleys), strict=True)
        bends[column] = max(branch_bend(path, on, without) for path, on in branches)
    return bends


def branch_bend(
    points: FloatArray, objects: NDArray[np.int32], without: Collection[int] = ()
) -> float:
    """Total angle that a path turns through [rad].

    At a site it turns by the angle between the straight stretches. Over a geom it goes from tangent
    point to tangent point and turns by the angle between the stretches before and after; by the
    rest of a full turn where the chord between the points runs against the first, which it does
    after more than half a turn. (k, 3) points and (k,) objects are those of `mjData`: a geom, −1
    for a site, −2 for a pulley, which is not a point.
    """
    points, objects = points[objects != _PULLEY], objects[objects != _PULLEY]
    total, before, chord = 0.0, None, None
    if len(points) < 2:
        return total
    apart = _ONE_SPOT * float(np.ptp(points, axis=0).max())
    for k, step in enumerate(np.diff(points, axis=0)):
        length = float(np.linalg.norm(step))
        if length <= apart:
            continue
        along = step / length
        if objects[k] >= 0 and objects[k] == objects[k + 1]:
            chord = along
            continue
        if before is not None and int(objects[k]) not in without:
            chords = np.linalg.norm(along - before), np.linalg.norm(along + before)
            angle = 2.0 * float(np.arctan2(*chords))
            beyond_half = chord is not None and before @ chord < 0.0
            total += 2.0 * np.pi - angle if beyond_half else angle
        before, chord = along, None
    return total


def sampled_poses(model: mujoco.MjModel) -> FloatArray:
    """Poses over the ranges of the joints, the same for a model every time.

    First `qpos0`; then every joint at each of its ends, the others as in `qpos0`; then all joints
    at once, 100 times anywhere and 100 times at an end. The ends of a hinge or a slide are those of
    its range; of a hinge without one, a quarter turn either way and half a turn. A ball joint turns
    about any axis up to its range; one without, and a free joint, up to half a turn, and a quarter
    is its end. Slides without a range and the position of free joints stay, see `unswept_joints`. A
    joint that an equality couples to another follows it.
    """
    rng = np.random.default_rng(0)
    alone, together = [model.qpos0], np.tile(model.qpos0, (2 * _POSES, 1))
    for joint in (j for j in range(model.njnt) if _is_swept(model, j)):
        where, ends, anywhere = _joint_sweep(model, joint, rng)
        for end in ends:
            alone.append(model.qpos0.copy())
            alone[-1][where] = end
        together[:_POSES, where] = anywhere
        together[_POSES:, where] = ends[rng.integers(len(ends), size=_POSES)]
    poses = np.concatenate([alone, together]) if len(alone) > 1 else np.array(alone)
    return _coupled(model, poses)


def extreme_poses(
    model: mujoco.MjModel,
    tendon: int,
    joints: Collection[int],
    poses: FloatArray,
    bends: FloatArray,
    without: Collection[int] = (),
) -> FloatArray:
    """(2, nq) poses of the largest and the smallest bend of a tendon, by differential evolution.

    The search starts from (p, nq) ``poses``, in which the tendon has (p,) ``bends`` [rad];
    ``joints`` are those that it crosses. Local searches (Nelder-Mead, Powell) get stuck in the many
    local extremes. (0, nq) without a ball joint: for hinges and slides the samples already contain
    the extremes.
    """
    from scipy.optimize import differential_evolution  # of the extra `lab`, as its command is

    dofs, ends, balls = _travels(model, leading_joints(model, joints))
    if not balls:
        return np.zeros((0, model.nq))
    data = mujoco.MjData(model)

    def pose(turns: FloatArray) -> FloatArray:
        qpos, travel, turns = model.qpos0.copy(), np.zeros(model.nv), turns.copy()
        for three, most in balls:
            turns[three] *= min(1.0, most / max(float(np.linalg.norm(turns[three])), most))
        travel[dofs] = turns
        mujoco.mj_integratePos(model, qpos, travel, 1.0)
        return _coupled(model, qpos[None]).ravel()

    def signed_bend(turns: FloatArray, sign: float) -> float:
        return sign * float(bend_at(model, data, pose(turns), [tendon], without)[0])

    travels = np.zeros((len(poses), model.nv))
    for travel, qpos in zip(travels, poses, strict=True):
        mujoco.mj_differentiatePos(model, travel, 1.0, model.qpos0, qpos)
    extremes = []
    for sign in (-1.0, 1.0):
        best = differential_evolution(
            signed_bend,
            ends,
            args=(sign,),
            init=travels[np.argsort(sign * bends)[:_FITTEST]][:, dofs],
            maxiter=_GENERATIONS,
            mutation=(0.5, 1.0),
            polish=False,
            tol=1e-3,
            rng=0,
        )
        extremes.append(pose(best.x))
    return np.array(extremes)


def _travels(
    model: mujoco.MjModel, joints: Collection[int]
) -> tuple[list[int], FloatArray, list[tuple[slice, float]]]:
    """Degrees of freedom of joints, their ends from `qpos0`, and places and ranges of balls."""
    dofs: list[int] = []
    ends: list[tuple[float, float]] = []
    balls = []
    for joint in sorted(joints):
        kind, first = model.jnt_type[joint], int(model.jnt_dofadr[joint])
        low, high = model.jnt_range[joint] if model.jnt_limited[joint] else (-np.pi, np.pi)
        if kind not in _SCALAR:
            balls.append((slice(len(dofs), len(dofs) + 3), float(high)))
            dofs += range(first + 3 * int(kind == _FREE), first + 3 * int(kind == _FREE) + 3)
            ends += [(-high, high)] * 3
        elif _is_swept(model, joint):
            start = model.qpos0[model.jnt_qposadr[joint]] if model.jnt_limited[joint] else 0.0
            dofs.append(first)
            ends.append((low - start, high - start))
    return dofs, np.array(ends), balls


def leading_joints(model: mujoco.MjModel, joints: Collection[int]) -> set[int]:
    """Ids of joints, those that an equality couples to another replaced by the other."""
    leads = {follows: lead for follows, lead, _ in _couplings(model)}
    return {leads.get(joint, joint) for joint in joints} - {-1}


def _couplings(model: mujoco.MjModel) -> list[tuple[int, int, FloatArray]]:
    """Joint that follows, joint that leads or −1, and polynomial of each active equality."""
    active = np.flatnonzero((model.eq_type == _COUPLING) & (model.eq_active0 != 0))
    ids = zip(model.eq_obj1id[active], model.eq_obj2id[active], strict=True)
    return [(int(a), int(b), model.eq_data[k, :5]) for (a, b), k in zip(ids, active, strict=True)]


def _coupled(model: mujoco.MjModel, poses: FloatArray) -> FloatArray:
    """Poses, changed so that joints that an equality couples to another follow it."""
    for follows, leads, polynomial in _couplings(model):
        at, lead = model.jnt_qposadr[follows], model.jnt_qposadr[leads]
        travel = poses[:, lead] - model.qpos0[lead] if leads >= 0 else 0.0
        poses[:, at] = model.qpos0[at] + np.polynomial.polynomial.polyval(travel, polynomial)
    return poses


def unswept_joints(model: mujoco.MjModel) -> list[int]:
    """Ids of slides without a range and of free joints, the position of which has none."""
    is_free = model.jnt_type == _FREE
    return [joint for joint in range(model.njnt) if is_free[joint] or not _is_swept(model, joint)]


def _is_swept(model: mujoco.MjModel, joint: int) -> bool:
    """Return whether a joint has a range, or turns."""
    is_slide = model.jnt_type[joint] == _JOINT_TYPE.mjJNT_SLIDE.value
    return bool(model.jnt_limited[joint]) or not is_slide


def _joint_sweep(
    model: mujoco.MjModel, joint: int, rng: np.random.Generator
) -> tuple[slice, FloatArray, FloatArray]:
    """Slice of a joint in `qpos`, its values at its ends, and `_POSES` values anywhere between."""
    kind, at = model.jnt_type[joint], int(model.jnt_qposadr[joint])
    low, high = model.jnt_range[joint]
    is_limited = bool(model.jnt_limited[joint])
    if kind in _SCALAR:
        ends = np.array([low, high])
        if not is_limited:
            low, high = model.qpos0[at] + np.array([-np.pi, np.pi])
            ends = model.qpos0[at] + np.pi * np.array([-0.5, 0.5, 1.0])
        return slice(at, at + 1), ends[:, None], rng.uniform(low, high, (_POSES, 1))
    at += 3 * int(kind == _FREE)
    where = slice(at, at + 4)
    largest = float(high) if is_limited else np.pi
    axes = rng.normal(size=(_POSES, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    end = largest if is_limited else 0.5 * np.pi
    ends = _turned(model.qpos0[where], end * np.concatenate([np.eye(3), -np.eye(3)]))
    return where, ends, _turned(model.qpos0[where], rng.uniform(0.0, largest, (_POSES, 1)) * axes)


def _turned(start: FloatArray, turns: FloatArray) -> FloatArray:
    """Quaternion turned by each of several rotation vectors [rad]."""
    turned = np.tile(start, (len(turns), 1))
    for quaternion, turn in zip(turned, turns, strict=True):
        mujoco.mju_quatIntegrate(quaternion, turn, 1.0)
    return turned


class Idler(NamedTuple):
    """A cylinder that turns with a tendon, so that the tendon does not slip over it; ids."""

    tendon: int
    geom: int  # the cylinder
    joint: int  # the hinge on its axis
    side_site: int  # that turns with it, and so leaves the side of the tendon; or −1


def idlers(model: mujoco.MjModel) -> list[Idler]:
    """Cylinders that turn freely with the one tendon that runs over them.

    A hinge on the cylinder's axis carries it, and carries neither another point of a tendon's path
    nor is held: by a range, a spring, an actuator or a coupling. Without friction nothing
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
            if model.wrap_type[k] != _WRAP.mjWRAP_CYLINDER.value:
                continue
            geom, side = int(model.wrap_objid[k]), int(model.wrap_prm[k])
            for body in _chain(model, bodies[k]):
                if any(_is_carrier(model, body, bodies[j]) for j in bodies if j != k):
                    break
                first_joint = int(model.body_jntadr[body])
                for joint in range(first_joint, first_joint + int(model.body_jntnum[body])):
                    if joint in held or not _is_axle(model, data, joint, geom):
                        continue
                    turns = side >= 0 and _turns_along(model, data, joint, body, side, geom)
                    rolling.append(Idler(tendon, geom, joint, side if turns else -1))
    return rolling


def _is_axle(model: mujoco.MjModel, data: mujoco.MjData, joint: int, geom: int) -> bool:
    """Return whether a joint is a hinge on the axis of a cylinder."""
    hinge, anchor = data.xaxis[joint], data.xanchor[joint]
    misses = np.linalg.norm(np.cross(data.geom_xpos[geom] - anchor, hinge))
    tilt = np.linalg.norm(np.cross(data.geom_xmat[geom].reshape(3, 3)[:, 2], hinge))
    is_hinge = model.jnt_type[joint] == _JOINT_TYPE.mjJNT_HINGE.value
    return bool(is_hinge and misses <= _COAXIAL * model.geom_size[geom, 0] and tilt <= _COAXIAL)


def _turns_along(
    model: mujoco.MjModel, data: mujoco.MjData, joint: int, body: int, site: int, geom: int
) -> bool:
    """Return whether a site turns about a hinge of a body that carries a cylinder, off its axis."""
    if not _is_carrier(model, body, int(model.site_bodyid[site])):
        return False
    arm = np.cross(data.site_xpos[site] - data.xanchor[joint], data.xaxis[joint])
    return bool(np.linalg.norm(arm) > _COAXIAL * model.geom_size[geom, 0])


def _held_joints(model: mujoco.MjModel) -> set[int]:
    """Joints with a range, a spring, an actuator, a coupling or a fixed tendon."""
    on_joint = np.isin(model.actuator_trntype, _ON_JOINT)
    couplings = model.eq_type == _COUPLING
    return {
        *map(int, np.flatnonzero((model.jnt_limited != 0) | (model.jnt_stiffness != 0.0))),
        *map(int, model.actuator_trnid[on_joint, 0]),
        *map(int, model.eq_obj1id[couplings]),
        *map(int, model.eq_obj2id[couplings]),
        *map(int, model.wrap_objid[model.wrap_type == _WRAP.mjWRAP_JOINT.value]),
    }


def _body(model: mujoco.MjModel, element: int) -> int:
    """Body of an element of a tendon's path; the world for one that has none."""
    kind, target = model.wrap_type[element], int(model.wrap_objid[element])
    if kind in (_WRAP.mjWRAP_JOINT.value, _WRAP.mjWRAP_PULLEY.value):
        return 0
    is_site = kind == _WRAP.mjWRAP_SITE.value
    return int(model.site_bodyid[target] if is_site else model.geom_bodyid[target])


def _chain(model: mujoco.MjModel, body: int) -> Iterator[int]:
    """A body and all that carry it, except the world."""
    while body:
        yield body
        body = int(model.body_parentid[body])


def _is_carrier(model: mujoco.MjModel, body: int, other: int) -> bool:
    return body in _chain(model, other)
