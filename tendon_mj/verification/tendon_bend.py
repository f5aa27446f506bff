"""Bend of the tendons of a compiled model: the total angle that each turns through."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_POSES = 200  # at random over which the range of a bend is sampled
_PULLEY = -2  # in `mjData.wrap_obj`
# of the path's extent: points nearer than this are one, as both tangent points inside a geom are
_ONE_SPOT = 1e-10


def bend_at(
    model: mujoco.MjModel, data: mujoco.MjData, qpos: FloatArray, tendons: Sequence[int]
) -> FloatArray:
    """Bend of tendons in a pose [rad]; of one over pulleys that of its most bent branch.

    Args:
        model: compiled.
        data: of that model, whose positions are changed.
        qpos: pose.
        tendons: ids of spatial tendons.
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
        bends[column] = max(branch_bend(path, on) for path, on in branches)
    return bends


def branch_bend(points: FloatArray, objects: NDArray[np.int32]) -> float:
    """Total angle that a path turns through [rad].

    At a site it turns by the angle between the straight stretches. Over a geom it goes from tangent
    point to tangent point and turns by the angle between the stretches before and after; by the
    rest of a full turn where the chord between the points runs against the first, which it does
    after more than half a turn.

    Args:
        points: (k, 3) as in `mjData.wrap_xpos` [m].
        objects: (k,) geom of each, −1 for a site, −2 for a pulley, which is no point.
    """
    points, objects = points[objects != _PULLEY], objects[objects != _PULLEY]
    total, before, chord = 0.0, None, None
    apart = _ONE_SPOT * float(np.ptp(points, axis=0).max())
    for k, step in enumerate(np.diff(points, axis=0)):
        length = float(np.linalg.norm(step))
        if length <= apart:
            continue
        along = step / length
        if objects[k] >= 0 and objects[k] == objects[k + 1]:
            chord = along
            continue
        if before is not None:
            sine = float(np.linalg.norm(np.cross(before, along)))
            angle = float(np.arctan2(sine, before @ along))
            beyond_half = chord is not None and before @ chord < 0.0
            total += 2.0 * np.pi - angle if beyond_half else angle
        before, chord = along, None
    return total


def sampled_poses(model: mujoco.MjModel) -> FloatArray:
    """Poses over the ranges of the joints, the same for a model every time.

    Every hinge and slide with a range is at each of its ends, the others as in `qpos0`; and then
    all are anywhere in their ranges at once, 200 times.
    """
    slides_and_hinges = model.jnt_type >= mujoco.mjtJoint.mjJNT_SLIDE.value
    ranged = np.flatnonzero((model.jnt_limited != 0) & slides_and_hinges)
    low, high = model.jnt_range[ranged].T
    address = model.jnt_qposadr[ranged]
    ends = np.tile(model.qpos0, (2 * len(ranged), 1))
    ends[np.arange(len(ranged)), address] = low
    ends[len(ranged) + np.arange(len(ranged)), address] = high
    anywhere = np.tile(model.qpos0, (_POSES if len(ranged) else 0, 1))
    rng = np.random.default_rng(0)
    anywhere[:, address] = rng.uniform(low, high, (len(anywhere), len(ranged)))
    return np.concatenate([model.qpos0[None], ends, anywhere])
