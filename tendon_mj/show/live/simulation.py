"""A simulation that runs while it is watched, and the tensions that it went through."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

import mujoco
import numpy as np

from tendon_mj.errors import TendonError
from tendon_mj.lab.replay import Drive, LiveParameters
from tendon_mj.plugin import sheath_arrays, sheaths
from tendon_mj.typing import FloatArray

_WARNING = mujoco.mjtWarning
_UNSTABLE = [
    _WARNING.mjWARN_BADQPOS.value,
    _WARNING.mjWARN_BADQVEL.value,
    _WARNING.mjWARN_BADQACC.value,
    _WARNING.mjWARN_BADCTRL.value,
]


class LiveSimulation:
    """A model that moves by controls over time.

    Args:
        model: to simulate.
        drive: time [s] → (nu,) controls.
        remembered: for how long the tensions at the ends are kept [s].

    Attributes:
        model, data: of the simulation; another thread uses them within `held`.
        sheaths: names of the model's sheaths.
        parameters: live ones, by ``<sheath>.<parameter>``.
        paused: whether time stands still.
    """

    def __init__(self, model: mujoco.MjModel, drive: Drive, remembered: float = 10.0) -> None:
        self.model, self.data = model, mujoco.MjData(model)
        self.paused = False
        self._drive, self._remembered, self._lock = drive, remembered, Lock()
        self._known = sheaths(model)
        self.sheaths = tuple(self._known)
        self.parameters = LiveParameters(model, self.data)
        self._times: deque[float] = deque()
        self._ends: deque[FloatArray] = deque()
        self._start()

    @contextmanager
    def held(self) -> Iterator[None]:
        """Keep the simulation from going on while a thread reads or changes it."""
        with self._lock:
            yield

    def advance(self, duration: float, limit: float = float("inf")) -> float:
        """Simulate for a duration, and keep the tensions at the end of it.

        Args:
            duration: to simulate [s].
            limit: after which to stop in any case [s on the clock].

        Returns:
            What was simulated [s].

        Raises:
            TendonError: the simulation became unstable; the message says when.
        """
        deadline = time.perf_counter() + limit
        with self._lock:
            steps, step = 0, float(self.model.opt.timestep)
            while (steps + 0.5) * step < duration and time.perf_counter() < deadline:
                self.data.ctrl[:] = self._drive(self.data.time)
                mujoco.mj_step(self.model, self.data)
                steps += 1
            if self.data.warning.number[_UNSTABLE].any():
                raise TendonError(f"the simulation became unstable before {self.data.time:.3g} s")
            if steps:
                self._keep()
        return steps * step

    def set(self, name: str, value: float) -> None:
        """Change a live parameter from the next step on.

        A pretension lays the tendon anew, evenly along its path, as after a reset.

        Raises:
            UnknownKeyError: no such parameter.
            InvalidValueError: a value outside its range.
        """
        with self._lock:
            self.parameters[name] = value
            sheath, _, parameter = name.rpartition(".")
            if parameter == "pretension":
                self._state(sheath)["started"] = 0.0

    def reset(self) -> None:
        """Begin anew; live parameters stay as they are."""
        with self._lock:
            values = dict(self.parameters)
            mujoco.mj_resetData(self.model, self.data)
            self.parameters.update(values)
            self._times.clear()
            self._ends.clear()
            self._start()

    def curves(self) -> tuple[FloatArray, FloatArray]:
        """Tensions at both ends of every sheath over the time that is remembered.

        Returns:
            (n,) times [s], and (n, sheaths, 2) tensions at input and output [N].
        """
        shape = (len(self._ends), len(self.sheaths), 2)
        return np.array(self._times), np.array(self._ends).reshape(shape)

    def tensions(self) -> FloatArray:
        """(sheaths, 2) tensions at input and output as they are now [N]."""
        return self._ends[-1]

    def _start(self) -> None:
        self.data.ctrl[:] = self._drive(0.0)
        mujoco.mj_forward(self.model, self.data)
        self._keep()

    def _state(self, sheath: str) -> np.ndarray:
        start = self._known[sheath].state
        return sheath_arrays(self.model, self.data.plugin_state, sheath, start).state  # type: ignore[no-any-return]

    def _keep(self) -> None:
        ends = np.zeros((len(self._known), 2))
        for row, (name, found) in zip(ends, self._known.items(), strict=True):
            seen = sheath_arrays(self.model, self.data.plugin_state, name, found.state)
            row[:] = seen.state["law"]["axial_stiffness"] * seen.segments["tension"][[0, -1]]
        self._times.append(float(self.data.time))
        self._ends.append(ends)
        while self._times[0] < self.data.time - self._remembered:
            self._times.popleft()
            self._ends.popleft()
