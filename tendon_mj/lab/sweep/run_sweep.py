"""A sweep: rollouts over a design, in batches that go on where a killed run was."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from itertools import product
from pathlib import Path

import mujoco
import numpy as np

from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Parameter, Simulator, plain_commands, reading_unit, stated_values
from tendon_mj.lab.sweep.axes import Axis, parse_axes
from tendon_mj.lab.sweep.design import Design
from tendon_mj.lab.sweep.outputs import parse_outputs
from tendon_mj.lab.sweep.plan_file import (
    BATCH,
    Plan,
    check_plan,
    plan_digest,
    read_plan,
    recording_digest,
    write_plan,
)
from tendon_mj.lab.sweep.policy import Policy
from tendon_mj.lab.sweep.result import CSV, SweepResult
from tendon_mj.lab.sweep.rollouts import Batch, Rollouts, simulate
from tendon_mj.lab.tasks import ParquetParts, Workers, run_tasks, versions
from tendon_mj.plugin import sheaths

PLAN, TABLE = "plan.json", "rollouts"  # beside each other in the folder of a sweep
_TASK = 2.0  # longest duration of a task, as a loss of it is cheap [s]
_LEAST = 0.2  # shortest, that scheduling costs little [s]
_TASKS = 256  # as many as keep workers busy to the end
_COMBINED = 10  # axes of which all combinations of ends are checked
_CHECKED = 500  # rollouts of which the values are checked besides


class Sweep:
    """What is varied, what drives the model, and what is read off.

    Args:
        model: compiled; not changed.
        recording: that drives it, measured or of `motion_recording`.
        parameters: see `parse_axes`.
        draws: of the ranges that are no grids.
        seed: of the draws.
        outputs: see `parse_outputs`.
        measured: whether the recording has measurements. A motion has none, and its columns are
            controls: what the model says of commands, as `patch_model` writes it, is left out.
        settle: time before the first sample [s]; default: as the recording says.
        policy: that sets the controls from the first sample on; it finds those of the recording.

    Attributes:
        axes, outputs, design: what is varied, what is read off, and the values.
        units: axis → unit of its parameters.

    Raises:
        UnknownNameError, InvalidValueError: see `parse_axes`, `parse_outputs` and `Design`; draws
            or a seed below 0; a parameter of commands beside a policy.
        RecordingError: the recording does not fit the model.
        TendonError: the policy cannot be made, see `Policy.make`.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        recording: Recording,
        parameters: Sequence[str],
        *,
        draws: int = 0,
        seed: int = 0,
        outputs: Sequence[str] = (),
        measured: bool = False,
        settle: float | None = None,
        policy: Policy | None = None,
    ) -> None:
        if draws < 0:
            raise InvalidValueError(f"--draws {draws} must be ≥ 0")
        if seed < 0:
            raise InvalidValueError(f"--seed {seed} must be ≥ 0")
        known = Simulator([recording], model, described=False, settle=settle)
        self.axes = self._axes(parameters, draws, known.parameters, known.model)
        if policy is not None:
            self._check_commands(policy)
        self.design = Design(self.axes, draws, seed)
        self.units = {axis.name: known.parameters[axis.targets[0]].unit for axis in self.axes}
        self.outputs = parse_outputs(outputs, _readings(recording, known.model), measured)
        settle = recording.settle if settle is None else settle
        self.rollouts = Rollouts(
            model=known.model,
            recording=recording,
            settle=settle,
            described=({} if measured else plain_commands(model))
            | stated_values(recording, model, list(known.parameters)),
            axes={axis.name: axis.targets for axis in self.axes},
            outputs=self.outputs,
            policy=policy,
        )
        self.rollouts.prepare_policy()
        self._stated: Plan = {
            "parameters": list(parameters),
            "draws": draws,
            "seed": seed,
            "recording": f"{recording.name} {recording_digest(recording)}",
            "policy": f"{policy.name} {policy.digest}" if policy else None,
            "settle [s]": settle,
            "described": dict(self.rollouts.described),
            "outputs": [output.name for output in self.outputs],
        }

    @staticmethod
    def _axes(
        texts: Sequence[str], draws: int, known: Mapping[str, Parameter], model: mujoco.MjModel
    ) -> list[Axis]:
        tendons = {name: found.tendon for name, found in sheaths(model).items()}
        axes = parse_axes(texts, draws, known, tendons)
        for axis in axes:
            for target in axis.targets:
                least = known[target].low
                if axis.low < least:
                    raise InvalidValueError(
                        f"--parameter {axis.name}: {axis.low:g} is below {least:g}, the least that"
                        f" {target} may be"
                    )
            units = {known[target].unit: target for target in axis.targets}
            if len(units) > 1:
                each = ", ".join(f"{target} [{unit}]" for unit, target in units.items())
                raise InvalidValueError(
                    f"--parameter {axis.name} stands for parameters of different units: {each};"
                    " name those of one unit"
                )
        return axes

    def _check_commands(self, policy: Policy) -> None:
        """Refuse parameters of the commands, which a policy does not follow."""
        for axis in self.axes:
            for target in axis.targets:
                if target.rpartition(".")[2].startswith("command_"):
                    raise InvalidValueError(
                        f"--parameter {axis.name}: {target} changes what a motion commands, and"
                        f" --policy {policy} sets the controls itself"
                    )

    def check(self) -> None:
        """Set the ends of the axes, in every combination, and some rollouts, without a simulation.

        Raises:
            InvalidValueError: a value that a parameter may not have, or not beside another's.
        """
        ends = [(axis.low, axis.high) for axis in self.axes[:_COMBINED]]
        rest = [axis.low for axis in self.axes[_COMBINED:]]
        for corner in product(*ends):
            self.rollouts.check([*corner, *rest])
        total = self.design.rollouts
        for k in np.linspace(0, total - 1, min(total, _CHECKED)).round().astype(int).tolist():
            self.rollouts.check(self.design.values(k, k + 1)[0].tolist())

    @cached_property
    def plan(self) -> Plan:
        """What determines every number of the sweep."""
        return {**self._stated, **self.rollouts.identity(), **versions()}

    def batch(self, number: int, size: int) -> Batch:
        """The rollouts of a task."""
        start = number * size
        return Batch(start, self.design.values(start, min(start + size, self.design.rollouts)))

    def seconds(self) -> float:
        """Time of a rollout in this process, the first and what it prepares left out [s].

        Raises:
            InvalidValueError: a value of the first rollout is outside its range, or the policy does
                not do twice the same in it.
        """
        first = self.batch(0, 1)
        once = self.rollouts.of(first)
        begun = time.perf_counter()
        twice = self.rollouts.of(first)
        seconds = time.perf_counter() - begun
        for name, (value,) in once.items():
            if not np.array_equal(value, twice[name][0], equal_nan=True):
                raise InvalidValueError(
                    f"--policy {self.rollouts.policy}: the same rollout simulated twice differs,"
                    f" {name} = {value:g} and {twice[name][0]:g}; what a policy remembers belongs"
                    " in a class, of which each rollout makes one, and its random numbers in a"
                    " generator with a seed there"
                )
        return seconds


