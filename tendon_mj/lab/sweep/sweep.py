"""A sweep: rollouts over a design, in batches that go on where a killed run was; its results."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pandas
from numpy.typing import NDArray

from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.parquet_parts import ParquetParts
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Parameter, Simulator, plain_commands, reading_unit, stated_values
from tendon_mj.lab.sweep.design import (
    FEWEST_ROLLOUTS,
    Axis,
    Design,
    SensorSummary,
    parse_axes,
    parse_outputs,
    share_of_variance,
)
from tendon_mj.lab.sweep.rollouts import FAILED, UNSOLVED, Batch, Policy, Rollouts
from tendon_mj.lab.workers import Workers, run_tasks, versions
from tendon_mj.plugin import sheaths
from tendon_mj.whole_file import whole_file

Plan = Mapping[str, object]

PLAN, TABLE, CSV = "plan.json", "rollouts", "table.csv"  # in the folder of a sweep
_BATCH = "rollouts a task"  # of a plan: it may differ, as it changes no number
_TASK = 2.0  # longest duration of a task, as a loss of it is cheap [s]
_LEAST = 0.2  # shortest, that scheduling costs little [s]
_TASKS = 256  # as many as keep workers busy to the end
_COMBINED = 10  # axes of which all combinations of ends are checked
_CHECKED = 500  # rollouts of which the values are checked besides
_DRAWN = 4  # axes and outputs of a picture
_MOST_ROWS = 10_000  # of a CSV
_READ = 16  # columns at a time: a table has a file a task, and may be larger than memory


class Sweep:
    """Axes, drive and outputs of rollouts of a model.

    ``parameters`` are as of `parse_axes`, ``outputs`` as of `parse_outputs`; the model is not
    changed. A recording that is not ``measured`` is a motion, of which the columns are controls:
    the scale, offset and delay that `patch_model` wrote do not apply. A policy sets the controls
    from the first sample on, where it finds those of the recording.
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
            | stated_values(recording, model, known.parameters),
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
        tendons = {name: sheath.tendon for name, sheath in sheaths(model).items()}
        axes = parse_axes(texts, draws, known, tendons)
        for axis in axes:
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
                        f"--parameter {axis.name}: {target} changes the command of a motion, and"
                        f" --policy {policy} sets the controls itself"
                    )

    def check(self) -> None:
        """Set every combination of the axes' ends, and some rollouts, without a simulation."""
        ends = [(axis.low, axis.high) for axis in self.axes[:_COMBINED]]
        rest = [axis.low for axis in self.axes[_COMBINED:]]
        for corner in product(*ends):
            self.rollouts.check([*corner, *rest])
        total = self.design.rollouts
        for k in np.linspace(0, total - 1, min(total, _CHECKED)).round().astype(int).tolist():
            self.rollouts.check(self.design.values(k, k + 1)[0].tolist())

    @cached_property
    def plan(self) -> Plan:
        """Everything that determines the numbers of the sweep."""
        return {**self._stated, **self.rollouts.identity(), **versions()}

    def batch(self, number: int, size: int) -> Batch:
        """Rollouts of a task."""
        start = number * size
        return Batch(start, self.design.values(start, min(start + size, self.design.rollouts)))

    def seconds(self) -> float:
        """Time of a rollout in this process, without the preparations of the first [s]."""
        first = self.batch(0, 1)
        once = self.rollouts.of(first)
        begun = time.perf_counter()
        twice = self.rollouts.of(first)
        seconds = time.perf_counter() - begun
        for name, (value,) in once.items():
            if not np.array_equal(value, twice[name][0], equal_nan=True):
                raise InvalidValueError(
                    f"--policy {self.rollouts.policy}: the same rollout simulated twice differs,"
                    f" {name} = {value:g} and {twice[name][0]:g}; the memory of a policy belongs"
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
    """Simulate every rollout that has no result in the folder yet, or all ``again``.

    ``begin`` is called when nothing more is refused, before the folder is written to.
    """
    begun, total = None if again else check_folder(sweep, folder), sweep.design.rollouts
    anew = begun is None
    if begun is None:
        sweep.check()
        begun = {**sweep.plan, _BATCH: batch_size(sweep.seconds(), total)}
    plan, size = begun, int(str(begun[_BATCH]))
    numbers = {f"rollouts_{number:06d}": number for number in range(-(-total // size))}
    table = ParquetParts(folder / TABLE, _digest(json.dumps(sweep.plan).encode()), again=anew)

    def start() -> None:
        if anew:
            table.clear()
            (folder / CSV).unlink(missing_ok=True)
            with whole_file(folder / PLAN) as made:
                text = json.dumps(plan, indent=1, ensure_ascii=False) + "\n"
                made.write_text(text, encoding="utf-8")
        begin()

    run_tasks(
        Rollouts.of,
        sweep.rollouts,
        list(numbers),
        lambda key: sweep.batch(numbers[key], size),
        table,
        on=on,
        begin=start,
        progress=lambda _, done, tasks: progress("rollouts", min(done * size, total), total),
    )
    return SweepResult(sweep.axes, sweep.outputs, total, table)


def check_folder(sweep: Sweep, folder: Path) -> Plan | None:
    """The plan that was begun in a folder, None if there is none.

    Another plan, or tables without one, are refused.
    """
    path = folder / PLAN
    if not path.exists():
        if any((folder / TABLE).glob("*.parquet")):
            raise InvalidValueError(
                f"{folder / TABLE} holds tables, without the {PLAN} of their sweep; give"
                " another --out, or --again to begin again without them"
            )
        return None
    try:
        begun: dict[str, object] = dict(json.loads(path.read_text(encoding="utf-8")))
        int(str(begun[_BATCH]))
    except (OSError, ValueError, TypeError, LookupError, RecursionError) as error:
        raise InvalidValueError(
            f"{path} cannot be read ({error}); give another --out, or --again to begin again"
        ) from error
    wanted = json.loads(json.dumps(sweep.plan))
    for name in [*wanted, *begun]:
        if name != _BATCH and begun.get(name) != wanted.get(name):
            raise InvalidValueError(
                f"{folder} holds another sweep: {name} is {begun.get(name)} there and"
                f" {wanted.get(name)} here; give another --out, or --again to begin again"
            )
    return begun


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:16]


def recording_digest(recording: Recording) -> str:
    """16 hexadecimal digits of the drive and the measurements of a recording."""
    parts = [recording.time.tobytes(), repr(sorted(recording.hold)).encode()]
    read = {column: measured.sensor for column, measured in recording.measured.items()}
    for name, element in [*recording.driven, *read.items()]:
        parts += [f"{name} {element}".encode(), recording.columns[name].tobytes()]
    return _digest(b"".join(parts))


def batch_size(seconds: float, rollouts: int) -> int:
    """Rollouts of a task, each of so many seconds: 0.2 s to 2 s, with a choice 256 tasks."""
    least, most = _LEAST / seconds, _TASK / seconds
    return max(1, round(min(most, max(least, rollouts / _TASKS))))


def _readings(recording: Recording, model: mujoco.MjModel) -> dict[str, str]:
    """Sensor → unit of its reading, of all that the recording measures."""
    sensors = [measured.sensor for measured in recording.measured.values()]
    return {sensor: reading_unit(model, model.sensor(sensor).id) for sensor in sensors}


@dataclass(frozen=True)
class SweepResult:
    """Results of a sweep, on disk."""

    # of the sweep
    axes: Sequence[Axis]
    outputs: Sequence[SensorSummary]
    rollouts: int  # number of rows
    table: ParquetParts  # `rollout`, axes, outputs, `failed`, `unsolved`; a row a rollout

    def __repr__(self) -> str:
        axes = ", ".join(axis.name for axis in self.axes)
        return f"SweepResult({self.rollouts} rollouts over {axes}; {len(self.outputs)} outputs)"

    def to_dataframe(self) -> pandas.DataFrame:
        """The table, a row a rollout: axes and outputs in SI units, `failed` and `unsolved`."""
        return pandas.DataFrame(self.table.read())

    def column(self, name: str) -> NDArray[Any]:
        """A column of the table, (rollouts,)."""
        return self.table.read([name])[name]

    @cached_property
    def solid(self) -> NDArray[np.bool_]:
        """(rollouts,) whether each stayed stable."""
        return ~self.column(FAILED).astype(bool)

    @cached_property
    def unsolved(self) -> int:
        """Rollouts in which a sheath found no equilibrium at some time."""
        return int((self.column(UNSOLVED) > 0).sum())

    @cached_property
    def summaries(self) -> dict[str, dict[str, Any]]:
        """Output → range, mean and standard deviation, and share of variance of each axis.

        Of fewer than 5 stable rollouts there are no shares.
        """
        varied = self.table.read([axis.name for axis in self.axes])
        varied = {name: values[self.solid] for name, values in varied.items()}
        drawn = [axis.name for axis in self.axes if axis.grid is None]
        summaries = {}
        for first in range(0, len(self.outputs), _READ):
            some = self.outputs[first : first + _READ]
            columns = self.table.read([output.name for output in some])
            for output in some:
                values = columns[output.name][self.solid]
                summary = _summary(values, varied, drawn)
                summaries[output.name] = {"unit": output.unit, **summary}
        return summaries

    def drawn(self) -> tuple[Sequence[Axis], list[SensorSummary]]:
        """The axes and outputs of a picture, four of each at most.

        Of each sensor it is the first of error, max, rms, … there is; forces come first, and
        constant ones are left out.
        """
        ranks = {"error": 0, "max": 1, "rms": 2, "final": 3, "mean": 4, "min": 5}
        first: dict[str, SensorSummary] = {}
        for output in sorted(self.outputs, key=lambda o: ranks[o.summary]):
            first.setdefault(output.sensor, output)
        forces_first = sorted(first.values(), key=lambda o: o.unit != "N")
        varying = [o for o in forces_first if self.summaries[o.name].get("std", 0.0) > 0.0]
        return self.axes[:_DRAWN], varying[:_DRAWN]

    def write_csv(self, path: Path) -> Path | None:
        """Write the table as CSV if it has at most 10,000 rows; return its path if so."""
        if self.rollouts > _MOST_ROWS:
            return None
        with whole_file(path) as made:
            self.to_dataframe().to_csv(made, index=False)
        return path


def _summary(
    values: NDArray[Any], varied: dict[str, NDArray[Any]], drawn: Sequence[str]
) -> dict[str, Any]:
    """Of the values of an output; nothing if every rollout failed."""
    if not len(values):
        return {}
    return {
        "min": float(values.min()),
        "max": float(values.max()),
        "mean": float(values.mean()),
        "std": float(values.std()),
        "share_of_variance": {
            name: share_of_variance(given, values, len(drawn) if name in drawn else 0)
            for name, given in (varied.items() if len(values) >= FEWEST_ROLLOUTS else ())
        },
    }
