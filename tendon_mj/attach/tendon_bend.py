"""Bend of the tendons of a compiled model: the total angle that each turns through."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.typing import FloatArray

_POSES = 100  # in which all joints are anywhere, and in as many more at an end
_FITTEST, _GENERATIONS = 60, 30  # of a search: poses in which it begins, and rounds
_JOINT = mujoco.mjtJoint
_SCALAR = (_JOINT.mjJNT_HINGE.value, _JOINT.mjJNT_SLIDE.value)
_FREE = _JOINT.mjJNT_FREE.value
_COUPLING = mujoco.mjtEq.mjEQ_JOINT.value
_PULLEY = -2  # in `mjData.wrap_obj`
# of the path's extent: points nearer than this are one, as both tangent points inside a geom are
_ONE_SPOT = 1e-10


def bend_at(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    qpos: FloatArray,
    tendons: Sequence[int],
    without: Collection[int] = (),
) -> FloatArray:
    """Bend of tendons in a pose [rad]; of one over pulleys that of its most bent branch.

    Args:
        model: compiled.
        data: of that model, whose positions are changed.
        qpos: pose.
        tendons: ids of spatial tendons.
        without: ids of geoms whose bend does not count.
    """
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_tendon(model, data)
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
    after more than half a turn.

    Args:
        points: (k, 3) as in `mjData.wrap_xpos` [m].
        objects: (k,) geom of each, −1 for a site, −2 for a pulley, which is no point.
        without: geoms whose bend does not count.
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
    """Poses over what the joints allow, the same for a model every time.

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
        where, ends, anywhere = _sweep(model, joint, rng)
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
    """Poses of the most and of the least bend of a tendon, bred from others by evolution.

    Args:
        model: compiled.
        tendon: id of a spatial tendon.
        joints: ids of those that it crosses.
        poses: in which the search begins, see `sampled_poses`.
        bends: of the tendon in them [rad].
        without: ids of geoms whose bend does not count.

    Returns:
        (2, nq), or (0, nq) where no ball joint is among them: of hinges and slides samples find
        the extremes.
    """
    from scipy.optimize import differential_evolution  # of the extra `lab`, as its command is

    data, dofs, ends = mujoco.MjData(model), np.zeros(0, int), np.zeros((0, 2))
    balls: list[tuple[slice, float]] = []
    for joint in sorted(leading_joints(model, joints)):
        kind, first = model.jnt_type[joint], int(model.jnt_dofadr[joint])
        low, high = model.jnt_range[joint] if model.jnt_limited[joint] else (-np.pi, np.pi)
        if kind not in _SCALAR:
            balls.append((slice(len(dofs), len(dofs) + 3), high))
            dofs = np.append(dofs, first + 3 * int(kind == _FREE) + np.arange(3))
            ends = np.append(ends, [[-high, high]] * 3, axis=0)
        elif _is_swept(model, joint):
            start = model.qpos0[model.jnt_qposadr[joint]] if model.jnt_limited[joint] else 0.0
            dofs = np.append(dofs, first)
            ends = np.append(ends, [[low - start, high - start]], axis=0)
    if not balls:
        return np.zeros((0, model.nq))

    def pose(turns: FloatArray) -> FloatArray:
        qpos, travel, turns = model.qpos0.copy(), np.zeros(model.nv), turns.copy()
        for three, most in balls:
            turns[three] *= min(1.0, most / max(float(np.linalg.norm(turns[three])), most))
        travel[dofs] = turns
        mujoco.mj_integratePos(model, qpos, travel, 1.0)
        return _coupled(model, qpos[None]).ravel()

    travels = np.zeros((len(poses), model.nv))
    for travel, qpos in zip(travels, poses, strict=True):
        mujoco.mj_differentiatePos(model, travel, 1.0, model.qpos0, qpos)
    return np.array(
        [
            pose(
                differential_evolution(
                    lambda turns, sign=sign: (
                        sign * bend_at(model, data, pose(turns), [tendon], without)[0]
                    ),
                    ends,
                    init=travels[np.argsort(sign * bends)[:_FITTEST]][:, dofs],
                    maxiter=_GENERATIONS,
                    mutation=(0.5, 1.0),
                    polish=False,
                    tol=1e-3,
                    rng=0,
                ).x
            )
            for sign in (-1.0, 1.0)
        ]
    )


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
    """Whether a joint has a range, or turns."""
    is_slide = model.jnt_type[joint] == _JOINT.mjJNT_SLIDE.value
    return bool(model.jnt_limited[joint]) or not is_slide


def _sweep(
    model: mujoco.MjModel, joint: int, rng: np.random.Generator
) -> tuple[slice, FloatArray, FloatArray]:
    """Where a joint is in `qpos`, its values at its ends, and `_POSES` values anywhere between."""
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
