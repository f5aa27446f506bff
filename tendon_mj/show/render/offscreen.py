"""Draws a model's scene into an array, without a window.

MuJoCo chooses an OpenGL platform when it is imported: GLFW, which needs a screen, unless
`MUJOCO_GL` says otherwise. The choice here is made when something is first drawn, so the variable
need not be set.
"""

from __future__ import annotations

import copy
import importlib
import os
import platform
import warnings
from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import EngineError, UnknownNameError
from tendon_mj.typing import FloatArray

Image = NDArray[np.uint8]
_MAX_GEOMS = 20000
_OFF = ("disable", "disabled", "off", "false", "0")
_MODULES = {
    "egl": "mujoco.egl",
    "osmesa": "mujoco.osmesa",
    "glfw": "mujoco.glfw",
    "glx": "mujoco.glfw",
    "wgl": "mujoco.glfw",
    "cgl": "mujoco.cgl",
}
_HINT = (
    "GLFW needs a screen (DISPLAY or WAYLAND_DISPLAY), CGL macOS. EGL draws without a screen: "
    "unset MUJOCO_GL or set it to egl, and install libEGL and libGL (Debian, Ubuntu: apt install "
    "libegl1 libgl1; NVIDIA's driver brings its own). OSMesa draws on the processor alone: install "
    "it (Debian: apt install libosmesa6) and set MUJOCO_GL=osmesa before Python starts"
)


def gl_platforms() -> tuple[str, ...]:
    """Platforms to try in turn: the one in `MUJOCO_GL`, else those that can do without a screen."""
    chosen = os.environ.get("MUJOCO_GL", "").lower().strip()
    if chosen in _MODULES:
        return (chosen,)
    if chosen in _OFF:
        raise EngineError(f"MUJOCO_GL={chosen} turns drawing off; unset it or set it to egl")
    if platform.system() == "Darwin":
        return ("cgl", "glfw")
    if platform.system() == "Windows":
        return ("glfw",)
    screen = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    # no OSMesa after EGL: PyOpenGL binds to one platform for the life of the process
    return ("glfw", "egl") if screen else ("egl",)


def make_context(width: int, height: int) -> Any:
    """A current OpenGL context for pictures of that size [pixels], to be freed by ``free()``."""
    failures = []
    for name in gl_platforms():
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")  # GLFW warns, and goes on without a window
                kind = importlib.import_module(_MODULES[name]).GLContext
                context = kind.__new__(kind)
                context._context = None  # so that one which fails half-way can be freed
                context.__init__(width, height)
                context.make_current()
                return context
        except Exception as error:  # each platform has failures of its own kind
            failures.append(f"{name} ({_reason(error)})")
    raise EngineError(f"no OpenGL to draw with, tried {', '.join(failures)}. {_HINT}")


def _reason(error: Exception) -> str:
    try:
        text = " ".join(str(error).split())
    except Exception:  # PyOpenGL's errors ask the context that is missing
        text = ""
    if isinstance(error, AttributeError) and "NoneType" in text:
        return "its library was not found"  # PyOpenGL has None in its place
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def find_camera(model: mujoco.MjModel, camera: str | mujoco.MjvCamera | None) -> mujoco.MjvCamera:
    """A camera by name; None stands for the model's first one, or for a view of the whole model."""
    if isinstance(camera, mujoco.MjvCamera):
        return camera
    view = mujoco.MjvCamera()
    if camera is None and model.ncam == 0:
        mujoco.mjv_defaultFreeCamera(model, view)
        return view
    names = [model.camera(k).name for k in range(model.ncam)]
    if camera is not None and camera not in names:
        raise UnknownNameError("camera", camera, names)
    view.type = mujoco.mjtCamera.mjCAMERA_FIXED
    view.fixedcamid = 0 if camera is None else names.index(camera)
    return view


class Offscreen:
    """Offscreen buffer to draw a model on, to be closed after use (it is a context manager)."""

    def __init__(self, model: mujoco.MjModel, width: int, height: int) -> None:
        self._model = copy.copy(model)
        self._model.vis.global_.offwidth = width
        self._model.vis.global_.offheight = height
        self._gl = make_context(width, height)
        try:
            self._context = mujoco.MjrContext(self._model, mujoco.mjtFontScale.mjFONTSCALE_100)
        except mujoco.FatalError as error:
            self._gl.free()
            raise EngineError(f"MuJoCo cannot draw with this OpenGL: {error}") from error
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._scene = mujoco.MjvScene(self._model, _MAX_GEOMS)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0
        self._rect = mujoco.MjrRect(0, 0, width, height)
        self._image = np.empty((height, width, 3), np.uint8)
        self._depth = np.empty((height, width), np.float32)
        self._has_sky = bool((model.tex_type == mujoco.mjtTexture.mjTEXTURE_SKYBOX).any())

    @property
    def scene(self) -> mujoco.MjvScene:
        """The scene that was drawn last, with its camera."""
        return self._scene

    @property
    def depth(self) -> NDArray[np.float32]:
        """(height, width) depth of the picture that was drawn last, from 0 near to 1 far."""
        return self._depth[::-1].copy()

    def draw(
        self,
        data: mujoco.MjData,
        camera: mujoco.MjvCamera,
        add: Callable[[mujoco.MjvScene], None] = lambda scene: None,
        *,
        model: mujoco.MjModel | None = None,
        shadows: bool = True,
    ) -> Image:
        """Draw a (height, width, 3) picture; ``add`` puts more into the scene.

        ``model`` is the same model in other colours.
        """
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = shadows
        mujoco.mjv_updateScene(
            self._model if model is None else model,
            data,
            mujoco.MjvOption(),
            None,
            camera,
            mujoco.mjtCatBit.mjCAT_ALL.value,
            self._scene,
        )
        add(self._scene)
        self._gl.make_current()
        mujoco.mjr_render(self._rect, self._scene, self._context)
        mujoco.mjr_readPixels(self._image, self._depth, self._rect, self._context)
        if not self._has_sky:  # MuJoCo's own is black, and print is not
            self._image[self._depth == 1.0] = 255
        return self._image[::-1].copy()

    def close(self) -> None:
        """Free the graphics memory."""
        self._context.free()
        self._gl.free()

    def __enter__(self) -> Offscreen:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


def project(scene: mujoco.MjvScene, points: FloatArray, width: int, height: int) -> FloatArray:
    """(k, 2) columns and rows, from the upper left, of (k, 3) points [m] in a picture [pixels].

    The scene has a perspective camera; a point behind it gives NaN.
    """
    eye = scene.camera[0]
    forward, up = np.array(eye.forward, float), np.array(eye.up, float)
    # MuJoCo keeps two eyes and draws from between them
    away = points - np.mean([scene.camera[k].pos for k in (0, 1)], axis=0)
    depth = away @ forward
    depth = np.where(depth > 0.0, depth, np.nan)
    scale = 0.5 * height * eye.frustum_near / (0.5 * (eye.frustum_top - eye.frustum_bottom))
    right = np.cross(forward, up)
    columns = 0.5 * width + scale * (away @ right) / depth
    rows = 0.5 * height - scale * (away @ up) / depth
    return np.stack([columns, rows], axis=1)
