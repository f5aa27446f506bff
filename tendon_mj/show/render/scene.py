"""Draws tendons as cables over their guides, and the frictionless twin behind the model.

MuJoCo itself draws a spatial tendon in one colour and, in a scene, one width. The plugin draws a
running simulation whose model has a tension scale; recorded frames of any model are drawn here.
"""

from __future__ import annotations

import copy

import mujoco
import numpy as np
from matplotlib import colormaps
from matplotlib.colors import Normalize, to_rgba
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

from tendon_mj.lab.replay import POSE, Cable
from tendon_mj.plugin import sheaths
from tendon_mj.show.render.offscreen import Image, Offscreen
from tendon_mj.typing import FloatArray

# equal steps look equal, also to colour-blind eyes and in grey
COLOURS = colormaps["viridis"]
GUIDE_COLOUR = "#52575F"
_GUIDE = np.array(to_rgba(GUIDE_COLOUR), np.float32)
_THICKNESS = 0.006  # radius of a cable over the model's extent
_BEAD = 1.5  # radius of a guide over that of its cable
_EYE = np.eye(3).ravel()
# The colour is a reading: lit from within alone, whatever the scene's lights and shadows.
_SHADED = 1e-3  # of the colour that lights see

Depth = NDArray[np.float32]
GHOST_COLOUR = "#ADB0B5"  # as it looks on white
_GREY = (0.5, 0.52, 0.56)
_STRENGTH = 0.65  # of the ghost over its background


def colour_limits(cables: dict[str, Cable]) -> Normalize:
    """Round limits [N] around all finite tensions, for colours."""
    tensions = np.concatenate([cable.tensions.ravel() for cable in cables.values()])
    tensions = tensions[np.isfinite(tensions)]
    low, high = (float(tensions.min()), float(tensions.max())) if tensions.size else (0.0, 1.0)
    ticks = MaxNLocator(6, min_n_ticks=2).tick_values(low, max(high, low + 1e-3))
    return Normalize(max(0.0, float(ticks[0])), float(ticks[-1]))


def cable_radius(model: mujoco.MjModel, cables: dict[str, Cable]) -> float:
    """Radius of drawn cables [m]: visible from afar, and less than the gaps between cables."""
    radius = _THICKNESS * float(model.stat.extent)
    starts = [cable.points[0] for cable in cables.values()]
    for k, points in enumerate(starts):
        for other in starts[:k]:
            gaps = np.linalg.norm(points[:, None] - other[None], axis=2)
            if gaps[gaps > 0.0].size:
                radius = min(radius, 0.3 * float(gaps[gaps > 0.0].min()))
    return radius


def without_tendons(model: mujoco.MjModel) -> mujoco.MjModel:
    """A copy to draw, on which sheathed tendons and the sites on their paths are invisible."""
    bare = copy.copy(model)
    for sheath in sheaths(model).values():
        tendon = model.tendon(sheath.tendon).id
        start, count = model.tendon_adr[tendon], model.tendon_num[tendon]
        path = slice(start, start + count)
        sites = model.wrap_type[path] == mujoco.mjtWrap.mjWRAP_SITE.value  # not geoms, pulleys
        bare.tendon_rgba[tendon, 3] = 0.0
        bare.site_rgba[model.wrap_objid[path][sites], 3] = 0.0
    return bare


def add_cable(
    scene: mujoco.MjvScene,
    points: FloatArray,
    tensions: FloatArray,
    scale: Normalize,
    radius: float,
) -> None:
    """Add a tendon with an (n+2, 3) path [m] and (n+1,) tensions [N] to a scene, as it has room."""
    capsule = mujoco.mjtGeom.mjGEOM_CAPSULE
    colours = COLOURS(scale(tensions)).astype(np.float32)
    for start, end, colour in zip(points[:-1], points[1:], colours, strict=True):
        geom = _new_geom(scene, capsule, start, radius, colour)
        if geom is not None:
            mujoco.mjv_connector(geom, capsule, radius, start, end)
    for guide in points[1:-1]:
        _new_geom(scene, mujoco.mjtGeom.mjGEOM_SPHERE, guide, _BEAD * radius, _GUIDE)


def _new_geom(
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
        self._ghost.geom_rgba[:, :3] = _GREY
        self._ghost.geom_rgba[~moves, 3] = 0.0
        self._ghost.site_rgba[:, 3] = self._ghost.tendon_rgba[:, 3] = 0.0
        self._data = mujoco.MjData(self._ghost)
        mujoco.mj_fwdPosition(model, self._data)
        offscreen.draw(self._data, camera, model=background, shadows=False)
        self._background = offscreen.depth

    def behind(self, image: Image, depth: Depth, pose: FloatArray) -> Image:
        """A picture, of that (height, width) depth, with the twin in ``pose`` behind the model."""
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
    shown = (twin < background) & ~binary_dilation(whole != background)
    edge = shown & binary_dilation(twin >= 1.0)
    blended = image.astype(float)
    blended[shown] = (1.0 - _STRENGTH) * blended[shown] + _STRENGTH * ghost[shown]
    blended[edge] = 0.45 * blended[edge]
    return np.asarray(blended.round(), np.uint8)
