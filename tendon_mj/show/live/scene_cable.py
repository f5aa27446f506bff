"""The tendons as the plugin draws them, for a viewer that has primitives of its own."""

from __future__ import annotations

from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.typing import FloatArray

_MOST = 20000  # geoms
_TENDON = mujoco.mjtObj.mjOBJ_TENDON.value
_SPAN, _MARK = mujoco.mjtGeom.mjGEOM_CAPSULE.value, mujoco.mjtGeom.mjGEOM_SPHERE.value


class SceneCable(NamedTuple):
    """All tendons of a model at one moment.

    Attributes:
        ends: (n, 2, 3) of the spans [m].
        colours: (n, 3) red, green and blue of the spans, 0 to 255.
        slipping: (k, 3) guides over which a tendon slips [m].
    """

    ends: FloatArray
    colours: NDArray[np.uint8]
    slipping: FloatArray


def new_scene(model: mujoco.MjModel) -> mujoco.MjvScene:
    """A scene for `scene_cable`."""
    return mujoco.MjvScene(model, _MOST)


def scene_cable(model: mujoco.MjModel, data: mujoco.MjData, scene: mujoco.MjvScene) -> SceneCable:
    """What the plugin draws, which it does where the model has a tension scale.

    Args:
        model, data: at any moment after an evaluation.
        scene: of the model; changed.
    """
    option = mujoco.MjvOption()
    option.flags[:] = 0
    option.flags[mujoco.mjtVisFlag.mjVIS_TENDON] = 1
    mujoco.mjv_updateScene(model, data, option, None, mujoco.MjvCamera(), 0, scene)
    ends, colours, slipping = [], [], []
    for geom in scene.geoms[: scene.ngeom]:
        if geom.objtype != _TENDON or geom.emission == 0.0:
            continue
        if geom.type == _MARK:
            slipping.append(geom.pos.copy())
        elif geom.type == _SPAN:
            along = geom.size[2] * geom.mat[:, 2]
            ends.append([geom.pos - along, geom.pos + along])
            colours.append(geom.emission * geom.rgba[:3])
    return SceneCable(
        np.array(ends, float).reshape(-1, 2, 3),
        np.round(255.0 * np.clip(np.array(colours).reshape(-1, 3), 0.0, 1.0)).astype(np.uint8),
        np.array(slipping, float).reshape(-1, 3),
    )
