"""Pictures of a finger in an environment, its tendons coloured by their tension."""

from __future__ import annotations

import mujoco
from matplotlib.colors import Normalize

from tendon_mj.plugin import segment_tensions, sheaths
from tendon_mj.show import Image, Offscreen, add_cable, without_tendons

_SCALE = Normalize(0.0, 30.0)  # of the colours [N]
_RADIUS = 0.0009  # of a tendon as drawn [m]
_CENTRE, _DISTANCE = (-0.01, 0.0, -0.03), 0.22  # what the camera looks at, and from how far [m]
_AZIMUTH, _ELEVATION = 90.0, -8.0  # of the camera [deg]


def add_sky(spec: mujoco.MjSpec) -> None:
    """Add a white sky, before which translucent skin is seen; nothing moves otherwise for it."""
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT,
        rgb1=[1.0, 1.0, 1.0],
        rgb2=[1.0, 1.0, 1.0],
        width=8,
        height=8,
    )


class Painter:
    """Draws a finger's model and data; to be closed after use.

    Args:
        model: not changed.
        width, height: of the pictures [pixels].

    Raises:
        EngineError: no OpenGL is to be had; the message says what to do.
    """

    def __init__(self, model: mujoco.MjModel, width: int, height: int) -> None:
        self.model = model
        self._offscreen = Offscreen(without_tendons(model), width, height)
        self._camera = mujoco.MjvCamera()
        self._camera.lookat[:], self._camera.distance = _CENTRE, _DISTANCE
        self._camera.azimuth, self._camera.elevation = _AZIMUTH, _ELEVATION

    def draw(self, data: mujoco.MjData) -> Image:
        """(height, width, 3) picture of the state of ``data``."""

        def add(scene: mujoco.MjvScene) -> None:
            for name in sheaths(self.model):
                points, tensions = segment_tensions(self.model, data, name)
                add_cable(scene, points, tensions, _SCALE, _RADIUS)

        return self._offscreen.draw(data, self._camera, add)

    def close(self) -> None:
        """Free the graphics memory."""
        self._offscreen.close()
