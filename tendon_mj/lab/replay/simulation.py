"""Simulations of recordings: one that reports why it failed, or many at once on all cores."""

from __future__ import annotations

import copy
import ctypes
import math
import os
import warnings
from abc import abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType
from typing import Final, NamedTuple, Protocol

import mujoco
import numpy as np
from mujoco import rollout
from numpy.typing import NDArray

from tendon_mj.attach import checked_number
from tendon_mj.errors import (
    InvalidValueError,
    RecordingError,
    TendonError,
    UnknownNameError,
    unknown,
)
from tendon_mj.lab.frames import FrameRecorder
from tendon_mj.lab.parameter_names import parameter_of, recording_of, values_for
from tendon_mj.lab.recordings import Measured, Recording, is_same_model
from tendon_mj.lab.replay.finer_guides import split_guides
from tendon_mj.lab.replay.parameters import Adjustable, Parameter, joint_of
from tendon_mj.lab.replay.schedule import Rests, Schedule, described_values, stated_values
from tendon_mj.lab.units import ROUNDING, UNKNOWN, column_unit, rate
from tendon_mj.models import load_model, load_spec
from tendon_mj.plugin import C, sheaths, unsolved_evaluations
from tendon_mj.typing import FloatArray

Values = Mapping[str, float]
Series = dict[str, NDArray[np.float64]]
ProgressShare = Callable[[float], None]  # called with the share that is done, 0 … 1

UNSOLVED_WARNING: Final = "some simulations: sheath"  # how the warning of no equilibrium begins
_PHYSICS = mujoco.mjtState.mjSTATE_FULLPHYSICS
_CHUNK = 2000  # steps between two reports of progress
_WATCHED = 0.05  # of a rest, between two looks at whether anything still moves [s]
_RESTS = 1e-4  # of a reading's span or a joint's way: less to come until a rest's end is negligible


def run_open_loop(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    control: FloatArray,
    rests: Rests | None = None,
    progress: ProgressShare | None = None,
    recorder: FrameRecorder | None = None,
) -> FloatArray | None:
    """Step once for every row of controls, and read the sensors as of the start of each step.

    A step's readings (steps, nsensordata) therefore belong to its own control and to the pose that
    the steps before it led to; None if MuJoCo warned or one is not finite. ``data`` is at the
    end afterwards. A row of controls has nu numbers, or nu+nv with applied forces. Of ``rests`` the
    steps are left out in which nothing moves any more.
    """
    readings, steps = np.empty((len(control), model.nsensordata)), len(control)
    due = set(recorder.due(data.time, model.opt.timestep, steps - 1)) if recorder else set()
    pauses = rests.ends if rests else range(0, steps, _CHUNK if progress else steps)
    for first, end in pairwise(sorted({0, *pauses, *due, steps})):
        if recorder and first in due:
            recorder.keep(model, data, control[first, : model.nu])
        if not _run(model, data, control, readings, slice(first, end), rests):
            return None
        if progress:
            progress(end / steps)
    return readings


def _run_strictly(
    schedule: Schedule,
    adjustable: Adjustable,
    progress: ProgressShare | None = None,
    recorder: FrameRecorder | None = None,
) -> FloatArray:
    """Readings of a schedule; raises `TendonError` where it failed, and warns of unsolved flows."""
    model, data = adjustable.model, adjustable.data
    control, start = schedule.control(adjustable), full_state(model, data)
    rests = schedule.rests(adjustable)
    readings = run_open_loop(model, data, control, rests, progress, recorder)
    if readings is None:
        failure = _first_failure(model, start, control, schedule.when)
        raise TendonError(f"{schedule.where} failed {failure}")
    for name, unsolved in unsolved_sheaths(model, data).items():
        warnings.warn(
            f"{schedule.where}: sheath {name!r} found no equilibrium in {unsolved} of"
            f" {len(control)} evaluations, and took the best that it had",
            RuntimeWarning,
            stacklevel=3,
        )
    return readings


def unsolved_sheaths(model: mujoco.MjModel, data: mujoco.MjData) -> dict[str, int]:
    """Number of evaluations without a solution, of every sheath that had any."""
    return {name: count for name, count in unsolved_evaluations(model, data).items() if count}


