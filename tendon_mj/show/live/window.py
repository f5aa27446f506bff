"""MuJoCo's interactive viewer with a running simulation, if there is a screen."""

from __future__ import annotations

import importlib
import os
import platform
import threading
import warnings
from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np

from tendon_mj.errors import EngineError
from tendon_mj.lab.units import NEWTON, EngineeringUnit
from tendon_mj.show.live.scene import (
    MOST_TENDONS,
    colour_key,
    curve_colours,
    key_height,
    look_from,
    tension_text,
)
from tendon_mj.show.live.session import Prepared, RealTime, kept_state, run_in_real_time
from tendon_mj.show.render.surroundings import add_floor, floor, to_show
from tendon_mj.show.style import labelled
from tendon_mj.typing import FloatArray

_CURVES_SPAN = 8.0  # of the curves [s]
_NUMBERS_EVERY = 6  # frames between new numbers and curves
_SPACE = 32  # key
_CLOSING = 10.0  # with a window that closes [s]
_POINTS = 1000  # of a curve, as many as `mjvFigure` takes
_TAKEN = 0.42, 0.34  # of the window's width and height that the curves take
_KEY_PIXELS = 420  # width of the key of colours [pixels]
_EDGE = 10  # [pixels]
_INSTEAD = (
    "`tendon-mj view MODEL --web` shows the same in a browser, and `tendon-mj render MODEL` writes "
    "a clip"
)


def open_window(prepared: Prepared, seconds: float | None = None) -> RealTime:
    """Show a simulation in MuJoCo's viewer, and return when its window is closed.

    The space bar halts it.
    """
    simulation = prepared.simulation

    def on_key(key: int) -> None:
        if key == _SPACE:
            simulation.paused = not simulation.paused

    shown = to_show(simulation.model)
    with kept_state(simulation.model, simulation.data):  # the viewer evaluates the model
        viewer = Viewer(shown, simulation.data, _INSTEAD, on_key)
    window = viewer.handle
    try:
        with window.lock():
            look_from(window.cam, shown, prepared.view)
            add_floor(window.user_scn, floor(shown, prepared.poses))
            window.opt.tendongroup[:] = 1
        return run_in_real_time(simulation, _Overlay(prepared, window).show, seconds)
    finally:
        viewer.close()


