"""Many simulations of the same recordings, each with different parameters, on all cores."""

from __future__ import annotations

import copy
import os
import warnings
from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from types import MappingProxyType
from typing import NamedTuple, Protocol

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.attach import checked_number
from tendon_mj.errors import InvalidValueError, RecordingError, UnknownNameError
from tendon_mj.lab.recordings import Recording, is_same_model
from tendon_mj.lab.replay.names import parameter_of, recording_of, values_for
from tendon_mj.lab.replay.parameters import Adjustable, Parameter, joint_of
from tendon_mj.lab.replay.schedule import Schedule, described_values
from tendon_mj.lab.replay.simulation import (
    UNSOLVED_WARNING,
    run_open_loop,
    suppress_mujoco_log,
    try_open_loop,
    unsolved_sheaths,
)
from tendon_mj.lab.replay.units import column_unit, rate
from tendon_mj.models import load_model
from tendon_mj.plugin import sheaths

Values = Mapping[str, float]
Series = dict[str, NDArray[np.float64]]


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
        steps: time steps of one simulation of all recordings; 0 where it makes no error of steps.
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
        """This simulator in steps ``factor`` > 0 times as long; itself where ``steps`` is 0.

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
    whatever else is in the call. Sets that differ in their sensors only share simulations.

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
        self.model = copy.copy(model) if model is not None else self._load_model()
        if _collides_never(self.model):  # saves looking for contacts, a tenth of the time
            self.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT.value
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
        other = copy.copy(self)
        other._schedules = [
            Schedule(schedule.recording, self.model, self._settle, factor * schedule.clock.timestep)
            for schedule in self._schedules
        ]
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
        with nullcontext() if self._strict else suppress_mujoco_log():
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
        return load_model(names[0], beside=self.recordings[0].beside)

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
            parameters[key] = parameters[key]._replace(unit=column_unit(column))
        return parameters

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
        schedule = self._schedules[job.recording]
        adjustable = Adjustable(copy.copy(self.model))  # of its own, so that no earlier one shows
        adjustable.set(job.acting)
        schedule.prepare(adjustable)
        model, data = adjustable.model, adjustable.data
        control, plain = schedule.control(adjustable), adjustable.readings.copy()
        rests = schedule.rests(adjustable)
        if self._strict:
            readings = run_open_loop(
                model, data, control, schedule.where, schedule.when, rests=rests
            )
        else:
            tried = try_open_loop(model, data, control, rests)
            shape = (len(control), model.nsensordata)
            readings = tried if tried is not None else np.full(shape, np.nan)
        series = []
        for _, reads in job.readouts:
            adjustable.readings[:] = plain
            adjustable.set(reads)
            series.append(schedule.read_out(adjustable, readings))
        stuck = set() if self._strict else set(unsolved_sheaths(model, data))
        return series, stuck


def _collides_never(model: mujoco.MjModel) -> bool:
    kinds = np.bitwise_or.reduce(model.geom_contype, initial=0)
    partners = np.bitwise_or.reduce(model.geom_conaffinity, initial=0)
    return not (kinds & partners) and model.npair == 0 and model.nflex == 0
