"""Views of a model, colours of its curves, and its tendons as the plugin draws them."""

from __future__ import annotations

from typing import NamedTuple

import mujoco
import numpy as np
from matplotlib.colors import to_rgb
from numpy.typing import NDArray

from tendon_mj.show.render.panel import tendon_colours
from tendon_mj.typing import FloatArray

_PALER = 0.5  # share of white in the curve of the output
_TENDON = mujoco.mjtObj.mjOBJ_TENDON.value
_SPAN, _MARK = mujoco.mjtGeom.mjGEOM_CAPSULE.value, mujoco.mjtGeom.mjGEOM_SPHERE.value


class Viewpoint(NamedTuple):
    """An upright view from a position to a point [m], around which it turns; its height [deg]."""

    position: FloatArray
    look_at: FloatArray
    fovy: float


def first_view(model: mujoco.MjModel) -> Viewpoint:
    """The view of a model's first camera at `qpos0`, or one of the whole model without a camera."""
    if model.ncam == 0:
        camera = mujoco.MjvCamera()
        mujoco.mjv_defaultFreeCamera(model, camera)
        turned, raised = np.radians([camera.azimuth, camera.elevation])
        flat = np.cos(raised)
        forward = np.array([flat * np.cos(turned), flat * np.sin(turned), np.sin(raised)])
        look_at = np.array(camera.lookat)
        return Viewpoint(
            look_at - camera.distance * forward, look_at, float(model.vis.global_.fovy)
        )
    data = mujoco.MjData(model)
    mujoco.mj_fwdPosition(model, data)
    position, forward = data.cam_xpos[0].copy(), -data.cam_xmat[0].reshape(3, 3)[:, 2]
    ahead = float((model.stat.center - position) @ forward)
    distance = ahead if ahead > 0.0 else float(model.stat.extent)
    return Viewpoint(position, position + distance * forward, float(model.cam_fovy[0]))


def look_from(camera: mujoco.MjvCamera, model: mujoco.MjModel, view: Viewpoint) -> None:
    """Give a view to a camera that the mouse turns; the field of view is the model's."""
    x, y, z = view.look_at - view.position
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.lookat[:] = view.look_at
    camera.distance = float(np.linalg.norm([x, y, z]))
    camera.azimuth = float(np.degrees(np.arctan2(y, x)))
    camera.elevation = float(np.degrees(np.arctan2(z, np.hypot(x, y))))
    model.vis.global_.fovy = view.fovy


def curve_colours(model: mujoco.MjModel) -> FloatArray:
    """(sheaths, 2, 3) red, green and blue of the curves of input and output, 0 to 1."""
    full = np.array([to_rgb(colour) for colour in tendon_colours(model).values()]).reshape(-1, 3)
    return np.stack([full, (1.0 - _PALER) * full + _PALER], axis=1)


def drawn_tendons(
    model: mujoco.MjModel, data: mujoco.MjData, scene: mujoco.MjvScene
) -> tuple[FloatArray, NDArray[np.uint8], FloatArray]:
    """Tendons as the plugin draws them into a scene, for a viewer that has its own primitives.

    The model has a tension scale, the data were evaluated; the scene changes. Returns (n, 2, 3)
    ends of the spans [m], their (n, 3) colours, 0 to 255, and (k, 3) guides over which a tendon
    slips [m].
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
    return (
        np.array(ends, float).reshape(-1, 2, 3),
        np.round(255.0 * np.clip(np.array(colours).reshape(-1, 3), 0.0, 1.0)).astype(np.uint8),
        np.array(slipping, float).reshape(-1, 3),
    )
