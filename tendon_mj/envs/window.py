"""Window of an environment: MuJoCo's viewer, no faster than real time."""

from __future__ import annotations

import importlib
import threading
import time
from collections.abc import Callable

import mujoco

_CLOSING = 10.0  # longest wait for the viewer to end [s]


class Window:
    """MuJoCo's viewer of models that differ in nothing but their geometry."""

    def __init__(self, model: mujoco.MjModel) -> None:
        viewer = importlib.import_module("mujoco.viewer")  # which looks for a screen on import
        others = set(threading.enumerate())
        self._data = mujoco.MjData(model)
        self._handle = viewer.launch_passive(
            model, self._data, show_left_ui=False, show_right_ui=False
        )
        self._threads = set(threading.enumerate()) - others
        with self._handle.lock():
            mujoco.mjv_defaultFreeCamera(model, self._handle.cam)
        self._shown = self._clock = 0.0  # time of the simulation, and when it was shown [s]

    def show(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        add: Callable[[mujoco.MjvScene], None],
    ) -> None:
        """Show a state and what ``add`` puts into the scene, unless the window was closed."""
        if not self._handle.is_running():
            return
        with self._handle.lock():
            mujoco.mj_copyData(self._data, model, data)
            self._handle.user_scn.ngeom = 0
            add(self._handle.user_scn)
        self._handle.sync()
        time.sleep(max(0.0, data.time - self._shown + self._clock - time.monotonic()))
        self._shown, self._clock = data.time, time.monotonic()

    def close(self) -> None:
        """Close the window."""
        self._handle.close()
        for thread in self._threads:  # the viewer's, which still draws
            thread.join(_CLOSING)
