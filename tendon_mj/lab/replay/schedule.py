"""Schedule of a recording on a model: controls at every step, readings at every sample."""

from __future__ import annotations

import copy
import math
import warnings
from collections.abc import Collection, Mapping
from typing import NamedTuple

import mujoco
import numpy as np

from tendon_mj.errors import RecordingError, TendonError, TendonWarning, UnknownNameError
from tendon_mj.lab.noise import least_motion
from tendon_mj.lab.parameter_names import expand
from tendon_mj.lab.recordings import Recording, Session, Uncertain
from tendon_mj.lab.replay.parameters import Adjustable, Parameter
from tendon_mj.lab.replay.patch import read_intervals
from tendon_mj.lab.replay.readout import Readout, Sense, make_clock, sense_of
from tendon_mj.lab.replay.units import reading_unit
from tendon_mj.lab.units import (
    NOT_NEGATIVE,
    POSITIVE_NUMBER,
    ROUNDING,
    column_unit,
    name_in,
    quantity,
)
from tendon_mj.models import load_model
from tendon_mj.typing import FloatArray

_MOST_STEPS = 20_000_000  # some minutes
_MOVE = 0.25  # of the settling time, in steps of the model's; in shorter steps a move is slower
_SHORTEST_MOVE, _LONGEST_MOVE = 1.0, 10.0  # likewise [s]
_RIGID = 1e15  # armature of a joint that is prescribed [kg m² or kg]: no load moves it
_PRESCRIBED = (mujoco.mjtJoint.mjJNT_HINGE.value, mujoco.mjtJoint.mjJNT_SLIDE.value)


class Rests(NamedTuple):
    """Rests of a run, of which the steps are left out in which nothing moves any more."""

    ends: Mapping[int, float]  # step at which a rest ends → time there [s]
    spans: FloatArray  # (nsensordata,) range of each reading, infinite if it does not count


