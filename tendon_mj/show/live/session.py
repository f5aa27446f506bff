"""A simulation to watch: a model in motion, its live parameters, and the pace of the clock."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

import mujoco
import numpy as np

from tendon_mj.attach import Parameters, show_tension, view_sheath
from tendon_mj.errors import InvalidValueError, TendonError
from tendon_mj.lab.finger import find_motion
from tendon_mj.lab.replay import Drive, demonstration_time, record_frames
from tendon_mj.models import load_spec, model_path
from tendon_mj.plugin import TENSION_SCALE, sheaths
from tendon_mj.show.live.scene import Viewpoint, first_view
from tendon_mj.show.render.offscreen import colour_limits
from tendon_mj.typing import FloatArray

_LIVE_FPS = 60.0  # [1/s]
_TRIAL_FPS = 20.0  # of the run that sets the colours' limits [1/s]
_LAG = 0.5  # that is caught up; with more the simulation is slower than the clock [s]
_LONGEST_FRAME = 0.1  # between two frames in any case [s]
_JUMP = 1e-3  # largest distance of a motion's end from its beginning, over its range
_RETURN = 0.5  # from the last controls of a motion back to its first [s]
_UNSTABLE = [
    getattr(mujoco.mjtWarning, f"mjWARN_BAD{of}").value for of in ("QPOS", "QVEL", "QACC", "CTRL")
]


class LiveSimulation:
    """A model that moves by controls over time.

    Another thread holds ``lock`` while it uses model and data. ``tendons`` names those of the
    sheaths; ``parameters`` are live, and `set` changes them. Tensions at the ends are kept for a
    time, ``remembered`` [s].
    """

    def __init__(self, model: mujoco.MjModel, drive: Drive, remembered: float = 10.0) -> None:
        self.model, self.data = model, mujoco.MjData(model)
        self.paused = False
        self._drive, self._remembered, self.lock = drive, remembered, threading.Lock()
        self._sheaths = sheaths(model)
        self.tendons = {name: sheath.tendon for name, sheath in self._sheaths.items()}
        self.parameters = Parameters(model, self.data)
        self._views = [view_sheath(model, self.data, name) for name in self._sheaths]
        self._kept: deque[tuple[float, FloatArray]] = deque()
        self._start()

    def advance(self, duration: float, limit: float = float("inf")) -> float:
        """Simulate for a duration [s], and keep the tensions at its end.

        Returns the simulated time [s], shorter if ``limit`` [s] of wall time ran out.
        """
        deadline = time.perf_counter() + limit
        with self.lock:
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

        A pretension resets the sheath: the tendon is laid evenly along its path.
        """
        with self.lock:
            self.parameters[name] = value
            sheath, _, parameter = name.rpartition(".")
            if parameter == "pretension":
                values = dict(self.parameters)
                start, instance = self._sheaths[sheath].state, self._sheaths[sheath].instance
                span = slice(start, start + self.model.plugin_statenum[instance])
                self.data.plugin_state[span] = mujoco.MjData(self.model).plugin_state[span]
                self.parameters.update(values)

    def reset(self) -> None:
        """Restart the motion; live parameters stay as they are."""
        with self.lock:
            values = dict(self.parameters)
            mujoco.mj_resetData(self.model, self.data)
            self.parameters.update(values)
            self._kept.clear()
            self._start()

    def curves(self) -> tuple[FloatArray, FloatArray]:
        """Remembered (n,) times [s] and (n, sheaths, 2) tensions at input and output [N]."""
        with self.lock:
            times, ends = zip(*self._kept, strict=True)
        return np.array(times), np.array(ends).reshape(len(times), len(self._sheaths), 2)

    def _start(self) -> None:
        self.data.ctrl[:] = self._drive(0.0)
        mujoco.mj_forward(self.model, self.data)
        self._keep()

    def _keep(self) -> None:
        ends = np.array([view.tension[[0, -1]] for view in self._views])
        self._kept.append((float(self.data.time), ends))
        while self._kept[0][0] < self.data.time - self._remembered:
            self._kept.popleft()


@dataclass(frozen=True)
class Prepared:
    """A simulation and the way it is shown."""

    simulation: LiveSimulation  # at its start
    view: Viewpoint  # at first
    low: float  # tensions at the ends of the colour bar [N]; both 0 without sheaths
    high: float
    still: str  # reason that nothing moves; empty where something does


