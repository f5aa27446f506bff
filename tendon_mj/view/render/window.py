"""MuJoCo's interactive viewer, where there is a screen."""

from __future__ import annotations

import importlib
import os
import platform

import mujoco

from tendon_mj.errors import EngineError


def open_window(model: mujoco.MjModel) -> None:
    """Show a model in MuJoCo's viewer, and come back when its window is closed.

    Raises:
        EngineError: there is no screen; the message says what does without.
    """
    linux = platform.system() == "Linux"
    if linux and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise EngineError(
            "there is no screen to open a window on (neither DISPLAY nor WAYLAND_DISPLAY is set); "
            "`tendon-mj render MODEL` writes a clip without one"
        )
    # not before it is asked for: it looks for a screen as it is imported
    viewer = importlib.import_module("mujoco.viewer")
    try:
        viewer.launch(model)
    except (RuntimeError, mujoco.FatalError) as error:
        raise EngineError(f"MuJoCo's viewer could not open a window: {error}") from error
