"""Colours of the tendons' curves: those of the tendons in the model, where these differ."""

from __future__ import annotations

import mujoco
import numpy as np

from tendon_mj.plugin import sheaths
from tendon_mj.typing import FloatArray

# from Okabe and Ito's palette, as in the figures
_PALETTE = ((0, 114, 178), (213, 94, 0), (0, 158, 115), (204, 121, 167), (230, 159, 0))
_PALER = 0.5  # share of white in the curve of the output


def curve_colours(model: mujoco.MjModel) -> FloatArray:
    """(sheaths, 2, 3) red, green and blue of the curves of input and output, 0 to 1.

    A model that gives its tendons no colours of their own gets those of a palette.
    """
    tendons = [model.tendon(found.tendon).id for found in sheaths(model).values()]
    own = model.tendon_rgba[tendons, :3].astype(float)
    if len(np.unique(own, axis=0)) < len(tendons) or not own.any():
        palette = np.array(_PALETTE) / 255.0
        own = palette[np.arange(len(tendons)) % len(palette)]
    return np.stack([own, (1.0 - _PALER) * own + _PALER], axis=1).reshape(-1, 2, 3)
