"""`tendon-mj library`: the plugins for programs without Python."""

from __future__ import annotations

from pathlib import Path

from tendon_mj.cli.output import console
from tendon_mj.plugin import export_library


def library(out: Path = Path("mujoco_plugin")) -> Path:
    """Write the library of the plugins, and a header of their attributes, for C, C++ and ROS 2.

    Args:
        out: folder for libtendon_mj.so (.dylib on macOS) and tendon_mj.h; `simulate` and others
            load the libraries of a folder mujoco_plugin beside their executable.

    Example:
        tendon-mj library --out mujoco_plugin
    """
    written = export_library(out)
    console.print(f"{written} for MuJoCo 3.11 to 4.0, and {written.with_name('tendon_mj.h')}")
    return written
