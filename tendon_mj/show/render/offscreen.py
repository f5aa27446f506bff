"""Draws a model's scene into an array, without a window: cables over guides, a twin behind.

MuJoCo chooses an OpenGL platform when it is imported: GLFW, which needs a screen, unless
`MUJOCO_GL` says otherwise. The choice here is made when something is first drawn, so the variable
need not be set.

MuJoCo itself draws a spatial tendon in one colour and, in a scene, one width. The plugin draws a
running simulation whose model has a tension scale; recorded frames of any model are drawn here.
"""

from __future__ import annotations

import contextlib
import copy
import importlib
import itertools
import os
import platform
import warnings
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import mujoco
import numpy as np
import scipy
from matplotlib import colormaps
from matplotlib.colors import Normalize, to_rgb, to_rgba
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from tendon_mj.errors import EngineError, UnknownNameError
from tendon_mj.lab.frames import POSE, Cable
from tendon_mj.plugin import MARK, sheaths
from tendon_mj.show.render.surroundings import add_floor, first_camera, floor, framing
from tendon_mj.typing import FloatArray

Image = NDArray[np.uint8]
_MAX_GEOMS = 20000
_TURNED_OFF = ("disable", "disabled", "off", "false", "0")
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
# equal steps look equal, also to colour-blind eyes and in grey
COLOURS = colormaps["viridis"]
GUIDE_COLOUR = "#52575F"
_GUIDE = np.array(to_rgba(GUIDE_COLOUR), np.float32)
_THICKNESS = 0.006  # radius of a cable over the size of all cables
_THINNEST = 0.0012  # likewise in a crowd: a pixel or two
_WALL = 0.99  # distance of the backdrop over the farthest that is drawn
_EYE = np.eye(3).ravel()
# The colour is a reading: lit from within alone, whatever the scene's lights and shadows.
_SHADED = 1e-3  # of the colour that lights see

Depth = NDArray[np.float32]
GREY = (0.5, 0.52, 0.56)  # of a ghost
_PALE, _THIN = 0.3, 0.5  # opacity, and width over its own, of a tendon that is not shown
_STRENGTH = 0.65  # of the ghost over its background


def gl_platforms() -> tuple[str, ...]:
    """Platforms to try in turn: the one in `MUJOCO_GL`, else those that can do without a screen."""
    chosen = os.environ.get("MUJOCO_GL", "").lower().strip()
    if chosen in _MODULES:
        return (chosen,)
    if chosen in _TURNED_OFF:
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
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def find_camera(
    model: mujoco.MjModel,
    camera: str | mujoco.MjvCamera | None,
    poses: FloatArray | None = None,
) -> mujoco.MjvCamera:
    """A camera by name; None: the first that shows the tendons, or one that frames them.

    They are looked at in (k, nq) ``poses``, by default in `qpos0`.
    """
    if isinstance(camera, mujoco.MjvCamera):
        return camera
    view, first = mujoco.MjvCamera(), first_camera(model, poses) if camera is None else 0
    if first < 0:
        return framing(model, poses)
    names = [model.camera(k).name for k in range(model.ncam)]
    if camera is not None and camera not in names:
        raise UnknownNameError("camera", camera, names)
    view.type = mujoco.mjtCamera.mjCAMERA_FIXED
    view.fixedcamid = first if camera is None else names.index(camera)
    return view


