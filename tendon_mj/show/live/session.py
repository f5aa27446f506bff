"""A simulation to watch: a model in motion, its live parameters, and the pace of the clock."""

from __future__ import annotations

import copy
import math
import threading
import time
from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import mujoco
import numpy as np

from tendon_mj.attach import Parameters, show_tension, view_sheath
from tendon_mj.errors import InvalidValueError, TendonError
from tendon_mj.lab.finger import find_motion, motion_names
from tendon_mj.lab.friction_effect import friction_sentence, most_first, sheathed_tendons
from tendon_mj.lab.motion import (
    Drive,
    demonstration_time,
    frictionless,
    is_friction,
    record_frames,
    resting,
)
from tendon_mj.lab.progress import Progress
from tendon_mj.lab.units import EngineeringUnit, force_unit
from tendon_mj.models import load_spec, model_path
from tendon_mj.plugin import TENSION_SCALE, most_bent_branch, sheaths
from tendon_mj.show.live.scene import Viewpoint, first_view
from tendon_mj.show.render.offscreen import colour_limits
from tendon_mj.show.render.surroundings import poses_of
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


_STATE = mujoco.mjtState.mjSTATE_INTEGRATION
IN_TURN = "each actuator in turn"  # the default motion
Step = Callable[[mujoco.MjModel, mujoco.MjData], object]


@contextmanager
def kept_state(model: mujoco.MjModel, data: mujoco.MjData) -> Iterator[FloatArray]:
    """Give data their state back, which an evaluation changes: it initialises sheaths."""
    state = np.empty(mujoco.mj_stateSize(model, _STATE))
    mujoco.mj_getState(model, data, state, _STATE)
    yield state
    mujoco.mj_setState(model, data, state, _STATE)


