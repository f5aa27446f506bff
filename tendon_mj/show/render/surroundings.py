"""Floor, light and camera of a model that has none, for the eye alone.

They are added to what is drawn, and never to the model that is simulated.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import NamedTuple

import mujoco
import numpy as np

from tendon_mj.lab.frames import Frames
from tendon_mj.plugin import UNDRAWN
from tendon_mj.show.render.see_through import PULLEY, WRAPPED, see_through
from tendon_mj.typing import FloatArray

_PLANE = mujoco.mjtGeom.mjGEOM_PLANE.value
_AMBIENT, _DIFFUSE = 0.45, 0.5  # of a headlight that is the only light; MuJoCo's own is dim
_THINNEST = 0.004  # radius of a tendon that is seen from afar, over the size of all of them
_BELOW = 0.15  # distance of the floor from the lowest point, over the size of the model
_FLOOR_SIZE = 20.0  # half the floor's width over the size of the model
FLOOR_COLOUR, _GLOW = (0.90, 0.91, 0.92), 0.5  # a headlight alone leaves it dark
_ASPECT, _MARGIN = 1.15, 1.2  # width over height that a view fits into, and the space around it
_LEAST_SEEN = 0.5  # size of the tendons in a camera's picture over half its height
_POSES = 20  # of a motion
_LOST = 0.25  # share of the tendons' points that a motion takes out of a camera's picture
_DOWN, _DOWN_MORE = 15.0, 40.0  # how far a view looks down on what stands, and on what lies [deg]
_TURNS = (0.0, 90.0, 45.0, 135.0)  # of views that are compared [deg]
_CLEARLY = 1.5  # what the chosen view shows of the motion over what the one across shows
_CORNERS = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T


def poses_of(model: mujoco.MjModel, frames: Frames) -> FloatArray:
    """(k, nq) poses of a motion that are to be in the picture."""
    return frames.poses[:: max(1, len(frames.poses) // _POSES), : model.nq]


def to_show(model: mujoco.MjModel) -> mujoco.MjModel:
    """A copy to draw: lit if it has no light, tendons as thick as the eye needs, not hidden."""
    shown = copy.copy(model)
    see_through(shown)
    if model.nlight == 0:
        shown.vis.headlight.ambient[:] = _AMBIENT
        shown.vis.headlight.diffuse[:] = _DIFFUSE
        shown.vis.headlight.specular[:] = 0.0
    paths = _outlines(model, None)[1].paths
    if len(paths):
        thinnest = _THINNEST * _size(paths)
        shown.tendon_width[:] = np.maximum(model.tendon_width, thinnest)
    return shown


class Floor(NamedTuple):
    """A square on the ground."""

    middle: FloatArray  # [m]
    half_width: float  # [m]


def floor(model: mujoco.MjModel, poses: FloatArray | None = None) -> Floor | None:
    """Floor below a model in (k, nq) ``poses``, by default `qpos0`; None if it has its own."""
    if (model.geom_type == _PLANE).any() or model.nhfield:
        return None
    around = _outlines(model, poses)[1].around
    middle = 0.5 * (around.min(axis=0) + around.max(axis=0))
    middle[2] = around[:, 2].min() - _BELOW * _size(around)
    return Floor(middle, _FLOOR_SIZE * _size(around))


def add_floor(scene: mujoco.MjvScene, ground: Floor | None) -> None:
    """Draw a floor into a scene, as it has room."""
    if ground is None or scene.ngeom >= scene.maxgeom:
        return
    rgba = np.array([*FLOOR_COLOUR, 1.0], np.float32)
    size, turn = np.full(3, ground.half_width), np.eye(3).ravel()
    geom = scene.geoms[scene.ngeom]
    mujoco.mjv_initGeom(geom, _PLANE, size, ground.middle, turn, rgba)
    geom.emission = _GLOW
    scene.ngeom += 1


def first_camera(model: mujoco.MjModel, poses: FloatArray | None = None) -> int:
    """Index of the first camera that shows the tendons, large enough; -1 without one.

    It does in the first of (k, nq) ``poses``, by default `qpos0`, and goes on in the others. A
    camera on a body that moves shows the world moving in its place, and is left out.
    """
    stands = model.body_weldid[model.cam_bodyid] == 0
    shown = dict.fromkeys(np.flatnonzero(stands).tolist(), 0.0)
    for number, data in enumerate(_posed(model, poses)):
        paths = _outline(model, data).paths
        if not len(paths):
            return min(0, int(model.ncam) - 1)
        for k in [*shown]:
            seen = (paths - data.cam_xpos[k]) @ data.cam_xmat[k].reshape(3, 3)
            half_view = np.tan(0.5 * np.radians(model.cam_fovy[k]))
            places = seen[:, :2] / (-seen[:, 2:] * half_view)  # ±1 at the upper and lower edge
            inside = (np.abs(places) < (_ASPECT, 1.0)).all(axis=1) & (seen[:, 2] < 0.0)
            if number == 0:
                is_inside = np.median(np.abs(places), axis=0) < (_ASPECT, 1.0)
                is_large = np.ptp(places, axis=0).max() > _LEAST_SEEN
                kept = is_inside.all() and is_large and (seen[:, 2] < 0.0).all()
                shown[k] = float(inside.mean())
            else:
                kept = inside.mean() >= (1.0 - _LOST) * shown[k]
            if not kept:
                del shown[k]
    return min(shown, default=-1)


def framing(model: mujoco.MjModel, poses: FloatArray | None = None) -> mujoco.MjvCamera:
    """A camera that sees all of a model, across the plane in which its tendons run.

    It does in all (k, nq) ``poses``, by default `qpos0`. Without tendons it is the plane of the
    geoms. What neither moves nor is a tendon may be outside. Where a view from another side shows
    clearly more of the motion, it is that.
    """
    first, (paths, moving, around) = _outlines(model, poses)
    spread = first.paths if len(first.paths) else first.around
    around = np.concatenate([paths, moving]) if len(paths) or len(moving) else around
    away = spread - spread.mean(axis=0)
    long, _, across = np.linalg.svd(away)[2]
    level = across[:2] if np.hypot(*across[:2]) > abs(across[2]) else np.array([-long[1], long[0]])
    down = np.radians(-_DOWN - _DOWN_MORE * abs(float(across[2])))
    moved = moving.reshape(1 if poses is None else len(poses), -1, 3) - first.moving
    level = _side(np.arctan2(level[1], level[0]), down, (away, moved.reshape(-1, 3)))
    camera = mujoco.MjvCamera()
    mujoco.mjv_defaultFreeCamera(model, camera)
    camera.lookat[:] = 0.5 * (around.min(axis=0) + around.max(axis=0))
    camera.azimuth = float(np.degrees(np.arctan2(level[1], level[0])))
    camera.elevation = float(np.degrees(down))
    forward = _forward(level, down)
    right = np.array([level[1], -level[0], 0.0])
    away = around - camera.lookat
    seen = np.maximum(np.abs(away @ np.cross(right, forward)), np.abs(away @ right) / _ASPECT)
    half_view = np.tan(0.5 * np.radians(model.vis.global_.fovy))
    camera.distance = max(float((_MARGIN * seen / half_view - away @ forward).max()), 1e-3)
    return camera


def _side(azimuth: float, down: float, shown: tuple[FloatArray, ...]) -> FloatArray:
    """Level direction of an azimuth, or of another that shows clearly more; x is to the right.

    ``shown`` are sets of (k, 3) ways [m]; the one of which a view shows least counts.
    """

    def share(level: FloatArray) -> float:
        forward = _forward(level, down)
        hidden = [np.sum((ways @ forward) ** 2) / max(np.sum(ways**2), 1e-30) for ways in shown]
        return float(np.sqrt(max(0.0, 1.0 - max(hidden))))

    turned = azimuth + np.radians(_TURNS)
    first, *others = np.stack([np.cos(turned), np.sin(turned)], axis=1)
    best = max(others, key=share)
    level = best if share(best) > _CLEARLY * share(first) else first
    return np.asarray(level * (1.0 if level[1] >= 0.0 else -1.0))


def _forward(level: FloatArray, down: float) -> FloatArray:
    return np.array([*(np.cos(down) * level), np.sin(down)])


class _Outline(NamedTuple):
    """(k, 3) points of a model in a pose [m]."""

    paths: FloatArray  # of tendons
    moving: FloatArray  # corners of the boxes around geoms that move or that a tendon wraps around
    around: FloatArray  # all of these, and those of all other geoms


def _posed(model: mujoco.MjModel, poses: FloatArray | None) -> Iterator[mujoco.MjData]:
    """The same data in one of (k, nq) poses after the other, by default in `qpos0`."""
    data = mujoco.MjData(model)
    for pose in model.qpos0[None] if poses is None else poses:
        data.qpos[:] = pose
        mujoco.mj_fwdPosition(model, data)
        yield data


def _outlines(model: mujoco.MjModel, poses: FloatArray | None) -> tuple[_Outline, _Outline]:
    """Outline in the first of several poses, and in all of them together."""
    every = [_outline(model, data) for data in _posed(model, poses)]
    return every[0], _Outline(*(np.concatenate(parts) for parts in zip(*every, strict=True)))


def _outline(model: mujoco.MjModel, data: mujoco.MjData) -> _Outline:
    """Outline of a model in the pose of its data."""
    count = int(data.ten_wrapnum.sum())
    drawn = np.repeat(model.tendon_group != UNDRAWN, data.ten_wrapnum)
    drawn &= data.wrap_obj.ravel()[:count] != PULLEY
    paths = data.wrap_xpos.reshape(-1, 3)[:count][drawn]
    ground = np.isin(model.geom_type, [_PLANE, mujoco.mjtGeom.mjGEOM_HFIELD.value])
    geoms = ~ground & (model.geom_rgba[:, 3] > 0.0)
    middle, half = np.split(model.geom_aabb[geoms], 2, axis=1)
    turned = (
        data.geom_xmat[geoms].reshape(-1, 1, 3, 3)
        @ (middle[:, None] + half[:, None] * _CORNERS)[..., None]
    )
    corners = data.geom_xpos[geoms, None] + turned[..., 0]
    wrapped = np.isin(model.wrap_type, WRAPPED)
    shown = model.body_weldid[model.geom_bodyid[geoms]] != 0
    shown |= np.isin(np.flatnonzero(geoms), model.wrap_objid[wrapped])
    moving = corners[shown].reshape(-1, 3)
    around = np.concatenate([paths, corners.reshape(-1, 3)])
    return _Outline(paths, moving, around if len(around) else np.array([model.stat.center]))


def _size(around: FloatArray) -> float:
    return max(float(np.linalg.norm(np.ptp(around, axis=0))), 1e-6)
