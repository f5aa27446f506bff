"""Limits of the colours: tensions between which a model's tendons are, found by a short run."""

from __future__ import annotations

import mujoco
import numpy as np
from matplotlib.ticker import MaxNLocator

from tendon_mj.lab.replay import Drive, record_frames

_FPS = 20.0  # of the run [1/s]


def tension_limits(model: mujoco.MjModel, drive: Drive, duration: float) -> tuple[float, float]:
    """Round limits around all tensions of a run of that duration [s].

    Args:
        model: with sheaths; not changed.
        drive: time [s] → (nu,) controls.
        duration: [s].

    Returns:
        Tensions at the ends of the colour bar [N].

    Raises:
        TendonError: the simulation became unstable.
    """
    frames = record_frames(model, drive, duration=duration, fps=_FPS)
    tensions = np.concatenate([cable.tensions.ravel() for cable in frames.cables.values()])
    tensions = tensions[np.isfinite(tensions)]
    low, high = (float(tensions.min()), float(tensions.max())) if tensions.size else (0.0, 1.0)
    ticks = MaxNLocator(6, min_n_ticks=2).tick_values(low, max(high, low + 1e-3))
    return max(0.0, float(ticks[0])), float(ticks[-1])
