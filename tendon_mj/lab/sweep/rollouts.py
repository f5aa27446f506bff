"""Rollouts of a sweep: one model with a motion, recording or policy, each with other parameters."""

from __future__ import annotations

import copy
import hashlib
import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import InvalidValueError, RecordingError, UnknownNameError
from tendon_mj.lab.finger import find_motion
from tendon_mj.lab.motion import demonstration_time
from tendon_mj.lab.recordings import Measured, Recording, read_text
from tendon_mj.lab.replay import (
    Adjustable,
    Schedule,
    column_of,
    control_unit,
    reading_unit,
    run_open_loop,
    suppress_mujoco_log,
    unsolved_sheaths,
)
from tendon_mj.lab.sweep.design import SensorSummary, summarised
from tendon_mj.lab.units import ending_of
from tendon_mj.models import model_digest
from tendon_mj.typing import FloatArray

_MOST_STEPS = 10_000_000  # of a rollout; its readings are in memory
_DURATION = 6.0  # with a policy [s]

Act = Callable[[mujoco.MjModel, mujoco.MjData], Any]

ROLLOUT, FAILED, UNSOLVED = "rollout", "failed", "unsolved"


def motion_recording(
    name: str,
    model: mujoco.MjModel,
    motion: str | None,
    duration: float | None,
    *,
    still: bool = False,
) -> Recording:
    """The drive of a model in a motion, with every sensor of one number as measured.

    ``motion`` is as of `find_motion`. If no ``duration`` is given it is that of the motion, or
    6 to 12 s, in which every actuator has its turn.
    With ``still`` and without a motion every control is 0, for a policy to set.
    """
    if duration is not None:
        _steps(duration, model)  # before anything of that length is made
    known, columns, taken = {}, {}, set[str]()
    actuators: dict[str, str | tuple[str, ...]] = {}
    if still and motion is None:
        title, time = "no motion", _steps(_DURATION if duration is None else duration, model)
    else:
        chosen = find_motion(name, model, motion, duration)
        title, known = chosen.name, dict(chosen.parameters)
        length = chosen.duration if math.isfinite(chosen.duration) else demonstration_time(model)
        time = _steps(length if duration is None else duration, model)
        controls = np.array([chosen.drive(now) for now in time]).reshape(len(time), model.nu)
        for k in range(model.nactuator):
            control = controls[:, model.actuator_ctrladr[k]]
            if control.any():
                actuator = model.actuator(k).name
                if not actuator:
                    raise InvalidValueError(f"actuator {k} moves and has no name; give it one")
                column = _column(actuator, control_unit(model, k), taken)
                columns[column], actuators[column] = control, actuator
    sensors = [(model.sensor(k).name, k) for k in range(model.nsensor) if model.sensor_dim[k] == 1]
    readings = {
        _column(f"{sensor} reading", reading_unit(model, k), taken): Measured(sensor)
        for sensor, k in sensors
        if sensor
    }
    return Recording(
        name=title,
        model=name,
        source="a motion of tendon-mj sweep",
        time=time,
        columns={**columns, **dict.fromkeys(readings, np.zeros_like(time))},
        drive=actuators,
        measured=readings,
        known=known,
    )


def _steps(length: float, model: mujoco.MjModel) -> FloatArray:
    """Times of all steps of a duration [s], two at least."""
    step = float(model.opt.timestep)
    if not 0.5 <= length / step <= _MOST_STEPS:
        raise InvalidValueError(
            f"--duration: {length:g} s is outside 1 … {_MOST_STEPS} steps of {step:g} s, the"
            " model's timestep; give another"
        )
    return np.arange(max(1, round(length / step)) + 1, dtype=np.float64) * step


def _column(name: str, unit: str, taken: set[str]) -> str:
    return column_of(name, unit if ending_of(unit) else "N", taken)  # it matters to no number