def prepare(name: str, motion: str | None = None) -> Prepared:
    """Load a model and set it in a motion, see `find_motion`.

    Tendons are coloured between the tensions of the model's custom numeric
    `tendon_mj.tension_scale`, or, where it has none, those of a short run.
    """
    spec, stem = load_spec(name, scene=True), model_path(name).stem
    has_scale = spec.numeric(TENSION_SCALE) is not None
    if not has_scale:
        show_tension(spec, 0.0, 1.0)  # until the limits are known
    try:
        compiled = spec.compile()
    except ValueError as error:
        raise TendonError(f"{model_path(name, scene=True)}: {error}") from error
    model, drive = in_motion(stem, compiled, motion)
    trial_time, limits = demonstration_time(model), model.numeric(TENSION_SCALE).data
    still = stands_still(model, drive, trial_time)
    if not sheaths(model):
        limits[:] = 0.0
    elif not has_scale:
        trial = record_frames(model, drive, duration=trial_time, fps=_TRIAL_FPS)
        colours = colour_limits(trial.cables)
        limits[:] = colours.vmin, colours.vmax
    low, high = (float(limit) for limit in limits)
    return Prepared(LiveSimulation(model, drive), first_view(model), low, high, still)


def in_motion(name: str, model: mujoco.MjModel, motion: str | None) -> tuple[mujoco.MjModel, Drive]:
    """A model ready for a motion (a copy where it must differ), and controls that repeat it."""
    chosen = find_motion(name, model, motion)
    if not math.isfinite(chosen.duration):  # it neither ends nor repeats
        return model, chosen.drive
    times = np.arange(0.0, chosen.duration, model.opt.timestep)
    if not len(times):
        raise InvalidValueError(f"{motion}: the motion is shorter than a step of the model")
    controls = np.array([chosen.drive(time) for time in times])
    return chosen.prepared(model), repeated(controls, model.opt.timestep)


def repeated(rows: FloatArray, step: float) -> Drive:
    """(steps, nu) controls, one per step [s], repeated; a straight line leads back to the first."""
    if len(rows) and (np.abs(rows[-1] - rows[0]) > _JUMP * np.ptp(rows, axis=0)).any():
        share = np.linspace(0.0, 1.0, max(2, round(_RETURN / step)))[1:, None]
        rows = np.concatenate([rows, (1.0 - share) * rows[-1] + share * rows[0]])
    return lambda time: np.asarray(rows[round(time / step) % len(rows)])


def stands_still(model: mujoco.MjModel, drive: Drive, duration: float) -> str:
    """Reason that no actuator moves a model within a duration [s]; empty where one does."""
    if model.nu == 0:
        return "it has no actuator"
    moves = any(np.any(drive(time)) for time in np.arange(0.0, duration, 0.1))
    return "" if moves else "the controls stay at 0"


@dataclass(frozen=True)
class RealTime:
    """Pace of a simulation."""

    simulated: float  # [s]
    elapsed: float  # on the clock, without pauses [s]
    frames: int  # shown

    def sentence(self) -> str:
        """The pace in a sentence."""
        clock = max(self.elapsed, 1e-9)
        return (
            f"simulated {self.simulated:.1f} s in {self.elapsed:.1f} s, "
            f"{self.simulated / clock:.2f} × real time, "
            f"at {self.frames / clock:.0f} frames a second"
        )


def run_in_real_time(
    simulation: LiveSimulation, show: Callable[[], bool], seconds: float | None = None
) -> RealTime:
    """Simulate and show in turn, until ``show`` returns that the view is closed, or the time is up.

    Ctrl-C ends it like closing the window.
    """
    simulated, elapsed, owed, frames = 0.0, 0.0, 0.0, 0
    with suppress(KeyboardInterrupt):
        watched = show()  # opens the window or page, which does not count for the pace
        last = time.perf_counter()
        while watched and (seconds is None or elapsed < seconds):
            time.sleep(max(0.0, last + 1.0 / _LIVE_FPS - time.perf_counter()))
            now = time.perf_counter()
            passed, last = now - last, now
            if not simulation.paused:
                elapsed += passed
                owed = min(owed + passed, _LAG)
                done = simulation.advance(owed, limit=_LONGEST_FRAME)
                simulated, owed = simulated + done, owed - done
            watched = show()
            frames += 1
    return RealTime(simulated, elapsed, frames)
