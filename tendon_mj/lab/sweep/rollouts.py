"""Rollouts of a sweep: one model and one recording, each with different parameters."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import (
    Adjustable,
    Schedule,
    suppress_mujoco_log,
    try_open_loop,
    unsolved_sheaths,
)
from tendon_mj.lab.sweep.outputs import SensorSummary, summarised
from tendon_mj.lab.sweep.policy import Policy, try_policy
from tendon_mj.models import model_digest
from tendon_mj.typing import FloatArray

ROLLOUT, FAILED, UNSOLVED = "rollout", "failed", "unsolved"


class Batch(NamedTuple):
    """Rollouts of one task: number of the first, and (rollouts, axes) values."""

    start: int
    values: FloatArray


class _Ready(NamedTuple):
    """A model with its data, its drive and the columns of its outputs."""

    adjustable: Adjustable
    schedule: Schedule
    sensors: dict[str, str]  # of the outputs → column
    measured: dict[str, FloatArray]


@dataclass(frozen=True, kw_only=True)
class Rollouts:
    """The rollouts of a sweep; each is that of `Simulator`, to the bit.

    Attributes:
        model: compiled; not changed.
        recording: that drives it; of those measured, the columns of the outputs are read off.
        settle: time before the first sample [s].
        described: parameter → value in every rollout, unless an axis sets it.
        axes: name → parameters that have its value.
        outputs: of each rollout.
        policy: that sets the controls; None: the recording alone does. Its changes of the model
            hold in that rollout alone.
    """

    model: mujoco.MjModel
    recording: Recording
    settle: float
    described: Mapping[str, float]
    axes: Mapping[str, tuple[str, ...]]
    outputs: tuple[SensorSummary, ...]
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
        if self._ready.schedule.joints:
            raise InvalidValueError(
                f"recording {self.recording.name!r} prescribes a joint, which no policy can take"
                " part in: let an actuator turn it, or leave out --policy"
            )
        self.policy.make(Adjustable(copy.copy(self.model)).model)

    @property
    def steps(self) -> int:
        """Time steps of a rollout."""
        return self._ready.schedule.steps

    @cached_property
    def _ready(self) -> _Ready:
        adjustable = Adjustable(copy.copy(self.model))
        wanted = {output.sensor for output in self.outputs}
        columns = {m.sensor: c for c, m in self.recording.measured.items() if m.sensor in wanted}
        schedule = Schedule(self.recording, adjustable.model, self.settle)
        schedule.addresses = {c: schedule.addresses[c] for c in columns.values()}
        measured = {sensor: self.recording.columns[column] for sensor, column in columns.items()}
        return _Ready(adjustable, schedule, columns, measured)

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
        self._set(self._ready.adjustable, values)

    def _set(self, adjustable: Adjustable, values: Sequence[float]) -> None:
        given = dict(self.described)
        for targets, value in zip(self.axes.values(), values, strict=True):
            given |= dict.fromkeys(targets, value)
        adjustable.set(given)

    def _one(self, values: FloatArray) -> tuple[list[float] | None, int]:
        adjustable, schedule, columns, measured = self._ready
        if self.policy is not None or schedule.joints:  # which change their model
            adjustable = Adjustable(copy.copy(self.model))
        model, data = adjustable.model, adjustable.data
        mujoco.mj_resetData(model, data)
        self._set(adjustable, values.tolist())
        schedule.prepare(adjustable)
        control = schedule.control(adjustable)
        if self.policy is None:
            readings = try_open_loop(model, data, control, schedule.rests(adjustable))
        else:
            readings = try_policy(model, data, self.policy, control, schedule.lead)
        stuck = sum(unsolved_sheaths(model, data).values())
        if readings is None:
            return None, stuck
        series = schedule.read_out(adjustable, readings)
        named = {sensor: series[column] for sensor, column in columns.items()}
        return summarised(self.outputs, named, measured), stuck


def simulate_batch(rollouts: Rollouts, batch: Batch) -> dict[str, NDArray[Any]]:
    """The table of a batch, for `run_tasks`."""
    return rollouts.of(batch)
