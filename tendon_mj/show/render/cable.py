"""Draws a tendon as a cable over its guides, each segment in the colour of its tension.

MuJoCo itself draws a spatial tendon in one colour and, in a scene, one width.
"""

from __future__ import annotations

import copy

import mujoco
import numpy as np
from matplotlib import colormaps
from matplotlib.colors import Normalize, to_rgba
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from tendon_mj.lab.replay import Cable
from tendon_mj.plugin import sheaths
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


def tension_scale(cables: dict[str, Cable]) -> Normalize:
    """Round limits [N] around all tensions, for colours."""
    tensions = np.concatenate([cable.tensions.ravel() for cable in cables.values()])
    low, high = float(tensions.min()), float(tensions.max())
    ticks = MaxNLocator(6, min_n_ticks=2).tick_values(low, max(high, low + 1e-3))
    return Normalize(max(0.0, ticks[0]), ticks[-1])


def cable_radius(model: mujoco.MjModel, cables: dict[str, Cable]) -> float:
    """Radius to draw cables with [m]: to be seen from afar, and thin enough to be told apart."""
    radius = _THICKNESS * float(model.stat.extent)
    starts = [cable.points[0] for cable in cables.values()]
    for k, one in enumerate(starts):
        for other in starts[:k]:
            gaps = np.linalg.norm(one[:, None] - other[None], axis=2)
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
    """Add one tendon to a scene.

    Args:
        scene: changed in place; geoms beyond its capacity ``maxgeom`` are left out.
        points: (n+2, 3) path [m].
        tensions: (n+1,) of the segments [N].
        scale: of the colours.
        radius: of the cable [m].
    """
    colours = COLOURS(scale(tensions)).astype(np.float32)
    for start, end, colour in zip(points[:-1], points[1:], colours, strict=True):
        geom = _new_geom(scene, mujoco.mjtGeom.mjGEOM_CAPSULE, start, radius, colour)
        if geom is not None:
            mujoco.mjv_connector(geom, mujoco.mjtGeom.mjGEOM_CAPSULE, radius, start, end)
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