class Schedule:
    """Schedule of one recording on one model; it does not depend on parameters.

    Rows that are rests are simulated as moves from rest to rest, whatever their times: with the
    model's own step h_0 each move takes a quarter of the settling time, 1 s to 10 s, then the
    settling time passes, and the row is read. With step h a move takes h_0/h times as long, so any
    dependence on its speed shows as a step error.

    ``settle``: time before the first sample [s]; with 0 the model starts in its reference pose;
    None: that of the recording. ``timestep``: longest step allowed [s]; None: the model's.
    """

    def __init__(
        self,
        recording: Recording,
        model: mujoco.MjModel,
        settle: float | None,
        timestep: float | None = None,
    ) -> None:
        settle = recording.settle if settle is None else settle
        NOT_NEGATIVE.check("settle", settle, "s")
        longest = model.opt.timestep if timestep is None else timestep
        POSITIVE_NUMBER.check("timestep", longest, "s")
        self.recording = recording
        # (column, id) of the actuators that it drives, and of the joints that it prescribes
        self.actuators, self.joints = _driven(recording, model)
        # measured column → sensor and its place in `mjData.sensordata`
        self.addresses = _sensor_addresses(recording, model)
        times = recording.time
        self._move = self._between = 0.0
        if recording.settling_time is not None:
            move = np.clip(_MOVE * recording.settling_time, _SHORTEST_MOVE, _LONGEST_MOVE)
            self._move = float(move) * model.opt.timestep / longest
            self._between = self._move + recording.settling_time
            times = self._between * np.arange(recording.time.size, dtype=np.float64)
            settle = max(settle, self._between) if settle > 0.0 else 0.0
        self.clock = make_clock(times, longest)  # steps from the first sample to the last
        lead = settle / self.clock.timestep * (1.0 - 1e-9)
        if lead + self.clock.steps > _MOST_STEPS:
            raise RecordingError(
                f"recording {recording.name!r}: its typical interval between samples gives steps of"
                f" {self.clock.timestep:g} s, {lead + self.clock.steps:.9g} in all, of which"
                f" {lead:.6g} in the settle of {settle:g} s before the first sample; more than"
                f" {_MOST_STEPS} are not simulated; are the times in seconds, and settle too?"
            )
        self.lead = math.ceil(lead)  # steps before the first sample
        self.samples = recording.time.size  # that are simulated, from the first
        self._drive = {column: self._on_grid(column) for column in recording.drive}
        self._recorded = self.clock.time  # times of the recording at the steps
        if self._move:
            self._recorded = np.interp(self.clock.time, times, recording.time)
        # (driven column, its sense) → where settling begins, and the sense of motion
        self._senses: dict[tuple[str, float], tuple[float | None, Sense]] = {}

    def up_to(self, samples: int) -> Schedule:
        """This schedule for the first ``samples`` ≥ 1, or for all where rows are rests.

        Readings of later samples mean nothing.
        """
        shorter = copy.copy(self)
        shorter.samples = self.samples if self._move else samples
        return shorter

    def _on_grid(self, column: str) -> FloatArray:
        """(clock.steps+1,) driven column between its samples, without the flicker of its steps."""
        grid, series = self.clock.time, self.recording.columns[column]
        if self._move:
            places = np.arange(grid.size) / self.clock.steps * (series.size - 1)
            before = np.minimum(places.astype(np.int64), series.size - 2)
            since = (places - before) * self._between
            share = _smooth(since / self._move)
            moves: FloatArray = series[before] + share * np.diff(series)[before]
            return np.where(share < 1.0, moves, series[before + 1])  # at rest to the bit
        if column in self.recording.hold:
            return _held(grid, self.recording.time, series, self.clock.timestep)
        return np.interp(grid, self.recording.time, least_motion(series))

    @property
    def steps(self) -> int:
        """From the start of settling to the last sample that is read."""
        last = int(self.clock.places[self.samples - 1]) + 1
        return self.lead + min(last, self.clock.steps)

    def prepare(self, adjustable: Adjustable) -> None:
        """Make a model ready: its step, its clock, 0 at the first sample, and prescribed joints.

        A prescribed joint starts where it is prescribed to be, with an armature that no load moves.
        """
        model, data = adjustable.model, adjustable.data
        model.opt.timestep = self.clock.timestep
        data.time = -self.lead * self.clock.timestep
        for column, joint in self.joints:
            dof, place = model.jnt_dofadr[joint], model.jnt_qposadr[joint]
            model.dof_armature[dof] = model.dof_M0[dof] = _RIGID  # the second: of simple bodies
            model.dof_invweight0[dof] = 1.0 / _RIGID
            model.jnt_limited[joint] = 0  # a limit stops any inertia
            data.qpos[place] = self._path(adjustable, column, joint)[0]

    def control(self, adjustable: Adjustable) -> FloatArray:
        """(steps+1, nu) controls: the ramp and rest before the first sample, then the drive.

        If joints are prescribed (steps+1, nu+nv), with the applied forces on their armature, by
        which Euler's step leads to the position at the next one:

            v_k = (q_k − q_{k−1})/h,   force_k = armature (v_{k+1} − v_k)/h.
        """
        model = adjustable.model
        width = model.nu + (model.nv if self.joints else 0)
        control = np.zeros((self.lead + self.clock.steps + 1, width))
        for column, actuator in self.actuators:
            command, event = adjustable.commands[actuator, :3], self._slip(adjustable, actuator)
            led = self._led(column, command, 0.0, event)
            control[:, model.actuator_ctrladr[actuator]] = led
        for column, joint in self.joints:
            path = self._path(adjustable, column, joint)
            speed = np.diff(path, prepend=path[0]) / self.clock.timestep
            force = _RIGID * np.diff(speed) / self.clock.timestep
            control[:-1, model.nu + model.jnt_dofadr[joint]] = force
        return control[: self.steps + 1]

    def _path(self, adjustable: Adjustable, column: str, joint: int) -> FloatArray:
        """(lead+clock.steps+1,) positions of a joint that a column prescribes [rad or m]."""
        rest = adjustable.model.qpos0[adjustable.model.jnt_qposadr[joint]]
        return self._led(column, adjustable.joint_commands[joint], float(rest))

    def _slip(self, adjustable: Adjustable, actuator: int) -> FloatArray | float:
        """Slip that an actuator's command has gone through [of its control]; 0 without one."""
        slip, since, duration = adjustable.commands[actuator, 3:].tolist()
        if slip == 0.0:
            return 0.0
        ends, lasts = since + duration, max(duration, self.clock.timestep)  # a step to its end
        gone: FloatArray = slip * np.clip(1.0 + (self._recorded - ends) / lasts, 0.0, 1.0)
        return gone

    def _led(
        self, column: str, command: FloatArray, rest: float, event: FloatArray | float = 0.0
    ) -> FloatArray:
        """(lead+clock.steps+1,) driven column, scaled, offset and delayed; a ramp from ``rest``."""
        scale, offset, delay = command.tolist()
        grid, recorded = self.clock.time, self._drive[column]
        if delay > 0.0:
            recorded = np.interp(grid - delay, grid, recorded)  # before, it is its first value
        drive = scale * recorded + offset + event
        settling = np.arange(1, self.lead + 1, dtype=np.float64)
        if self._move:
            ramp = _smooth(settling * self.clock.timestep / self._move)
        else:
            ramp = np.minimum(1.0, settling / max(1, self.lead // 2))
        return np.concatenate([rest + ramp * (drive[0] - rest), drive])

    def rests(self, adjustable: Adjustable) -> Rests | None:
        """Rests of a run, once readings are set; None if rows are samples of a motion."""
        if not self._move:
            return None
        ends = self.lead + np.rint(self.clock.places).astype(int)
        times = self.recording.time - self.recording.time[0]
        spans = np.full(adjustable.model.nsensordata, np.inf)
        for column, (sensor, address) in self.addresses.items():
            span, scale = np.ptp(self.recording.columns[column]), adjustable.readings[sensor, 0]
            if span > 0.0 and scale != 0.0:
                spans[address] = min(spans[address], span / abs(scale))
        return Rests(dict(zip(ends.tolist(), times.tolist(), strict=True)), spans)

    def read_out(self, adjustable: Adjustable, readings: FloatArray) -> dict[str, FloatArray]:
        """(n,) of every measured column, from the (steps+1, nsensordata) readings."""
        missing = self.lead + self.clock.steps - self.steps
        series = {}
        for column, (sensor, address) in self.addresses.items():
            readout = Readout(*adjustable.readings[sensor].tolist())
            shown = np.pad(readings[self.lead :, address], (0, missing), "edge")
            sense, measured = self._sense(adjustable, sensor), self.recording.columns[column]
            series[column] = readout.of(shown, self.clock, self.recording.time, sense, measured)
        return series

    def _sense(self, adjustable: Adjustable, sensor: int) -> Sense | None:
        """Sense of motion of the drive that bears the load of a sensor, if there is one."""
        bearing = adjustable.geared.get(sensor, {})
        for column, actuator in self.actuators if bearing else []:
            if actuator in bearing:
                scale, offset = adjustable.commands[actuator, :2].tolist()
                way = bearing[actuator] * float(np.sign(scale))
                # settling leads from a control of 0 to the first one
                begin = -way * offset / scale if self.lead and scale else None
                if self._senses.get((column, way), (math.nan,))[0] != begin:
                    place = way * self.recording.columns[column]
                    sense = sense_of(self.recording.time, place, begin)
                    self._senses[column, way] = begin, sense
                return self._senses[column, way][1]
        return None

    def when(self, step: int) -> str:
        """Time of a step, as text for a message."""
        if step < self.lead:
            before = (self.lead - step) * self.clock.timestep
            return f"{before:.6g} s before the first sample, settling"
        return f"at time {self.clock.time[step - self.lead]:.6g} s"

    @property
    def where(self) -> str:
        """Name of the simulation, as text for a message."""
        return f"replay of {self.recording.name!r} on model {self.recording.model!r}"


def _smooth(share: FloatArray) -> FloatArray:
    """Share of a move at a share x of its time, 1 - (1 - x)⁴ (1 + 4 x).

    It starts softly and ends slowly: the last motion decides on the friction at rest.
    """
    rest = 1.0 - np.clip(share, 0.0, 1.0)
    return 1.0 - rest**4 * (5.0 - 4.0 * rest)


def _held(grid: FloatArray, time: FloatArray, series: FloatArray, timestep: float) -> FloatArray:
    """Series at times of the grid, each sample kept until the next; a step's rounding is none."""
    latest = np.searchsorted(time, grid + ROUNDING * timestep, side="right") - 1
    return series[np.maximum(latest, 0)]


def described_values(recording: Recording, names: Collection[str]) -> dict[str, float]:
    """Known values and guesses of a recording's description; ``names`` are of all parameters."""
    guesses: dict[str, Uncertain | Session] = {**recording.session, **recording.uncertain}
    try:
        return {
            **{name: guess.value for name, guess in expand(guesses, names).items()},
            **expand(recording.known, names),
        }
    except UnknownNameError as error:
        raise RecordingError(f"recording {recording.name!r}: {error}") from error


def stated_values(
    recording: Recording,
    model: mujoco.MjModel,
    parameters: Mapping[str, Parameter],
    described: bool | None = None,
    *,
    given: bool = False,
) -> dict[str, float]:
    """Parameters that a recording's description sets on a model; ``parameters`` are the model's.

    ``given``: whether the model is in place of the one that the recording names. ``described`` says
    whether ``known``, ``uncertain`` and ``session`` are applied. False: only to columns (commands
    and sensors) of which the model states nothing. None: all; but

    * if ``model`` carries intervals of a diagnosis, neither those parameters nor ``uncertain``;
    * else a model that is given keeps its values instead of ``uncertain``, and instead of ``known``
      and ``session`` if it differs there from the model that the recording names.

    Warns:
        TendonWarning: a model that is given keeps other values than the description's.
    """
    values = described_values(recording, parameters)
    uncertain = expand(recording.uncertain, parameters)
    if described is None and (intervals := read_intervals(model)):
        return {name: v for name, v in values.items() if name not in {*intervals, *uncertain}}
    if described or (described is None and not given):
        return values
    differ = {name for name, v in values.items() if v != parameters[name].value}
    kept = {name for name in differ if not parameters[name].is_plain(name)}
    if described is None:
        own = _named_model(recording) if kept - uncertain.keys() else {}
        kept &= {*uncertain, *(n for n in own if n in kept and own[n] != parameters[n].value)}
        _warn_of_kept(recording, {n: (values[n], parameters[n]) for n in sorted(kept)})
    return {name: value for name, value in values.items() if name not in kept}


def _named_model(recording: Recording) -> dict[str, float]:
    """Parameter → value of the model that a recording names; none if that cannot be loaded."""
    try:
        named = Adjustable(load_model(recording.model, beside=recording.beside))
    except TendonError:
        return {}
    return {name: parameter.value for name, parameter in named.parameters().items()}


def _warn_of_kept(recording: Recording, kept: Mapping[str, tuple[float, Parameter]]) -> None:
    if kept:
        listed = ", ".join(
            f"{name} = {quantity(model.value, model.unit)} (description:"
            f" {quantity(value, model.unit)})"
            for name, (value, model) in kept.items()
        )
        warnings.warn(
            f"recording {recording.name!r}: the given model keeps {listed}; described=True"
            " (--values-of description) applies the description's",
            TendonWarning,
            stacklevel=4,
        )


def _driven(
    recording: Recording, model: mujoco.MjModel
) -> tuple[list[tuple[str, int]], list[tuple[str, int]]]:
    """Columns with the actuators and with the joints that they drive; an actuator's name first."""
    actuators = {model.actuator(k).name: k for k in range(model.nactuator)}
    joints = {
        name: k
        for k in range(model.njnt)
        if model.jnt_type[k] in _PRESCRIBED and (name := model.joint(k).name) not in actuators
    }
    sensors = {model.sensor(k).name for k in range(model.nsensor)}
    recording.check_against({*actuators, *joints} - {""}, sensors - {""})
    prescribed = [(c, joints[name]) for c, name in recording.driven if name in joints]
    if prescribed and model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4.value:
        raise RecordingError(
            f"recording {recording.name!r}, [drive] {recording.written(prescribed[0][0])!r}: the"
            " model's integrator RK4 follows no prescribed joint; take implicitfast"
        )
    return [(c, actuators[name]) for c, name in recording.driven if name in actuators], prescribed


def _sensor_addresses(recording: Recording, model: mujoco.MjModel) -> dict[str, tuple[int, int]]:
    sensors = {model.sensor(k).name: k for k in range(model.nsensor)}
    addresses = {}
    for column, measured in recording.measured.items():
        sensor, written = sensors[measured.sensor], recording.written(column)
        if model.sensor_dim[sensor] != 1:
            raise RecordingError(
                f"recording {recording.name!r}, [measured] {written!r}: sensor {measured.sensor!r}"
                f" reads {model.sensor_dim[sensor]} numbers, but a column holds one"
            )
        unit = reading_unit(model, sensor)
        if unit != column_unit(column) and name_in(unit, column):
            raise RecordingError(
                f"recording {recording.name!r}, [measured] {written!r}: sensor {measured.sensor!r}"
                f" reads [{unit}]; the column would be {name_in(unit, column)!r}"
            )
        addresses[column] = (sensor, int(model.sensor_adr[sensor]))
    return addresses
