"""Bodies that tendons run within are drawn translucent, so that the tendons can be seen."""

from __future__ import annotations

import copy
from collections import Counter

import mujoco
import numpy as np

from tendon_mj.typing import FloatArray

_WITHIN = 0.25  # share of a tendon's length, from which on what is around it is translucent
_OPACITY = 0.2
_SPOTS = np.array([0.125, 0.375, 0.625, 0.875])  # of a span that are looked at
_SHOWN = np.array([1, 1, 1, 0, 0, 0], np.uint8)  # groups of geoms that MuJoCo shows by itself
_HIDDEN = mujoco.mjNGROUP - 1
_PLAIN = np.array([0.5, 0.5, 0.5, 1.0], np.float32)  # in its place the material's colour counts
PULLEY = -2  # of `mjData.wrap_obj`
WRAPPED = mujoco.mjtWrap.mjWRAP_SPHERE.value, mujoco.mjtWrap.mjWRAP_CYLINDER.value


def see_through(shown: mujoco.MjModel) -> None:
    """Make the geoms that tendons run within translucent, in a model that is only drawn.

    They are looked for in `qpos0`, also one in another. A geom that tendons wrap around stays.
    """
    probe = copy.copy(shown)
    probe.geom_group[shown.wrap_objid[np.isin(shown.wrap_type, WRAPPED)]] = _HIDDEN
    data = mujoco.MjData(probe)
    mujoco.mj_fwdPosition(probe, data)
    while around := {geom for k in range(shown.ntendon) for geom in _geoms_around(probe, data, k)}:
        for geom in around:
            probe.geom_group[geom] = _HIDDEN  # for one that is around this one
            red, green, blue, opacity = colour_of(shown, geom)
            shown.geom_rgba[geom] = red, green, blue, min(_OPACITY, opacity)
            shown.geom_matid[geom] = -1


def colour_of(model: mujoco.MjModel, geom: int) -> FloatArray:
    """(4,) red, green, blue and opacity of a geom, its own or those of its material."""
    material, own = model.geom_matid[geom], model.geom_rgba[geom]
    is_own = material < 0 or (own != _PLAIN).any()
    return np.array(own if is_own else model.mat_rgba[material], float)


def _geoms_around(model: mujoco.MjModel, data: mujoco.MjData, tendon: int) -> list[int]:
    """Geoms that a good part of a tendon's length lies within."""
    path = slice(data.ten_wrapadr[tendon], data.ten_wrapadr[tendon] + data.ten_wrapnum[tendon])
    points = data.wrap_xpos.reshape(-1, 3)[path]
    is_point = data.wrap_obj.ravel()[path] != PULLEY
    lengths, within = 0.0, dict[int, float]()
    for k in np.flatnonzero(is_point[:-1] & is_point[1:]):
        length = float(np.linalg.norm(points[k + 1] - points[k]))
        lengths += length
        for share in _SPOTS:
            geom = _geom_around(model, data, (1.0 - share) * points[k] + share * points[k + 1])
            if geom >= 0:
                within[geom] = within.get(geom, 0.0) + length / len(_SPOTS)
    return [*within] if sum(within.values()) > _WITHIN * lengths else []


def _geom_around(model: mujoco.MjModel, data: mujoco.MjData, point: FloatArray) -> int:
    """The geom that is next in both directions along two axes at least; -1 without one."""
    found, around = np.empty(1, np.int32), Counter[int]()
    for axis in np.eye(3):
        ends = set[int]()
        for direction in (axis, -axis):
            mujoco.mj_ray(model, data, point, direction, _SHOWN, 1, -1, found)
            ends.add(int(found[0]))
        if len(ends) == 1:
            around.update(ends)
    del around[-1]
    return next((geom for geom, axes in around.items() if axes > 1), -1)
