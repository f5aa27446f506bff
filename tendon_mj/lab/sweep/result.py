"""Results of a sweep, read from its table on disk."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas
from numpy.typing import NDArray

from tendon_mj.lab.sweep.axes import Axis
from tendon_mj.lab.sweep.influence import FEWEST, share_of_variance
from tendon_mj.lab.sweep.outputs import Output
from tendon_mj.lab.sweep.rollouts import FAILED, UNSOLVED
from tendon_mj.lab.tasks import ParquetParts
from tendon_mj.whole_file import whole_file

CSV = "table.csv"  # beside the table, where it is small
_DRAWN = 4  # axes and outputs of a picture
_MOST_ROWS = 10_000  # of a CSV
_READ = 16  # columns at a time: a table has a file a task, and may be larger than memory


@dataclass(frozen=True)
class SweepResult:
    """Results of a sweep, on disk.

    Attributes:
        axes, outputs: what was varied, and what was read off.
        rollouts: number of rows.
        table: `rollout`, axes, outputs, `failed`, `unsolved`; a row a rollout.
    """

    axes: Sequence[Axis]
    outputs: Sequence[Output]
    rollouts: int
    table: ParquetParts

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
        """Output → range, mean and standard deviation, and what each axis accounts for.

        Of fewer than 5 stable rollouts no axis is said to account for anything.
        """
        varied = self.table.read([axis.name for axis in self.axes])
        varied = {name: values[self.solid] for name, values in varied.items()}
        drawn = [axis.name for axis in self.axes if axis.drawn]
        found = {}
        for first in range(0, len(self.outputs), _READ):
            some = self.outputs[first : first + _READ]
            columns = self.table.read([output.name for output in some])
            for output in some:
                values = columns[output.name][self.solid]
                found[output.name] = {"unit": output.unit, **_summary(values, varied, drawn)}
        return found

    def drawn(self) -> tuple[Sequence[Axis], list[Output]]:
        """The axes and outputs of a picture, four of each at most.

        Of each sensor it is the first of error, max, rms, … there is; forces come first, and
        what does not vary is left out.
        """
        ranks = {"error": 0, "max": 1, "rms": 2, "final": 3, "mean": 4, "min": 5}
        first: dict[str, Output] = {}
        for output in sorted(self.outputs, key=lambda o: ranks[o.summary]):
            first.setdefault(output.sensor, output)
        forces_first = sorted(first.values(), key=lambda o: o.unit != "N")
        found = [o for o in forces_first if self.summaries[o.name].get("std", 0.0) > 0.0]
        return self.axes[:_DRAWN], found[:_DRAWN]

    def write_csv(self, path: Path) -> Path | None:
        """Write the table as CSV where it has at most 10,000 rows; return its path if so."""
        if self.rollouts > _MOST_ROWS:
            return None
        with whole_file(path) as made:
            pandas.DataFrame(self.table.read()).to_csv(made, index=False)
        return path


def _summary(
    values: NDArray[Any], varied: dict[str, NDArray[Any]], drawn: Sequence[str]
) -> dict[str, Any]:
    """Of the values of an output; nothing where every rollout failed."""
    if not len(values):
        return {}
    told = varied if len(values) >= FEWEST else {}
    return {
        "min": float(values.min()),
        "max": float(values.max()),
        "mean": float(values.mean()),
        "std": float(values.std()),
        "share_of_variance": {
            name: share_of_variance(given, values, len(drawn) if name in drawn else 0)
            for name, given in told.items()
        },
    }
