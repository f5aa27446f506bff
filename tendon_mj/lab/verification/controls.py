"""Controls that keep any model moving."""

from __future__ import annotations

import mujoco
import numpy as np

from tendon_mj.typing import FloatArray

_WAVES = 3  # sines in the control of an actuator
_FREQUENCIES = (0.2, 1.5)  # among which these are drawn [Hz]


def smooth_controls(
    model: mujoco.MjModel, steps: int, seed: int = 0, amplitude: float = 1.0
) -> FloatArray:
    """(steps, nu) sums of sines within the control ranges; ±1 where an actuator has none.

    Args:
        model: compiled.
        steps: of the model's own length.
        seed: of frequencies and phases.
        amplitude: over half the range, around its middle.
    """
    random = np.random.default_rng(seed)
    time = model.opt.timestep * np.arange(steps)
    shape = (model.nu, _WAVES)
    phase, rate = random.uniform(0.0, 2.0 * np.pi, shape), random.uniform(*_FREQUENCIES, shape)
    share = np.sin(2.0 * np.pi * rate * time[:, None, None] + phase).mean(axis=-1)
    limited = model.actuator_ctrllimited.astype(bool)
    low, high = model.actuator_ctrlrange.T
    centre = np.where(limited, 0.5 * (low + high), 0.0)
    half = np.where(limited, 0.5 * (high - low), 1.0)
    return np.asarray(centre + half * amplitude * share)