def run_sweep(
    sweep: Sweep,
    folder: Path,
    *,
    on: Workers | None = None,
    again: bool = False,
    begin: Callable[[], None] = lambda: None,
    progress: Progress = silent,
) -> SweepResult:
    """Simulate every rollout that has no result in the folder yet.

    Args:
        sweep: what is asked.
        folder: for the plan and the table.
        on: where to run; default: this machine's cores.
        again: begin anew, whatever is there.
        begin: called when nothing more is refused, before the folder is written to.
        progress: called with "rollouts", how many are done, and of how many.

    Raises:
        InvalidValueError: the folder holds another sweep, or, in that of its tables, one that is
            of no sweep; or a value is outside its range.
        MissingPackageError: pyarrow, or Dask where it is wanted, is not installed.
        WorkerError: see `run_tasks`.
    """
    begun = None if again else check_folder(sweep, folder)
    anew = begun is None
    if begun is None:
        sweep.check()
        begun = {**sweep.plan, BATCH: batch_size(sweep.seconds(), sweep.design.rollouts)}
    plan, size, total = begun, int(str(begun[BATCH])), sweep.design.rollouts
    numbers = {f"rollouts_{number:06d}": number for number in range(-(-total // size))}
    table = ParquetParts(folder / TABLE, plan_digest(sweep.plan), again=anew)

    def start() -> None:
        table.refuse_foreign(numbers, others=anew)
        if anew:
            table.clear()
            (folder / CSV).unlink(missing_ok=True)
            write_plan(folder / PLAN, plan)
        begin()

    run_tasks(
        simulate,
        sweep.rollouts,
        list(numbers),
        lambda key: sweep.batch(numbers[key], size),
        table,
        on=on,
        begin=start,
        progress=lambda _, done, tasks: progress("rollouts", min(done * size, total), total),
    )
    return SweepResult(sweep.axes, sweep.outputs, sweep.design.rollouts, table)


def check_folder(sweep: Sweep, folder: Path) -> Plan | None:
    """Refuse a folder that holds another sweep, or tables of none, before anything is changed.

    Returns:
        The plan that was begun there; None where there is none.

    Raises:
        InvalidValueError: names the first difference, with both values.
    """
    begun = read_plan(folder / PLAN)
    if begun is not None:
        check_plan(folder / PLAN, begun, sweep.plan)
    elif any((folder / TABLE).glob("*.parquet")):
        raise InvalidValueError(
            f"{folder / TABLE} holds tables, and there is no {PLAN} that says of which sweep; give"
            " another --out, or --again to begin anew without them"
        )
    return begun


def batch_size(seconds: float, rollouts: int) -> int:
    """Rollouts of a task: 0.2 s to 2 s of them, and where that leaves a choice 256 tasks.

    Args:
        seconds: time of one rollout [s].
        rollouts: of the sweep.
    """
    least, most = _LEAST / seconds, _TASK / seconds
    return max(1, round(min(most, max(least, rollouts / _TASKS))))


def _readings(recording: Recording, model: mujoco.MjModel) -> dict[str, str]:
    """Sensor → unit of its reading, of all that the recording measures."""
    sensors = [measured.sensor for measured in recording.measured.values()]
    return {sensor: reading_unit(model, model.sensor(sensor).id) for sensor in sensors}
