"""OpenGL contexts without a screen, or an error that says what is missing.

MuJoCo settles on a platform when it is imported, on GLFW unless `MUJOCO_GL` says otherwise, and
that one needs a screen. The choice here is made when something is first drawn, so the variable
need not be set at all.
"""

from __future__ import annotations

import importlib
import os
import platform
import warnings
from typing import Any

from tendon_mj.errors import EngineError, unknown

_OFF = ("disable", "disabled", "off", "false", "0")
_ANY = ("", "enable", "enabled", "on", "true", "1")
_MODULES = {
    "egl": "mujoco.egl",
    "osmesa": "mujoco.osmesa",
    "glfw": "mujoco.glfw",
    "glx": "mujoco.glfw",
    "wgl": "mujoco.glfw",
    "cgl": "mujoco.cgl",
}
_EGL = (
    "EGL draws without a screen: install libEGL and libGL (Debian, Ubuntu: apt install libegl1 "
    "libgl1; NVIDIA's driver brings its own)"
)
_OSMESA = (
    "OSMesa draws on the processor alone: install it (Debian: apt install libosmesa6) and set "
    "MUJOCO_GL=osmesa before Python starts"
)
_HINTS = {
    "egl": f"{_EGL}; or {_OSMESA}",
    "osmesa": f"{_OSMESA}; or unset MUJOCO_GL: {_EGL}",
    "glfw": "GLFW needs a screen (DISPLAY or WAYLAND_DISPLAY); unset MUJOCO_GL or set it to egl: "
    f"{_EGL}",
    "cgl": "CGL needs macOS; unset MUJOCO_GL",
}


def gl_platforms() -> tuple[str, ...]:
    """Platforms to try in turn: the one in `MUJOCO_GL`, else whatever can do without a screen.

    Raises:
        EngineError: `MUJOCO_GL` turns drawing off, or names no platform.
    """
    asked = os.environ.get("MUJOCO_GL", "").lower().strip()
    if asked in _MODULES:
        return (asked,)
    if asked in _OFF:
        raise EngineError(f"MUJOCO_GL={asked} turns drawing off; unset it or set it to egl")
    if asked not in _ANY:
        raise EngineError(f"MUJOCO_GL: {unknown('OpenGL platform', asked, _MODULES)}")
    if platform.system() == "Darwin":
        return ("cgl", "glfw")
    screen = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if platform.system() == "Windows":
        return ("glfw",)
    # no OSMesa after EGL: PyOpenGL binds to one platform for the life of the process
    return ("glfw", "egl") if screen else ("egl",)


def make_context(width: int, height: int) -> Any:
    """Make an OpenGL context for pictures of that size [pixels], and make it current.

    Returns:
        An object with ``make_current()`` and ``free()``.

    Raises:
        EngineError: there is none to be had; the message says what to install or set.
    """
    failures = []
    for name in gl_platforms():
        try:
            return _make(_MODULES[name], width, height)
        except Exception as error:  # each platform has failures of its own kind
            failures.append(f"{name} ({_reason(error)})")
    hint = _HINTS.get(name, _HINTS["glfw"])
    raise EngineError(f"no OpenGL to draw with, tried {', '.join(failures)}. {hint}")


def _make(module: str, width: int, height: int) -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # GLFW warns, and goes on without a window
        kind = importlib.import_module(module).GLContext
        context = kind.__new__(kind)
        context._context = None  # so that one which fails half-way can be freed
        context.__init__(width, height)
        context.make_current()
    return context


def _reason(error: Exception) -> str:
    try:
        text = " ".join(str(error).split())
    except Exception:  # PyOpenGL's errors ask the context that is missing
        text = ""
    if isinstance(error, AttributeError) and "NoneType" in text:
        return "its library was not found"  # PyOpenGL has None in its place
    return f"{type(error).__name__}: {text}" if text else type(error).__name__