def _run(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    control: FloatArray,
    readings: FloatArray,
    part: slice,
    rests: Rests | None,
) -> bool:
    """Fill a part of the readings, see `_step`; of one that ends with a rest, until all rests."""
    if rests is None or part.stop not in rests.ends:
        return _step(model, data, control[part], readings[part])
    changes = np.flatnonzero((control[part] != control[part.stop - 1]).any(axis=1))
    at = part.start + (int(changes[-1]) + 1 if changes.size else 0)
    began, watched = data.qpos.copy(), max(1, round(_WATCHED / model.opt.timestep))
    moving = slice(part.start, at)
    if at > part.start and not _step(model, data, control[moving], readings[moving]):
        return False
    while at < part.stop:
        chunk, before = slice(at, min(at + watched, part.stop)), data.qpos.copy()
        if not _step(model, data, control[chunk], readings[chunk]):
            return False
        at = chunk.stop
        longer = (part.stop - at) / (chunk.stop - chunk.start)
        moved = np.abs(_moved(model, before, data.qpos)) * longer
        least = np.maximum(_RESTS * np.abs(_moved(model, began, data.qpos)), ROUNDING)
        changed = np.ptp(readings[chunk], axis=0) * longer
        if (moved <= least).all() and (changed <= _RESTS * rests.spans).all():
            readings[at : part.stop] = readings[at - 1]
            break
    data.time = rests.ends[part.stop]
    return True


def _moved(model: mujoco.MjModel, before: FloatArray, after: FloatArray) -> FloatArray:
    """(nv,) way of every degree of freedom from one pose to another [rad or m]."""
    way = np.zeros(model.nv)
    mujoco.mj_differentiatePos(model, way, 1.0, before, after)
    return way


def _step(
    model: mujoco.MjModel, data: mujoco.MjData, control: FloatArray, readings: FloatArray
) -> bool:
    """Fill readings from where the data is; false if MuJoCo warned or a reading is not finite."""
    start, warmstart = full_state(model, data)[None], data.qacc_warmstart[None].copy()
    readings[:] = rollout_sensors(model, [data], start, control[None], warmstart)[0]
    return not data.warning.number.any() and bool(np.isfinite(readings).all())


def _first_failure(
    model: mujoco.MjModel, start: FloatArray, control: FloatArray, when: Callable[[int], str]
) -> str:
    """Step once more from the start, and say when and why it failed."""
    data = mujoco.MjData(model)
    mujoco.mj_setState(model, data, start, _PHYSICS.value)
    timestep = f"the timestep was {model.opt.timestep:.6g} s"
    for step, row in enumerate(control):
        mujoco.mj_setState(model, data, row, _input_kind(model, row))
        mujoco.mj_step(model, data)
        raised = [k for k, warning in enumerate(data.warning) if warning.number]
        if raised:
            name = mujoco.mjtWarning(raised[0]).name
            return f"{when(step)}: MuJoCo raised {name}; {timestep}"
        if not np.isfinite(data.sensordata).all():
            return f"{when(step)}: a sensor reads no finite number; {timestep}"
    return f"at a time that a second run did not find; {timestep}"


def load_recorded(recording: Recording) -> mujoco.MjModel:
    """The model of a recording."""
    return load_model(recording.model, beside=recording.beside)