@dataclass(frozen=True)
class Policy:
    """A function or class of a Python file; the file's text is sent to the workers.

    A function is called as ``name(model, data)`` before every step from the first sample on, and
    sets ``data.ctrl``, where it finds the command of the motion. Time, positions and velocities are
    those of now, readings of sensors those of the step before. Of a class each rollout has its own
    instance, ``name(model)``, that is called so; what it remembers between steps has to be in it.
    """

    path: str  # of the file
    name: str  # of the function or class
    source: str  # text of the file

    def __str__(self) -> str:
        return f"{self.path}:{self.name}"

    @property
    def digest(self) -> str:
        """16 hexadecimal digits of the file's text."""
        return hashlib.sha256(self.source.encode()).hexdigest()[:16]

    def make(self, model: mujoco.MjModel) -> Act:
        """The function, or an instance of the class, for one rollout of a model."""
        names = vars(self._module())
        if self.name not in names:
            callables = [n for n, v in names.items() if callable(v) and not n.startswith("_")]
            raise UnknownNameError("function or class", self.name, callables, f"--policy {self}")
        act: Any = names[self.name]
        if isinstance(act, type):
            with self.blamed(f" at {self.name}(model)"):
                act = act(model)
        if not callable(act):
            raise InvalidValueError(
                f"--policy {self}: {self.name} is not a function, or a class whose instances are"
                " called with (model, data)"
            )
        made: Act = act
        return made

    def _module(self) -> ModuleType:
        """The file as a module, run once per process."""
        name = f"{__name__}_{self.digest}"  # where pickle and dataclasses look for it
        if name not in sys.modules:
            module = sys.modules[name] = ModuleType(name)
            module.__file__ = self.path
            try:
                with self.blamed():
                    exec(compile(self.source, self.path, "exec", dont_inherit=True), vars(module))
            except InvalidValueError:
                del sys.modules[name]
                raise
        return sys.modules[name]

    @contextmanager
    def blamed(self, where: str = "") -> Iterator[None]:
        """Name the policy where its code raises; of sys.exit() too, which would end the sweep."""
        try:
            yield
        except (Exception, SystemExit) as error:
            text = f": {error}" if str(error) else ""
            raise InvalidValueError(
                f"--policy {self}: it raised {type(error).__name__}{text}{where}"
            ) from error


def read_policy(text: str) -> Policy:
    """The policy of ``file.py:name``."""
    path, _, name = text.rpartition(":")
    if not path.endswith(".py") or not name.isidentifier():
        raise InvalidValueError(f"--policy {text}: it is not like file.py:name")
    try:
        source = read_text(Path(path))
    except RecordingError as error:
        raise InvalidValueError(f"--policy {text}: {error}") from error
    return Policy(path, name, source)


def try_policy(
    model: mujoco.MjModel, data: mujoco.MjData, policy: Policy, control: FloatArray, lead: int
) -> FloatArray | None:
    """Step once for every row of controls, which a policy may change from row ``lead`` on.

    Returns (steps, nsensordata) readings as of the start of each step; None if MuJoCo warned or
    one is not finite.
    """
    act, readings = policy.make(model), np.empty((len(control), model.nsensordata))
    warmstart = data.qacc_warmstart.copy()
    mujoco.mj_forward(model, data)  # so that it reads the sensors of the start, too
    data.qacc_warmstart[:] = warmstart
    for step, row in enumerate(control):
        data.ctrl[:] = row
        if step >= lead:
            with policy.blamed(f" at time {data.time:.6g} s"):
                act(model, data)
        mujoco.mj_step(model, data)
        readings[step] = data.sensordata
    if any(warning.number for warning in data.warning) or not np.isfinite(readings).all():
        return None
    return readings


class Batch(NamedTuple):
    """Rollouts of one task: number of the first, and (rollouts, axes) values."""

    start: int
    values: FloatArray