class LiveSimulation:
    """A model that moves: by a drive, by a function that is called before each step, or by hand.

    Another thread holds ``lock`` while it uses model and data. ``tendons`` names those of the
    sheaths, with the branch whose ends are shown; ``parameters`` are live, and `set` changes them.
    Tensions at the ends are kept for a time, ``remembered`` [s]. ``twin`` has the same model and
    controls without friction, or is None.

    Args:
        model: to simulate.
        drive: time [s] → (nu,) controls; None leaves the controls as they are.
        remembered: see above.
        data: to start from, which is changed; by default the model's reference state.
        step: called with model and data before each step, in place of a drive.
        shown: sheaths whose tendons have numbers, in this order; by default all.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        drive: Drive | None,
        remembered: float = 10.0,
        *,
        data: mujoco.MjData | None = None,
        step: Step | None = None,
        shown: Iterable[str] | None = None,
    ) -> None:
        self.model, self.data = model, mujoco.MjData(model) if data is None else data
        self.paused, self.step = False, step
        self.twin: mujoco.MjData | None = None
        self._drive, self._remembered, self.lock = drive, remembered, threading.Lock()
        known = sheaths(model)
        self._sheaths = {name: known[name] for name in (known if shown is None else shown)}
        branches = {name: most_bent_branch(model, name) for name in self._sheaths}
        self.tendons = {n: f"{s.tendon}{branches[n].words}" for n, s in self._sheaths.items()}
        self._ends = [[branch.first, branch.last] for branch in branches.values()]
        self.parameters = Parameters(model, self.data)
        self._views = [view_sheath(model, self.data, name) for name in self._sheaths]
        self.can_slip = any(view.slip.size for view in self._views)
        self._kept: deque[tuple[float, FloatArray]] = deque()
        with kept_state(model, self.data) as self._first:
            self._start()

    def advance(self, duration: float, limit: float = float("inf")) -> float:
        """Simulate for a duration [s], and keep the tensions at its end.

        Returns the simulated time [s], shorter if ``limit`` [s] of wall time ran out.
        """
        deadline, done = time.perf_counter() + limit, 0.0
        with self.lock:
            step = float(self.model.opt.timestep)
            while done + 0.5 * step < duration and time.perf_counter() < deadline:
                before = self.data.time
                if self.step is not None:
                    self.step(self.model, self.data)
                elif self._drive is not None:
                    self.data.ctrl[:] = self._drive(before)
                if self.data.time == before:
                    mujoco.mj_step(self.model, self.data)
                done += max(step, self.data.time - before)
                self._follow()
            if self.data.warning.number[_UNSTABLE].any():
                raise TendonError(f"the simulation became unstable before {self.data.time:.3g} s")
            if done:
                self._keep()
        return done

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
                self._renew_twin()
            elif self.twin is not None and not is_friction(name):
                Parameters(self.model, self.twin)[name] = value

    def reset(self) -> None:
        """Restart from the first state; live parameters stay as they are."""
        with self.lock:
            values = dict(self.parameters)
            mujoco.mj_setState(self.model, self.data, self._first, _STATE)
            self.parameters.update(values)
            self._kept.clear()
            self._start()
            self._renew_twin()

    def play(self, model: mujoco.MjModel, drive: Drive) -> None:
        """Restart with another drive, and the values of this copy of the model."""
        with self.lock:
            self.model, self._drive = model, drive
        self.reset()

    def hold(self, actuator: int, value: float) -> None:
        """Give an actuator a control, and leave all controls to the hand from now on."""
        with self.lock:
            self._drive = None
            self.data.ctrl[actuator] = value

    @property
    def is_by_hand(self) -> bool:
        """Whether neither a drive nor a function moves it."""
        return self._drive is None and self.step is None

    def compare(self, shown: bool) -> None:
        """Begin a twin without friction at the present state, or end it."""
        with self.lock:
            self.twin = self.data if shown else None
            self._renew_twin()

    def _renew_twin(self) -> None:
        if self.twin is not None:
            self.twin = copy.copy(self.data)
            live = Parameters(self.model, self.twin)
            live.update({name: 0.0 for name, value in live.items() if value and is_friction(name)})

    def _follow(self) -> None:
        """Step the twin to the time of the simulation."""
        if self.twin is None:
            return
        if self.twin.time > self.data.time:  # which its owner has reset
            self._renew_twin()
        self.twin.ctrl[:] = self.data.ctrl
        while self.twin.time < self.data.time - 0.5 * self.model.opt.timestep:
            mujoco.mj_step(self.model, self.twin)

    def curves(self) -> tuple[FloatArray, FloatArray]:
        """Remembered (n,) times [s] and (n, sheaths, 2) tensions at input and output [N]."""
        with self.lock:
            times, ends = zip(*self._kept, strict=True)
        return np.array(times), np.array(ends).reshape(len(times), len(self._sheaths), 2)

    def _start(self) -> None:
        if self._drive is not None:
            self.data.ctrl[:] = self._drive(self.data.time)
        with kept_state(self.model, self.data):
            mujoco.mj_forward(self.model, self.data)
            self._keep()

    def _keep(self) -> None:
        ends = np.array([v.tension[at] for v, at in zip(self._views, self._ends, strict=True)])
        if self._kept and self._kept[-1][0] > self.data.time:  # its owner has reset it
            self._kept.clear()
        self._kept.append((float(self.data.time), ends))
        while self._kept[0][0] < self.data.time - self._remembered:
            self._kept.popleft()


Motion = Callable[[], tuple[mujoco.MjModel, Drive]]


@dataclass(frozen=True)
class Prepared:
    """A simulation and the way it is shown."""

    simulation: LiveSimulation  # at its start
    view: Viewpoint  # at first
    low: float  # tensions at the ends of the colour bar [N]; both 0 without sheaths
    high: float
    still: str  # reason that nothing moves; empty if something does
    poses: FloatArray | None = None  # (k, nq) of its motion, to be in view
    # by name, the first is played: a copy of the model in it, and its drive
    motions: Mapping[str, Motion] = field(default_factory=dict)
    sentence: str = ""  # of what friction changes

    @property
    def force_unit(self) -> EngineeringUnit:
        """The unit of all forces that are shown, which is that of the colour bar."""
        return force_unit([self.high])


def prepare(
    name: str,
    motion: str | None = None,
    tendon: str | None = None,
    progress: Progress | None = None,
) -> Prepared:
    """Load a model and set it in a motion, see `find_motion`.

    Tendons are coloured between the tensions of the model's custom numeric
    `tendon_mj.tension_scale`, or, where it has none, those of a short run. ``tendon`` is the name
    or a pattern of those that have numbers; by default those that lose most by friction come first.
    """
    spec, stem = load_spec(name, scene=True), model_path(name).stem
    has_scale = spec.numeric(TENSION_SCALE) is not None
    if not has_scale:
        show_tension(spec, 0.0, 1.0)  # until the limits are known
    try:
        compiled = spec.compile()
    except ValueError as error:
        raise TendonError(f"{model_path(name, scene=True)}: {error}") from error
    tendons = sheathed_tendons(compiled, tendon) if tendon else None
    model, drive = in_motion(stem, compiled, motion, tendons)
    trial_time, limits = demonstration_time(model, tendons), model.numeric(TENSION_SCALE).data
    still = stands_still(model, drive, trial_time)
    record = partial(record_frames, model, drive, fps=_TRIAL_FPS, duration=trial_time)
    trial = most_first(model, record(at_rest=True, progress=progress), tendons)
    without = frictionless(model)
    free = record(at_rest=True, parameters=without, progress=progress) if without else None
    poses = poses_of(model, trial)
    if not sheaths(model):
        limits[:] = 0.0
    elif not has_scale:
        colours = colour_limits(trial.cables)
        limits[:] = colours.vmin, colours.vmax
    low, high = (float(limit) for limit in limits)
    motions = {
        shown: partial(in_motion, stem, compiled, asked, tendons)
        for shown, asked in _motions(stem, motion).items()
    }
    simulation = LiveSimulation(model, drive, data=resting(model), shown=trial.cables)
    view, sentence = first_view(model, poses), friction_sentence(model, trial, free)
    return Prepared(simulation, view, low, high, still, poses, motions, sentence)


def _motions(name: str, motion: str | None) -> dict[str, str | None]:
    """Motions of a model by the names that are shown; the one to begin with is the first."""
    first = {} if motion is None else {Path(motion).stem: motion}
    return {**first, **({n: n for n in motion_names(name)} or {IN_TURN: None})}


def in_motion(
    name: str, model: mujoco.MjModel, motion: str | None, tendons: Collection[str] | None = None
) -> tuple[mujoco.MjModel, Drive]:
    """A model ready for a motion (a copy where it must differ), and controls that repeat it."""
    chosen = find_motion(name, model, motion, tendons=tendons)
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
    """Reason that no actuator moves a model within a duration [s]; empty if one does."""
    if model.nu == 0:
        return "the model has no actuator"
    controls = np.array([drive(time) for time in np.arange(0.0, duration, 0.1)])
    return "" if np.ptp(controls, axis=0).any() else "the controls of the model stay as they are"


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
        begin = last = time.perf_counter()
        while watched and (seconds is None or last - begin < seconds):
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
