"""Whether there is something to draw with, and scripts without a screen or on another one."""

import os
import subprocess
import sys

import mujoco

from tendon_mj.errors import EngineError
from tendon_mj.show import Offscreen


def can_draw():
    """Whether this machine has an OpenGL to draw with."""
    try:
        with Offscreen(mujoco.MjModel.from_xml_string("<mujoco/>"), 64, 64):
            return True
    except EngineError:
        return False


def run_without_screen(script, *arguments, screen=()):
    """Run a script, warnings shown, without a screen or by a command that brings one."""
    kept = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    command = [*screen, sys.executable, "-W", "default", "-c", script, *arguments]
    return subprocess.run(command, env=kept, capture_output=True, text=True, check=False)