def replay_recording(
    recording: Recording,
    model: mujoco.MjModel | None = None,
    *,
    parameters: Mapping[str, float] | None = None,
    described: bool | None = None,
    settle: float | None = None,
    progress: ProgressShare | None = None,
    recorder: FrameRecorder | None = None,
) -> Recording:
    """Drive a model with a recording's driven columns and read off its measured ones.

    Between samples the drive is linear in time, or held where the recording says so. The step is
    uniform, no longer than the model's and a whole fraction of the sampling interval (see
    `make_clock`); readings belong to the pose and the control at the sample's time. Before the
    first sample the model, from its reference pose, is brought to the first drive value by a linear
    ramp over half of ``settle`` and held there for the other half. Actuators that are not driven
    stay at 0.

    Args:
        recording: to simulate.
        model: to drive in place of the one that ``recording.model`` names; not changed. It keeps
            its values, see `stated_values`.
        parameters: ``<element>.<parameter>`` to value (see `replay.parameters`), over
            ``recording.known`` and the values of ``recording.uncertain`` and ``recording.session``.
        described: whether those three are applied: True all, False only what commands and sensors
            are of which the model states nothing; default: see `stated_values`.
        settle: time before the first sample [s]; with 0 the model starts in its reference pose.
            Default: as the recording says.
        progress: called with the share that is done, 0 … 1, every 2000 steps.
        recorder: keeps frames of the run from the first sample on, to be drawn.

    Returns:
        The driven columns as they were and the measured ones as simulated, at the same times;
        ``known`` holds every parameter that was applied.

    Raises:
        RecordingError: the model lacks an actuator or sensor, or the sensor is not one number.
        UnknownNameError: no such model or parameter, with the nearest.
        InvalidValueError: a parameter or ``settle`` outside its range.
        TendonError: the simulation failed; the message says when.
    """
    given = model is not None
    if model is None:
        model = load_recorded(recording)
    adjustable = Adjustable(copy.copy(model))
    schedule = Schedule(recording, adjustable.model, settle)
    stated = stated_values(recording, model, adjustable.parameters(), described, given=given)
    values = {**stated, **(parameters or {})}
    adjustable.set(values)
    schedule.prepare(adjustable)
    readings = _run_strictly(schedule, adjustable, progress, recorder)
    return as_recording(recording, schedule.read_out(adjustable, readings), values)


def as_recording(
    recording: Recording, series: Mapping[str, FloatArray], applied: Mapping[str, float]
) -> Recording:
    """Simulated series (n,) of measured columns as a recording, as of the one that drove them.

    ``applied`` are the parameters that the simulation was given.
    """
    columns = {column: recording.columns[column] for column in recording.drive} | dict(series)
    return Recording(
        name=f"{recording.name}_simulated",
        model=recording.model,
        source=f"simulated by tendon-mj, driven by {recording.name!r} ({recording.source})",
        time=recording.time,
        columns={c: columns[c] for c in recording.columns if c in columns},
        drive=recording.drive,
        measured={c: Measured(m.sensor) for c, m in recording.measured.items()},
        known=applied,
        settling_time=recording.settling_time,
    )


@dataclass(frozen=True)
class Misfit:
    """Error e = simulated − measured of one column."""

    rmse: float  # √(mean e²) [the column's unit]
    share_of_range: float  # rmse over the measured column's largest less smallest value [-]
    largest: float  # max |e| [the column's unit]
    bias: float  # mean e [the column's unit]

    @property
    def of_range(self) -> str:
        """The share of the range in words, after a comma; empty if the column is constant."""
        share = self.share_of_range
        return f", {share:.1%} of its range" if math.isfinite(share) else ""


def replay_error(measured: Recording, simulated: Recording) -> dict[str, Misfit]:
    """Misfit of every column that ``measured`` lists as measured.

    Raises:
        RecordingError: the two differ in their times, or a column is missing.
    """
    where = f"recording {simulated.name!r}"
    if not np.array_equal(measured.time, simulated.time):
        raise RecordingError(f"{where}: its times are not those of {measured.name!r}")
    misfits = {}
    for column in measured.measured:
        if column not in simulated.columns:
            raise RecordingError(f"{where}: {unknown('column', column, simulated.columns)}")
        truth = measured.columns[column]
        error = simulated.columns[column] - truth
        rmse = math.sqrt(float(np.mean(error**2)))
        span = float(np.ptp(truth))
        share = rmse / span if span > 0.0 else (0.0 if rmse == 0.0 else math.inf)
        misfits[column] = Misfit(rmse, share, float(np.abs(error).max()), float(error.mean()))
    return misfits


def full_state(model: mujoco.MjModel, data: mujoco.MjData) -> FloatArray:
    """State of kind FULLPHYSICS, from which a rollout goes on. Shape (state size,)."""
    state = np.empty(mujoco.mj_stateSize(model, _PHYSICS))
    mujoco.mj_getState(model, data, state, _PHYSICS)
    return state


def _input_kind(model: mujoco.MjModel, control: FloatArray) -> int:
    """Kind of state that a row of controls is: nu controls, with or without nv applied forces."""
    kind = int(mujoco.mjtState.mjSTATE_CTRL.value)
    applied = int(mujoco.mjtState.mjSTATE_QFRC_APPLIED.value)
    return kind if control.shape[-1] == model.nu else kind | applied


