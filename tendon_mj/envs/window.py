"""Window of an environment: MuJoCo's viewer, no faster than real time."""

from __future__ import annotations

import time
from collections.abc import Callable

import mujoco

from tendon_mj.show.live import Viewer

INSTEAD = "render_mode = 'rgb_array' draws pictures without one"


class Window:
    """MuJoCo's viewer of models that differ in nothing but their geometry."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self._data = mujoco.MjData(model)
        self._viewer = Viewer(model, self._data, INSTEAD)
        self._handle = self._viewer.handle
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
        self._viewer.close()
