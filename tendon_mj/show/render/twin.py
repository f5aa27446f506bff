"""The frictionless twin of a motion, drawn as a grey ghost behind the model.

A ghost in the scene itself would tint the tendons that it passes. So it is drawn alone, and shows
only where the moving bodies of the model and its tendons leave the background free.
"""

from __future__ import annotations

import copy

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.show.render.offscreen import Image, Offscreen
from tendon_mj.typing import FloatArray

Depth = NDArray[np.float32]
GHOST_COLOUR = "#ADB0B5"  # as it looks on white
_GREY = (0.5, 0.52, 0.56)
_STRENGTH = 0.65  # of the ghost over its background


def ghost_of(model: mujoco.MjModel) -> mujoco.MjModel:
    """A copy to draw: what moves is grey, all else invisible."""
    ghost = copy.copy(model)
    moves = _moving(model)
    ghost.geom_matid[:] = -1
    ghost.geom_rgba[:, :3] = _GREY
    ghost.geom_rgba[~moves, 3] = 0.0
    ghost.site_rgba[:, 3] = 0.0
    ghost.tendon_rgba[:, 3] = 0.0
    return ghost


def background_of(model: mujoco.MjModel) -> mujoco.MjModel:
    """A copy to draw: only what does not move."""
    background = copy.copy(model)
    background.geom_rgba[_moving(model), 3] = 0.0
    return background


def _moving(model: mujoco.MjModel) -> np.ndarray:
    moves: np.ndarray = model.body_weldid[model.geom_bodyid] != 0
    return moves


def blend(image: Image, ghost: Image, depths: tuple[Depth, Depth, Depth]) -> Image:
    """Lay a ghost behind what moves in a picture.

    Args:
        image: (height, width, 3) of the model.
        ghost: (height, width, 3) of the twin alone.
        depths: (height, width) of the model, of the twin and of the background.
    """
    whole, twin, background = depths
    # a pixel of an edge has colour of both sides, and the depth of one
    shown = (twin < background) & ~_grown(whole != background)
    edge = shown & _grown(twin >= 1.0)
    blended = image.astype(float)
    blended[shown] = (1.0 - _STRENGTH) * blended[shown] + _STRENGTH * ghost[shown]
    blended[edge] = 0.45 * blended[edge]
    return np.asarray(blended.round(), np.uint8)


def _grown(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """A mask with the pixels around it."""
    grown = mask.copy()
    grown[1:] |= mask[:-1]
    grown[:-1] |= mask[1:]
    grown[:, 1:] |= mask[:, :-1]
    grown[:, :-1] |= mask[:, 1:]
    return grown


class Ghost:
    """Draws the twin with the offscreen buffer of the model.

    Args:
        model: as it is drawn.
        offscreen: of the model.
        camera: that looks at it; it does not move.
    """

    def __init__(
        self, model: mujoco.MjModel, offscreen: Offscreen, camera: mujoco.MjvCamera
    ) -> None:
        self._offscreen, self._camera, self._ghost = offscreen, camera, ghost_of(model)
        self._data = mujoco.MjData(self._ghost)
        mujoco.mj_fwdPosition(model, self._data)
        offscreen.draw(self._data, camera, model=background_of(model), shadows=False)
        self._background = offscreen.depth

    def behind(self, image: Image, depth: Depth, pose: FloatArray, kind: mujoco.mjtState) -> Image:
        """A picture, of that (height, width) depth, with the twin in ``pose`` behind the model."""
        mujoco.mj_setState(self._ghost, self._data, pose, kind)
        mujoco.mj_fwdPosition(self._ghost, self._data)
        ghost = self._offscreen.draw(self._data, self._camera, model=self._ghost, shadows=False)
        return blend(image, ghost, (depth, self._offscreen.depth, self._background))