def rollout_sensors(
    model: mujoco.MjModel,
    data: list[mujoco.MjData],
    start: FloatArray,
    control: FloatArray,
    warmstart: FloatArray | None = None,
) -> FloatArray:
    """(runs, steps, nsensordata) readings of rollouts, one thread for each of ``data``.

    Unlike a plain `mujoco.rollout` it keeps no states: a sheath of 64 guides has thousands of
    numbers, and writing them down at every step would cost more than the step. ``start`` are (runs,
    state size) states of kind FULLPHYSICS; ``control`` is (runs, steps, nu), or nu+nv with applied
    forces; ``warmstart`` are (runs, nv) accelerations from which the solver starts, by default 0.
    """
    runs, steps = control.shape[:2]
    readings = np.empty((runs, steps, model.nsensordata))
    with rollout.Rollout(nthread=len(data) if len(data) > 1 else 0) as runner:
        runner.rollout(
            [model] * runs,
            data,
            start,
            np.ascontiguousarray(control),
            control_spec=_input_kind(model, control),
            skip_checks=True,  # with them it would allocate the states of all steps
            nstep=steps,
            initial_warmstart=warmstart,
            sensordata=readings,
        )
    return readings


def rollout_named_sensors(
    model: mujoco.MjModel, control: FloatArray, threads: int = 1
) -> dict[str, FloatArray]:
    """Readings by sensor of a model with one actuator, which follows ``control``.

    Controls are (steps,) or (runs, steps); readings have the same shape.
    """
    commands = np.atleast_2d(control)
    data = [mujoco.MjData(model) for _ in range(threads)]
    start = np.tile(full_state(model, data[0]), (len(commands), 1))
    readings = rollout_sensors(model, data, start, commands[:, :, None])
    if not np.isfinite(readings).all() or any(d.warning.number.any() for d in data):
        raise TendonError(f"a simulation at a step of {model.opt.timestep:g} s became unstable")
    readings = readings.reshape(*control.shape, model.nsensordata)
    sensors = [model.sensor(k) for k in range(model.nsensor)]
    named = {sensor.name: readings[..., int(sensor.adr[0])] for sensor in sensors}
    if "unsolved" in named and named["unsolved"].max() > 0.0:
        raise TendonError(f"{named['unsolved'].max():g} flows of the plugin were not solved")
    return named


@contextmanager
def suppress_unsolved_warnings() -> Iterator[None]:
    """Ignore the warning of sheaths without equilibrium."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", UNSOLVED_WARNING, RuntimeWarning)
        yield


@contextmanager
def suppress_mujoco_log() -> Iterator[None]:
    """Keep MuJoCo from writing a log file where it runs; a failure shows in the series instead."""
    logger = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda message: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(logger)


@contextmanager
def _without_timers() -> Iterator[None]:
    """Let no part of a step be timed, as MuJoCo's Python bindings do in a seventh of its time."""
    timer = ctypes.c_void_p.in_dll(C, "mjcb_time")
    given = timer.value
    timer.value = None
    try:
        yield
    finally:
        timer.value = given


class Simulates(Protocol):
    """Simulator of recordings, with parameters by name.

    Another class either has all these members, or is derived from this one, sets
    ``parameters`` and defines ``__call__``; the others then answer as for a simulator that knows
    neither joints nor steps.

    Attributes:
        parameters: every parameter that it knows, at the value that it has when a set does not
            name it.
        joints: joint → whether a driven column prescribes its motion, so that no effect can be on
            it. Joints are the elements of the parameters of kind "joint"; one that is not named
            here is free.
        steps: time steps of one simulation of all recordings; 0 if it makes no error of steps.
            With 0 its answers are taken as exact; else a diagnosis searches in longer steps, if
            these change little, and takes the error of the steps out by Richardson's
            extrapolation.
        sessions: whether it takes ``<parameter> @ <recording>``, a value for one recording alone;
            without, recordings that have such in [session] are refused.
    """

    parameters: Mapping[str, Parameter]
    joints: Mapping[str, bool] = MappingProxyType({})
    steps: int = 0
    sessions: bool = False

    @abstractmethod
    def __call__(self, parameter_sets: Sequence[Values]) -> list[list[Series]]:
        """For every set, for every recording: measured column → (n,) at the samples.

        A simulation that failed has NaN in its series.
        """

    def in_steps(self, factor: float) -> Simulates:
        """This simulator in steps ``factor`` > 0 times as long; itself if ``steps`` is 0.

        It may keep steps shorter than asked for, as where the sampling interval limits them; its
        ``steps`` then say so.
        """
        return self