@dataclass(frozen=True, kw_only=True)
class Rollouts:
    """The rollouts of a sweep; each is that of `Simulator`, to the bit."""

    model: mujoco.MjModel  # compiled; not changed
    # that drives it; of those measured, the columns of the outputs are read off
    recording: Recording
    settle: float  # time before the first sample [s]
    described: Mapping[str, float]  # parameter → value in every rollout, unless an axis sets it
    axes: Mapping[str, tuple[str, ...]]  # name → parameters that have its value
    outputs: tuple[SensorSummary, ...]  # of each rollout
    # that sets the controls; None: the recording alone does. Its changes of the model hold in that
    # rollout alone
    policy: Policy | None = None

    def __getstate__(self) -> dict[str, Any]:
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def identity(self) -> dict[str, str]:
        """Digest of the model that is simulated, as it is in this process."""
        return {f"model {self.recording.model}": model_digest(self.model)}

    def prepare_policy(self) -> None:
        """Make the policy once, without a simulation."""
        if self.policy is None:
            return
        if self._ready[1].joints:
            raise InvalidValueError(
                f"recording {self.recording.name!r} prescribes a joint, which no policy can take"
                " part in: let an actuator turn it, or leave out --policy"
            )
        self.policy.make(Adjustable(copy.copy(self.model)).model)

    @property
    def steps(self) -> int:
        """Time steps of a rollout."""
        return self._ready[1].steps

    @cached_property
    def _ready(self) -> tuple[Adjustable, Schedule]:
        """A model with its data, and its drive, which reads the columns of the outputs alone."""
        adjustable = Adjustable(copy.copy(self.model))
        schedule = Schedule(self.recording, adjustable.model, self.settle)
        wanted = {output.sensor for output in self.outputs}
        measured = {c for c, m in self.recording.measured.items() if m.sensor in wanted}
        schedule.addresses = {c: place for c, place in schedule.addresses.items() if c in measured}
        return adjustable, schedule

    def of(self, batch: Batch) -> dict[str, NDArray[Any]]:
        """A table: column → (rollouts,); `rollout`, axes, outputs, `failed` and `unsolved`.

        The outputs of a rollout that became unstable are NaN. `unsolved` counts evaluations in
        which a sheath found no equilibrium and used its best estimate.
        """
        rows, unsolved = np.full((len(batch.values), len(self.outputs)), np.nan), list[int]()
        with suppress_mujoco_log():
            for k, values in enumerate(batch.values):
                try:
                    summary, stuck = self._one(values)
                except InvalidValueError as error:
                    raise InvalidValueError(f"rollout {batch.start + k}: {error}") from error
                unsolved.append(stuck)
                if summary is not None:
                    rows[k] = summary
        number = np.arange(batch.start, batch.start + len(rows))
        return {
            ROLLOUT: number,
            **dict(zip(self.axes, batch.values.T, strict=True)),
            **{output.name: rows[:, k] for k, output in enumerate(self.outputs)},
            FAILED: np.isnan(rows).any(axis=1),
            UNSOLVED: np.array(unsolved),
        }

    def check(self, values: Sequence[float]) -> None:
        """Set the axes to values, without a simulation."""
        self._set(self._ready[0], values)

    def _set(self, adjustable: Adjustable, values: Sequence[float]) -> None:
        given = dict(self.described)
        for targets, value in zip(self.axes.values(), values, strict=True):
            given |= dict.fromkeys(targets, value)
        adjustable.set(given)

    def _one(self, values: FloatArray) -> tuple[list[float] | None, int]:
        adjustable, schedule = self._ready
        if self.policy is not None or schedule.joints:  # which change their model
            adjustable = Adjustable(copy.copy(self.model))
        model, data = adjustable.model, adjustable.data
        mujoco.mj_resetData(model, data)
        self._set(adjustable, values.tolist())
        schedule.prepare(adjustable)
        control = schedule.control(adjustable)
        if self.policy is None:
            readings = run_open_loop(model, data, control, schedule.rests(adjustable))
        else:
            readings = try_policy(model, data, self.policy, control, schedule.lead)
        stuck = sum(unsolved_sheaths(model, data).values())
        if readings is None:
            return None, stuck
        series = schedule.read_out(adjustable, readings)
        sensors = {self.recording.measured[column].sensor: column for column in series}
        simulated = {sensor: series[column] for sensor, column in sensors.items()}
        measured = {sensor: self.recording.columns[column] for sensor, column in sensors.items()}
        return summarised(self.outputs, simulated, measured), stuck
