"""MuJoCo's interactive viewer with a simulation that runs, where there is a screen."""

from __future__ import annotations

import importlib
import os
import platform
import threading
import warnings
from typing import Any

import mujoco

from tendon_mj.errors import EngineError
from tendon_mj.show.live.colour_key import colour_key, key_height
from tendon_mj.show.live.curve_colours import curve_colours
from tendon_mj.show.live.first_view import FirstView
from tendon_mj.show.live.prepare import Prepared, tendon_names
from tendon_mj.show.live.real_time import RealTime, run_in_real_time
from tendon_mj.show.live.window_overlay import (
    MOST,
    curves_place,
    draw_curves,
    key_place,
    new_figure,
    tension_text,
)

_SPAN = 8.0  # of the curves [s]
_EVERY = 6  # frames for each that has new numbers and curves
_SPACE = 32  # key
_PATIENCE = 10.0  # with a window that closes [s]
_INSTEAD = (
    "`tendon-mj view MODEL --web` shows the same in a browser, and `tendon-mj render MODEL` writes "
    "a clip"
)


def open_window(prepared: Prepared, seconds: float | None = None) -> RealTime:
    """Show a simulation in MuJoCo's viewer, and come back when its window is closed.

    The space bar halts it.

    Args:
        prepared: what is shown.
        seconds: after which the window closes [s]; None: never.

    Raises:
        EngineError: there is no screen; the message says what does without.
        TendonError: the simulation became unstable.
    """
    linux = platform.system() == "Linux"
    if linux and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise EngineError(
            "there is no screen to open a window on (neither DISPLAY nor WAYLAND_DISPLAY is set); "
            f"{_INSTEAD}"
        )
    _check_screen()
    # not before it is asked for: it looks for a screen as it is imported
    viewer = importlib.import_module("mujoco.viewer")
    simulation = prepared.simulation

    def on_key(key: int) -> None:
        if key == _SPACE:
            simulation.paused = not simulation.paused

    others = set(threading.enumerate())
    try:
        window = viewer.launch_passive(
            simulation.model,
            simulation.data,
            key_callback=on_key,
            show_left_ui=False,
            show_right_ui=False,
        )
    except (RuntimeError, mujoco.FatalError) as error:
        raise EngineError(
            f"MuJoCo's viewer could not open a window: {error}; {_INSTEAD}"
        ) from error
    try:
        with window.lock():
            look_from(window.cam, simulation.model, prepared.view)
        overlay = _Overlay(prepared, window)
        return run_in_real_time(simulation, overlay.show, seconds)
    finally:
        window.close()
        for thread in set(threading.enumerate()) - others:  # it still draws; its end is not ours
            thread.join(_PATIENCE)


def _check_screen() -> None:
    """Refuse a screen that cannot be opened; the viewer would wait for it for ever.

    Raises:
        EngineError: it cannot.
    """
    glfw = importlib.import_module("glfw")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # GLFW's errors are warnings
        opened = glfw.init()
    if not opened:
        raise EngineError(f"the screen cannot be opened; {_INSTEAD}")


def look_from(camera: mujoco.MjvCamera, model: mujoco.MjModel, view: FirstView) -> None:
    """Give a camera that the mouse turns a view; the field of view is the model's."""
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.lookat[:] = view.look_at
    camera.distance, camera.azimuth = view.distance, view.azimuth
    camera.elevation = view.elevation
    model.vis.global_.fovy = view.fovy


class _Overlay:
    """Numbers, curves and colour bar in a window."""

    def __init__(self, prepared: Prepared, window: Any) -> None:
        self._simulation, self._window = prepared.simulation, window
        self._limits = prepared.low, prepared.high
        model = prepared.simulation.model
        self._tendons = list(tendon_names(model).values())
        self._colours = curve_colours(model)
        self._figure = new_figure(self._colours, prepared.high)
        self._frames, self._size = 0, (0, 0)

    def show(self) -> bool:
        """Show the simulation as it is now; return whether the window is still open."""
        if not self._window.is_running():
            return False
        if self._tendons and self._frames % _EVERY == 0:
            self._renew()
        self._frames += 1
        self._window.sync()
        return True

    def _renew(self) -> None:
        times, tensions = self._simulation.curves()
        draw_curves(self._figure, times, tensions, _SPAN)
        left, right = tension_text(self._tendons, tensions[-1], float(times[-1]))
        self._window.set_texts(
            (mujoco.mjtFontScale.mjFONTSCALE_150, mujoco.mjtGridPos.mjGRID_TOPLEFT, left, right)
        )
        viewport = self._window.viewport
        if viewport is None or viewport.width < 2:  # the window is not there yet
            return
        self._window.set_figures((curves_place(viewport), self._figure))
        if self._size != (viewport.width, viewport.height):
            self._size = viewport.width, viewport.height
            named = self._tendons[:MOST]
            place = key_place(viewport, key_height(len(named)))
            key = colour_key(self._limits, named, self._colours[:MOST], place.width, place.height)
            self._window.set_images((place, key))