class Channel(NamedTuple):
    """Channel of a column: its actuator or sensor on the model, and the unit it is written in."""

    name: str | tuple[str, ...]
    unit: str


class _Job(NamedTuple):
    """One simulation of a recording, read off in one or more ways."""

    recording: int
    acting: Values  # parameters of the simulation
    readouts: list[tuple[int, Values]]  # number of a set, and the parameters of its sensors


class Simulator:
    """Simulates recordings with any number of sets of parameters; see `Simulates`.

    Every simulation is that of `replay_recording`, to the bit, whatever the number of threads and
    whatever else is in the call. Sets that differ in their sensors only share simulations. A fit
    may end before its recordings do: a subclass computes no sample from later ones.

    Args:
        recordings: of one model, in any lengths.
        model: in place of the one that the recordings name; not changed.
        described: whether a recording's [known] and the values of its [uncertain] and [session]
            are applied to its simulations, unless a set has others.
        settle: time before the first sample [s], as in `replay_recording`.
        timestep: longest step allowed [s]; default: the model's.
        threads: simulations at a time; default: as many as there are cores.
        strict: whether a simulation that fails raises; else its series are all NaN.

    Attributes:
        recordings: as given.
        model: compiled, with none of the recordings' parameters applied; not to be changed.
        parameters: every parameter, at its value in the first recording that says one, else the
            model's.
        joints: hinges and slides that have a name, and whether a driven column prescribes their
            motion. A motor's torque or force prescribes none; an actuator with a gain on the
            joint's place or rate does, unless the resulting motion was measured, and so does a
            column with the joint itself in [drive].
        steps: time steps of one simulation of all recordings.
        sessions: True: a set may hold ``<parameter> @ <recording>``, which acts on that one alone.

    Raises:
        RecordingError: there are none, they name several models, one does not fit its model, or
            calls a parameter known or uncertain that the model cannot have.
        InvalidValueError: ``threads`` or ``timestep`` is not positive.
    """

    sessions = True

    def __init__(
        self,
        recordings: Sequence[Recording],
        model: mujoco.MjModel | None = None,
        *,
        described: bool = True,
        settle: float | None = None,
        timestep: float | None = None,
        threads: int | None = None,
        strict: bool = False,
    ) -> None:
        if isinstance(recordings, Recording):
            raise RecordingError("recordings are needed as a list: write [recording]")
        self.recordings = tuple(recordings)
        if threads is not None and threads < 1:
            raise InvalidValueError(f"threads = {threads} must be ≥ 1")
        self._pieces = 1  # of each guide
        self.model = copy.copy(model) if model is not None else self._load_model()
        _skip_contacts(self.model)
        self._given = model is not None
        self._schedules = [Schedule(r, self.model, settle, timestep) for r in self.recordings]
        self._settle = settle
        names = Adjustable(copy.copy(self.model)).names()
        self._described = [described_values(r, names) if described else {} for r in self.recordings]
        self._threads = threads or os.cpu_count() or 1
        self._strict = strict
        self.parameters: Mapping[str, Parameter] = self._described_parameters()
        self.joints: Mapping[str, bool] = self._prescribed_joints()
        self.steps = sum(schedule.steps for schedule in self._schedules)

    @property
    def sheaths(self) -> list[str]:
        """Names of the model's sheaths."""
        return list(sheaths(self.model))

    def _prescribed_joints(self) -> dict[str, bool]:
        names = {name.rsplit(".", 1)[0] for name, p in self.parameters.items() if p.kind == "joint"}
        actuators = {k for schedule in self._schedules for _, k in schedule.actuators}
        driven = {
            joint
            for k in actuators
            if self.model.actuator(k).biasprm[1:3].any()
            for joint in self._moved_by(self.model.actuator(k).name)
        }
        prescribed = driven - self._measured_joints()
        prescribed |= {self.model.joint(k).name for s in self._schedules for _, k in s.joints}
        return {name: name in prescribed for name in sorted(names)}

    def _moved_by(self, actuator: str) -> set[str]:
        joint = joint_of(self.model, self.model.actuator(actuator).id)
        return {self.model.joint(joint).name} if joint >= 0 else set()

    def _measured_joints(self) -> set[str]:
        """Joints with a measured column of their place, rate or drive."""
        joints: set[str] = set()
        for channel in self.sensors.values():
            sensor = self.model.sensor(channel.name)
            kind, element = int(sensor.objtype[0]), int(sensor.objid[0])
            if kind == mujoco.mjtObj.mjOBJ_JOINT:
                joints.add(self.model.joint(element).name)
            elif kind == mujoco.mjtObj.mjOBJ_ACTUATOR:
                joints |= self._moved_by(self.model.actuator(element).name)
        return joints

    @property
    def inputs(self) -> dict[str, Channel]:
        """Driven column → its actuator or joint, or several, and unit, of all recordings."""
        return {
            column: Channel(names, column_unit(column))
            for recording in self.recordings
            for column, names in recording.drive.items()
        }

    @property
    def sensors(self) -> dict[str, Channel]:
        """Measured column → its sensor and unit, of all recordings."""
        return {
            column: Channel(measured.sensor, column_unit(column))
            for recording in self.recordings
            for column, measured in recording.measured.items()
        }

    def in_steps(self, factor: float) -> Simulator:
        """This simulator in steps ``factor`` > 0 times as long.

        No step is longer than the interval between samples, and each divides it evenly.
        """
        settle, longest = self._settle, [factor * s.clock.timestep for s in self._schedules]
        return self._with(
            Schedule(s.recording, self.model, settle, step).up_to(s.samples)
            for s, step in zip(self._schedules, longest, strict=True)
        )

    def split(self, pieces: int) -> Simulator:
        """This simulator of a model with each guide in ``pieces``, see `split_guides`.

        Itself where the model was given, and not named by the recordings, or where MuJoCo refuses
        to compile it with more guides.
        """
        if self._given:
            return self
        other = copy.copy(self)
        other._pieces = pieces
        try:
            other.model = other._load_model()
        except ValueError:
            return self
        other.model.opt.disableflags = self.model.opt.disableflags
        return other._with(
            Schedule(s.recording, other.model, self._settle, s.clock.timestep).up_to(s.samples)
            for s in self._schedules
        )

    def up_to(self, samples: Sequence[int]) -> Simulator:
        """This simulator for the first ``samples`` ≥ 1 of each recording; later ones mean nothing.

        Recordings whose rows are rests are simulated to their end.
        """
        return self._with(s.up_to(n) for s, n in zip(self._schedules, samples, strict=True))

    def _with(self, schedules: Iterable[Schedule]) -> Simulator:
        """This simulator with other schedules of the recordings."""
        other = copy.copy(self)
        other._schedules = [*schedules]
        other.steps = sum(schedule.steps for schedule in other._schedules)
        return other

    def __call__(self, parameter_sets: Sequence[Values]) -> list[list[Series]]:
        """Simulate every recording with every set of parameters.

        Returns:
            For every set, for every recording: measured column → (n,) at the samples.

        Raises:
            UnknownNameError: no such parameter, or recording after its `` @ ``, with the nearest.
            InvalidValueError: a value outside its range.
            TendonError: a simulation failed, and the simulator is strict.
        """
        jobs = self._jobs(parameter_sets)
        answers: list[list[Series]] = [[{} for _ in self.recordings] for _ in parameter_sets]
        unsolved: set[str] = set()
        with _without_timers(), nullcontext() if self._strict else suppress_mujoco_log():
            for job, (series, stuck) in zip(jobs, self._run_all(jobs), strict=True):
                unsolved |= stuck
                for (row, _), read in zip(job.readouts, series, strict=True):
                    answers[row][job.recording] = read
        if unsolved:
            warnings.warn(
                f"{UNSOLVED_WARNING} {', '.join(map(repr, sorted(unsolved)))} found no"
                " equilibrium in some evaluations, and took the best that it had",
                RuntimeWarning,
                stacklevel=2,
            )
        return answers

    def _load_model(self) -> mujoco.MjModel:
        names = list(dict.fromkeys(recording.model for recording in self.recordings))
        if not names or not all(is_same_model(names[0], other) for other in names):
            raise RecordingError(
                f"recordings of one model are needed, got {len(self.recordings)} recordings of"
                f" {', '.join(map(repr, names)) or 'none'}"
            )
        first = self.recordings[0]
        if self._pieces == 1:
            return load_recorded(first)
        return split_guides(load_spec(first.model, beside=first.beside), self._pieces)

    def _described_parameters(self) -> dict[str, Parameter]:
        parameters = Adjustable(copy.copy(self.model)).parameters()
        for recording, values in reversed([*zip(self.recordings, self._described, strict=True)]):
            try:
                Adjustable(copy.copy(self.model)).set(values)
            except (UnknownNameError, InvalidValueError) as error:
                place = f"recording {recording.name!r}, in [known], [uncertain] or [session]"
                raise RecordingError(f"{place}: {error}") from error
            parameters |= {n: parameters[n]._replace(value=float(v)) for n, v in values.items()}
        for channel in self.sensors.values():
            for name, unit in (("offset", channel.unit), ("drift", rate(channel.unit))):
                key = f"{channel.name}.{name}"
                parameters[key] = parameters[key]._replace(unit=unit)
        for column, name in (pair for recording in self.recordings for pair in recording.driven):
            key = f"{name}.command_offset"
            if parameters[key].unit == UNKNOWN:
                parameters[key] = parameters[key]._replace(unit=column_unit(column))
        return parameters

    def adjusted(self, values: Values) -> Adjustable:
        """A copy of the model with these values."""
        adjustable = Adjustable(copy.copy(self.model))
        adjustable.set(values)
        return adjustable

    def _jobs(self, parameter_sets: Sequence[Values]) -> list[_Job]:
        """Distinct simulations that answer all sets, the longest first."""
        groups: dict[tuple[int, frozenset[tuple[str, float]]], _Job] = {}
        recordings = {recording.name for recording in self.recordings}
        for row, chosen in enumerate(parameter_sets):
            for name in map(str, chosen):
                parameter = parameter_of(name)
                if parameter not in self.parameters:
                    raise UnknownNameError("parameter", name, self.parameters)
                if name != parameter and recording_of(name) not in recordings:
                    raise UnknownNameError("recording", recording_of(name), recordings, name)
            given = {name: checked_number(name, value) for name, value in chosen.items()}
            for k, described in enumerate(self._described):
                values = {**described, **values_for(self.recordings[k].name, given)}
                reads = {n: v for n, v in values.items() if self.parameters[n].kind == "sensor"}
                acts = {n: v for n, v in values.items() if n not in reads}
                job = groups.setdefault((k, frozenset(acts.items())), _Job(k, acts, []))
                job.readouts.append((row, reads))
        return sorted(groups.values(), key=lambda job: -self._schedules[job.recording].steps)

    def _run_all(self, jobs: list[_Job]) -> Iterator[tuple[list[Series], set[str]]]:
        threads = min(self._threads, len(jobs))
        if threads <= 1:
            yield from map(self._run, jobs)
            return
        pool = ThreadPoolExecutor(threads)  # MuJoCo gives the GIL away while it steps
        try:
            yield from pool.map(self._run, jobs)
        finally:
            pool.shutdown(cancel_futures=True)

    def _run(self, job: _Job) -> tuple[list[Series], set[str]]:
        """Series of every readout, and the sheaths with unsolved flows."""
        adjustable = self.adjusted(job.acting)
        schedule = self._schedules[job.recording]
        schedule.prepare(adjustable)
        model, data = adjustable.model, adjustable.data
        if self._strict:
            readings, stuck = _run_strictly(schedule, adjustable), set[str]()
        else:
            control, rests = schedule.control(adjustable), schedule.rests(adjustable)
            tried = run_open_loop(model, data, control, rests)
            readings = (
                np.full((len(control), model.nsensordata), np.nan) if tried is None else tried
            )
            stuck = set(unsolved_sheaths(model, data))
        series, plain = [], adjustable.readings.copy()
        for _, reads in job.readouts:
            adjustable.readings[:] = plain
            adjustable.set(reads)
            series.append(schedule.read_out(adjustable, readings))
        return series, stuck


def _skip_contacts(model: mujoco.MjModel) -> None:
    """Spare a model in which nothing collides the search for contacts, a tenth of the time."""
    kinds = np.bitwise_or.reduce(model.geom_contype, initial=0)
    partners = np.bitwise_or.reduce(model.geom_conaffinity, initial=0)
    if not (kinds & partners) and model.npair == 0 and model.nflex == 0:
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT.value
