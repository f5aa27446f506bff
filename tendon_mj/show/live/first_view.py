"""From where a model is seen first: its first camera, as a view that can be turned."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from tendon_mj.typing import FloatArray


@dataclass(frozen=True)
class FirstView:
    """A view that looks at a point, upright.

    Attributes:
        position: of the eye [m].
        look_at: point that it looks at, and turns around [m].
        fovy: vertical field of view [deg].
    """

    position: FloatArray
    look_at: FloatArray
    fovy: float

    @property
    def distance(self) -> float:
        """From the eye to the point [m]."""
        return float(np.linalg.norm(self.look_at - self.position))

    @property
    def azimuth(self) -> float:
        """Direction in which it looks, about the vertical from x [deg]."""
        x, y, _ = self.look_at - self.position
        return float(np.degrees(np.arctan2(y, x)))

    @property
    def elevation(self) -> float:
        """Direction in which it looks, above the horizontal [deg]."""
        x, y, z = self.look_at - self.position
        return float(np.degrees(np.arctan2(z, np.hypot(x, y))))


def first_view(model: mujoco.MjModel) -> FirstView:
    """The view of a model's first camera at `qpos0`, or one of the whole model without a camera."""
    if model.ncam == 0:
        camera = mujoco.MjvCamera()
        mujoco.mjv_defaultFreeCamera(model, camera)
        turned, raised = np.radians([camera.azimuth, camera.elevation])
        flat = np.cos(raised)
        forward = np.array([flat * np.cos(turned), flat * np.sin(turned), np.sin(raised)])
        look_at = np.array(camera.lookat)
        fovy = float(model.vis.global_.fovy)
        return FirstView(look_at - camera.distance * forward, look_at, fovy)
    data = mujoco.MjData(model)
    mujoco.mj_fwdPosition(model, data)
    position, forward = data.cam_xpos[0].copy(), -data.cam_xmat[0].reshape(3, 3)[:, 2]
    ahead = float((model.stat.center - position) @ forward)
    distance = ahead if ahead > 0.0 else float(model.stat.extent)
    return FirstView(position, position + distance * forward, float(model.cam_fovy[0]))