class Offscreen(contextlib.AbstractContextManager["Offscreen"]):
    """Offscreen buffer to draw a model on, to be closed after use (it is a context manager).

    A model without a floor gets one below (k, nq) ``poses``, unless ``ground`` is False.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        width: int,
        height: int,
        background: str = "",
        *,
        ground: bool = True,
        poses: FloatArray | None = None,
    ) -> None:
        self._model, self._floor = copy.copy(model), floor(model, poses) if ground else None
        sky = model.tex_type == mujoco.mjtTexture.mjTEXTURE_SKYBOX
        self._has_sky = bool(sky.any())
        self._background = np.round(255.0 * np.array(to_rgb(background or "white")))
        if background:  # edges are blended with it
            for k in np.flatnonzero(sky):
                count = 3 * model.tex_height[k] * model.tex_width[k]
                start = model.tex_adr[k]
                self._model.tex_data[start : start + count] = np.tile(
                    self._background.astype(np.uint8), count // 3
                )
        self._model.vis.global_.offwidth = width
        self._model.vis.global_.offheight = height
        self._gl = make_context(width, height)
        try:
            self._context = mujoco.MjrContext(self._model, mujoco.mjtFontScale.mjFONTSCALE_150)
        except mujoco.FatalError as error:
            self._gl.free()
            raise EngineError(f"MuJoCo cannot draw with this OpenGL: {error}") from error
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self.scene = mujoco.MjvScene(self._model, _MAX_GEOMS)  # that was drawn last
        self.scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0
        self._rect = mujoco.MjrRect(0, 0, width, height)
        self._image = np.empty((height, width, 3), np.uint8)
        self._depth = np.empty((height, width), np.float32)

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
        self.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = shadows
        mujoco.mjv_updateScene(
            self._model if model is None else model,
            data,
            mujoco.MjvOption(),
            None,
            camera,
            mujoco.mjtCatBit.mjCAT_ALL.value,
            self.scene,
        )
        add_floor(self.scene, self._floor)
        add(self.scene)
        if not self._has_sky:  # MuJoCo's own is black, and print is not
            self._add_backdrop()
        self._gl.make_current()
        mujoco.mjr_render(self._rect, self.scene, self._context)
        mujoco.mjr_readPixels(self._image, self._depth, self._rect, self._context)
        return self._image[::-1].copy()

    def _add_backdrop(self) -> None:
        """Add a wall in the background's colour behind all else, seen through what is translucent.

        It is a decoration, which casts no shadow.
        """
        eye = self.scene.camera[0]
        forward, up = np.array(eye.forward, float), np.array(eye.up, float)
        far = float(eye.frustum_far)
        middle = _eye(self.scene) + _WALL * far * forward
        colour = np.append(self._background / 255.0, 1.0).astype(np.float32)
        wall = _next_geom(self.scene, mujoco.mjtGeom.mjGEOM_BOX, middle, far, colour)
        if wall is not None:
            wall.size[:] = 2.0 * far, 2.0 * far, 1e-6 * far
            wall.mat[:] = np.stack([np.cross(forward, up), up, -forward], axis=1)

    def close(self) -> None:
        """Free the graphics memory."""
        self._context.free()
        self._gl.free()

    def __exit__(self, *error: object) -> None:
        self.close()


def project(scene: mujoco.MjvScene, points: FloatArray, width: int, height: int) -> FloatArray:
    """(k, 2) columns and rows, from the upper left, of (k, 3) points [m] in a picture [pixels].

    The scene has a perspective camera; a point behind it gives NaN.
    """
    eye = scene.camera[0]
    forward, up = np.array(eye.forward, float), np.array(eye.up, float)
    away = points - _eye(scene)
    depth = away @ forward
    depth = np.where(depth > 0.0, depth, np.nan)
    scale = 0.5 * height * eye.frustum_near / (0.5 * (eye.frustum_top - eye.frustum_bottom))
    right = np.cross(forward, up)
    columns = 0.5 * width + scale * (away @ right) / depth
    rows = 0.5 * height - scale * (away @ up) / depth
    return np.stack([columns, rows], axis=1)


def _eye(scene: mujoco.MjvScene) -> FloatArray:
    """Place that a scene is drawn from [m]: MuJoCo keeps two eyes and draws from between them."""
    return np.asarray(np.mean([scene.camera[k].pos for k in (0, 1)], axis=0))


def without_spikes(values: FloatArray) -> float:
    """Largest of the values, or of 99 % of them where the others are more than twice as large."""
    largest, of_most = float(values.max()), float(np.quantile(values, 0.99))
    return of_most if largest > 2.0 * of_most > 0.0 else largest


def colour_limits(cables: dict[str, Cable]) -> Normalize:
    """Round limits [N] around all finite tensions but those of `without_spikes`, for colours."""
    tensions = np.concatenate([cable.tensions.ravel() for cable in cables.values()])
    tensions = tensions[np.isfinite(tensions)]
    low, high = 0.0, 1.0
    if tensions.size:
        low, high = float(tensions.min()), without_spikes(tensions)
    ticks = MaxNLocator(6, min_n_ticks=2).tick_values(low, max(high, low + 1e-3))
    return Normalize(max(0.0, float(ticks[0])), float(ticks[-1]))


def cables_size(model: mujoco.MjModel, cables: Mapping[str, Cable]) -> float:
    """Size of all cables at first, or the model's extent if that is less or there are none [m].

    A wide floor makes the extent of a model.
    """
    extent, starts = float(model.stat.extent), [cable.points[0] for cable in cables.values()]
    if not starts:
        return extent
    return min(extent, float(np.linalg.norm(np.ptp(np.concatenate(starts), axis=0))))


def cable_radius(model: mujoco.MjModel, cables: Mapping[str, Cable]) -> float:
    """Radius of drawn cables [m]: visible from afar, and less than most gaps between cables."""
    size = cables_size(model, cables)
    radius, starts = _THICKNESS * size, [cable.points[0] for cable in cables.values()]
    for points, other in itertools.combinations(starts, 2):
        gaps = np.linalg.norm(points[:, None] - other[None], axis=2)
        radius = min(radius, 0.3 * float(gaps[gaps > 0.0].min(initial=np.inf)))
    return max(radius, _THINNEST * size)


def without_tendons(model: mujoco.MjModel, names: Iterable[str] | None = None) -> mujoco.MjModel:
    """A copy to draw, on which tendons in these sheaths and the sites on their paths are invisible.

    By default those of all sheaths are; those of the others are thin and pale.
    """
    bare, known = copy.copy(model), sheaths(model)
    chosen = set(known if names is None else names)
    for name, sheath in known.items():
        tendon = model.tendon(sheath.tendon).id
        start, count = model.tendon_adr[tendon], model.tendon_num[tendon]
        path = slice(start, start + count)
        sites = model.wrap_type[path] == mujoco.mjtWrap.mjWRAP_SITE.value  # not geoms, pulleys
        bare.tendon_rgba[tendon] = (*GREY, 0.0 if name in chosen else _PALE)
        bare.tendon_width[tendon] *= _THIN
        bare.site_rgba[model.wrap_objid[path][sites], 3] = 0.0
    return bare


def cables_at(
    cables: Mapping[str, Cable], frame: int, scale: Normalize, radius: float
) -> Callable[[mujoco.MjvScene], None]:
    """Function that adds all tendons as they are in a frame to a scene, for `Offscreen.draw`."""

    def add(scene: mujoco.MjvScene) -> None:
        for cable in cables.values():
            add_cable(scene, cable.points[frame], cable.tensions[frame], scale, radius)

    return add


def add_cable(
    scene: mujoco.MjvScene,
    points: FloatArray,
    tensions: FloatArray,
    scale: Normalize,
    radius: float,
) -> None:
    """Add a tendon with an (m+1, 3) path [m] and (m,) tensions [N] to a scene, as it has room."""
    capsule = mujoco.mjtGeom.mjGEOM_CAPSULE
    colours = COLOURS(scale(tensions)).astype(np.float32)
    for start, end, colour in zip(points[:-1], points[1:], colours, strict=True):
        if colour[3] == 0.0:  # between two branches
            continue
        geom = _next_geom(scene, capsule, start, radius, colour)
        if geom is not None:
            mujoco.mjv_connector(geom, capsule, radius, start, end)
    for guide in points[1:-1]:
        if not (guide == points[[0, -1]]).all(axis=1).any():  # which are not guides
            _next_geom(scene, mujoco.mjtGeom.mjGEOM_SPHERE, guide, MARK * radius, _GUIDE)


def _next_geom(
    scene: mujoco.MjvScene,
    kind: mujoco.mjtGeom,
    where: FloatArray,
    radius: float,
    colour: NDArray[np.float32],
) -> mujoco.MjvGeom | None:
    if scene.ngeom >= scene.maxgeom:
        return None
    geom = scene.geoms[scene.ngeom]
    dimmed = colour * np.array([_SHADED, _SHADED, _SHADED, 1.0], np.float32)
    mujoco.mjv_initGeom(geom, kind, np.full(3, radius), where, _EYE, dimmed)
    geom.emission, geom.specular = 1.0 / _SHADED, 0.0
    scene.ngeom += 1
    return geom


class Ghost:
    """The frictionless twin of a motion, drawn as a grey ghost behind the model.

    A ghost in the scene itself would tint the tendons that it passes. So it is drawn alone, on the
    offscreen buffer of the model, and shows only where the moving bodies of the model and its
    tendons leave the background free. The camera does not move.
    """

    def __init__(
        self, model: mujoco.MjModel, offscreen: Offscreen, camera: mujoco.MjvCamera
    ) -> None:
        self._offscreen, self._camera = offscreen, camera
        moves = model.body_weldid[model.geom_bodyid] != 0
        background, self._ghost = copy.copy(model), copy.copy(model)
        background.geom_rgba[moves, 3] = 0.0
        self._ghost.geom_matid[:] = -1
        self._ghost.geom_rgba[:, :3] = GREY
        self._ghost.geom_rgba[:, 3] = (self._ghost.geom_rgba[:, 3] > 0.0) & moves
        self._ghost.site_rgba[:, 3] = self._ghost.tendon_rgba[:, 3] = 0.0
        self._data = mujoco.MjData(self._ghost)
        mujoco.mj_fwdPosition(model, self._data)
        offscreen.draw(self._data, camera, model=background, shadows=False)
        self._background = offscreen.depth

    def behind(self, image: Image, pose: FloatArray) -> Image:
        """The picture that was drawn last, with the twin in ``pose`` behind the model."""
        depth = self._offscreen.depth
        mujoco.mj_setState(self._ghost, self._data, pose, POSE)
        mujoco.mj_fwdPosition(self._ghost, self._data)
        ghost = self._offscreen.draw(self._data, self._camera, model=self._ghost, shadows=False)
        return blend(image, ghost, (depth, self._offscreen.depth, self._background))


def blend(image: Image, ghost: Image, depths: tuple[Depth, Depth, Depth]) -> Image:
    """Lay the ghost of a twin behind the moving bodies of a picture.

    The (height, width) depths are of the model, of the twin alone and of the background.
    """
    whole, twin, background = depths
    # a pixel of an edge has colour of both sides, and the depth of one
    shown = (twin < background) & ~scipy.ndimage.binary_dilation(whole != background)
    edge = shown & scipy.ndimage.binary_dilation(twin >= background)
    blended = image.astype(float)
    blended[shown] = (1.0 - _STRENGTH) * blended[shown] + _STRENGTH * ghost[shown]
    blended[edge] = 0.45 * blended[edge]
    return np.asarray(blended.round(), np.uint8)
