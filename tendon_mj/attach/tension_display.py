"""Switches the drawing of tensions on in a model: in every viewer, renderer and clip."""

from __future__ import annotations

import mujoco

from tendon_mj.plugin import TENSION_SCALE, check_limits


def show_tension(spec: mujoco.MjSpec, low: float, high: float) -> mujoco.MjSpec:
    """Let MuJoCo draw every sheathed tendon of a model in the colours of its tension.

    It writes the custom numeric `tendon_mj.tension_scale`, or other numbers into the one that is
    there. A compiled model takes new ones live, in `model.numeric(…).data`.

    Args:
        spec: changed in place.
        low, high: tensions at the ends of the colour bar, from dark blue to yellow [N].

    Returns:
        ``spec``.

    Raises:
        InvalidValueError: not two finite tensions, the lower one first.
    """
    check_limits(low, high)
    numeric = spec.numeric(TENSION_SCALE) or spec.add_numeric(name=TENSION_SCALE)
    numeric.size, numeric.data = 2, [low, high]
    return spec