class Viewer:
    """MuJoCo's viewer beside a program, without its panels.

    Args:
        model, data: to show.
        instead: what to do if there is no screen, the end of a message.
        on_key: called with the number of a key that is pressed.

    Raises:
        EngineError: no window can be opened.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        instead: str,
        on_key: Callable[[int], None] | None = None,
    ) -> None:
        check_screen(instead)
        viewer = importlib.import_module("mujoco.viewer")  # which looks for a screen on import
        others = set(threading.enumerate())
        try:
            self.handle = viewer.launch_passive(
                model, data, key_callback=on_key, show_left_ui=False, show_right_ui=False
            )
        except (RuntimeError, mujoco.FatalError) as error:
            raise EngineError(
                f"MuJoCo's viewer could not open a window: {error}; {instead}"
            ) from error
        self._threads = set(threading.enumerate()) - others

    def close(self) -> None:
        """Close the window."""
        self.handle.close()
        for thread in self._threads:  # the viewer's, which still draws
            thread.join(_CLOSING)


def check_screen(instead: str) -> None:
    """Raise `EngineError` for a screen that cannot be opened; the viewer would wait forever.

    The message ends with what to do ``instead``.
    """
    linux = platform.system() == "Linux"
    if linux and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise EngineError(
            "there is no screen to open a window on (neither DISPLAY nor WAYLAND_DISPLAY is set); "
            f"{instead}"
        )
    glfw = importlib.import_module("glfw")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # GLFW's errors are warnings
        if not glfw.init():
            raise EngineError(f"the screen cannot be opened; {instead}")


class _Overlay:
    """Numbers, curves and colour bar in a window."""

    def __init__(self, prepared: Prepared, window: Any) -> None:
        self._simulation, self._window = prepared.simulation, window
        self._limits, self._slips = (prepared.low, prepared.high), prepared.simulation.can_slip
        self._tendons = list(prepared.simulation.tendons.values())
        self._colours = curve_colours(prepared.simulation.model, [*prepared.simulation.tendons])
        self._unit = prepared.force_unit
        self._figure = new_curves(self._colours, prepared.high or 1.0, self._unit)
        self._frames, self._size = 0, (0, 0)

    def show(self) -> bool:
        """Show the simulation as it is now; return whether the window is still open."""
        if not self._window.is_running():
            return False
        if self._tendons and self._frames % _NUMBERS_EVERY == 0:
            self._renew()
        self._frames += 1
        self._window.sync()
        return True

    def _renew(self) -> None:
        times, tensions = self._simulation.curves()
        draw_curves(self._figure, times, self._unit.factor * tensions, _CURVES_SPAN)
        left, right = tension_text(self._tendons, tensions[-1], float(times[-1]), self._unit)
        self._window.set_texts(
            (mujoco.mjtFontScale.mjFONTSCALE_150, mujoco.mjtGridPos.mjGRID_TOPLEFT, left, right)
        )
        viewport = self._window.viewport
        if viewport is None or viewport.width < 2:  # the window is not there yet
            return
        self._window.set_figures((curves_place(viewport), self._figure))
        if self._size != (viewport.width, viewport.height):
            self._size = viewport.width, viewport.height
            named = self._tendons[:MOST_TENDONS]
            high = key_height(len(named), self._limits[0] < self._limits[1])
            place = key_place(viewport, high)
            key = colour_key(
                self._limits,
                named,
                self._colours[:MOST_TENDONS],
                place.width,
                place.height,
                self._slips,
                self._unit,
            )
            self._window.set_images((place, key))


def new_curves(
    colours: FloatArray, high: float, unit: EngineeringUnit = NEWTON
) -> mujoco.MjvFigure:
    """An empty figure for curves of (tendons, 2, 3) colours in a unit, up to a ``high`` [N]."""
    figure = mujoco.MjvFigure()
    mujoco.mjv_defaultFigure(figure)
    figure.title, figure.xlabel = labelled("tension at the ends", unit), "time [s]"
    figure.xformat, figure.yformat = "%.1f", "%.3g"
    figure.figurergba[:], figure.panergba[:] = (1.0, 1.0, 1.0, 0.85), (1.0, 1.0, 1.0, 1.0)
    figure.textrgb[:], figure.gridrgb[:] = 0.0, 0.85
    figure.linewidth, figure.gridwidth = 2.5, 1.0
    figure.flg_legend, figure.flg_extend = 0, 1
    figure.flg_ticklabel[:] = 1
    figure.gridsize[:] = (5, 5)
    figure.range[1] = (0.0, unit.factor * high)
    shown = colours[:MOST_TENDONS].reshape(-1, 3)
    figure.linergb[: len(shown)] = shown
    return figure


def draw_curves(
    figure: mujoco.MjvFigure, times: FloatArray, tensions: FloatArray, span: float
) -> None:
    """Put (n, tendons, 2) tensions over (n,) times [s] into a figure of a time span [s]."""
    chosen = slice(max(0, len(times) - _POINTS), None)
    shown, rows = times[chosen], np.nan_to_num(tensions[chosen], posinf=0.0)
    for line, values in enumerate(rows[:, :MOST_TENDONS].reshape(len(shown), -1).T):
        figure.linedata[line, 0 : 2 * len(shown) : 2] = shown
        figure.linedata[line, 1 : 2 * len(shown) : 2] = values
        figure.linepnt[line] = len(shown)
    start = max(0.0, float(shown[-1]) - span) if len(shown) else 0.0
    figure.range[0] = (start, start + span)


def curves_place(viewport: mujoco.MjrRect) -> mujoco.MjrRect:
    """Place of the curves in a window: at its lower right."""
    width, height = (round(_TAKEN[0] * viewport.width), round(_TAKEN[1] * viewport.height))
    left = viewport.left + viewport.width - width - _EDGE
    return mujoco.MjrRect(left, viewport.bottom + _EDGE, width, height)


def key_place(viewport: mujoco.MjrRect, height: int) -> mujoco.MjrRect:
    """Place of a key of colours of that height [pixels] in a window: at its lower left."""
    width = min(_KEY_PIXELS, max(1, viewport.width // 2))
    return mujoco.MjrRect(viewport.left + _EDGE, viewport.bottom + _EDGE, width, height)
