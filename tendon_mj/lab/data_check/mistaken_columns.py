"""Checks for mistaken columns: degrees as radians, or the samples of another one."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from tendon_mj.lab.data_check import thresholds as limits
from tendon_mj.lab.data_check.column import columns_of
from tendon_mj.lab.data_check.faults import DataWarning
from tendon_mj.lab.data_check.jumps import Replay
from tendon_mj.lab.recordings import Recording
from tendon_mj.typing import FloatArray

_DEGREES = math.degrees(1.0)


def degree_warnings(
    recording: Recording, simulated: Recording | None, simulate: Replay
) -> list[DataWarning]:
    """Warn of driven columns in rad that hold degrees, and of measured ones that do so too.

    They do if the model is off by more than a column's range, and comes much nearer when they are
    taken as degrees. ``simulated``: at the numbers that the description states, None if that was
    unstable; ``simulate``: the same for another recording.
    """
    angles = [c for c in columns_of(recording) if c.unit == "rad"]
    angles = [c for c in angles if c.name not in recording.in_file]
    driven = {c.name for c in angles if c.driven and np.ptp(c.read) > limits.TURNED}
    before, _ = _misfit(recording, simulated, set())
    if not driven or before <= 1.0:
        return []
    columns = {c: s / _DEGREES if c in driven else s for c, s in recording.columns.items()}
    degrees = simulate(replace(recording, columns=columns))
    after, turned = _misfit(recording, degrees, {c.name for c in angles})
    if after > min(1.0, before / limits.ALL):
        return []
    nearer = f"{before / after:.0f} times " if 0.0 < after < before < np.inf else ""
    return [
        column.warn(
            "unit",
            f"moves by {np.ptp(column.read):.3g} rad; taken as degrees, the model comes"
            f" {nearer}nearer to the readings",
            f"if these are degrees, name the column {column.name.removesuffix('rad') + 'deg'!r}",
        )
        for column in angles
        if column.name in driven | turned
    ]


def _misfit(
    recording: Recording, simulated: Recording | None, angles: set[str]
) -> tuple[float, set[str]]:
    """Mean rms error of the measured columns over their range; those of ``angles`` in degrees."""
    if simulated is None or not recording.measured:
        return (np.inf if simulated is None else 0.0), set()
    names = list(recording.measured)
    errors = _errors(recording, simulated, names)
    scaled = {c: recording.columns[c] / _DEGREES for c in angles}
    columns = {**recording.columns, **scaled}
    in_degrees = _errors(replace(recording, columns=columns), simulated, names)
    turned = {c for c, less in zip(names, in_degrees < errors, strict=True) if less}
    return float(np.minimum(errors, in_degrees).mean()), turned


def _errors(
    recording: Recording, simulated: Recording, names: Sequence[str], *, zeros: bool = True
) -> FloatArray:
    """The rms error of each of some measured columns over its range, with the zeros or without."""
    errors = [recording.columns[c] - simulated.columns[c] for c in names]
    ranges = [np.ptp(recording.columns[c]) or 1.0 for c in names]
    sizes = [np.sqrt(np.mean(e**2)) if zeros else np.std(e) for e in errors]
    return np.array(sizes) / ranges


def exchange_warnings(
    recording: Recording, simulated: Recording, simulate: Replay
) -> Iterator[DataWarning]:
    """Warn of two columns of a unit that fit the model much better in each other's place.

    Motions count, whatever their zeros. A driven column takes part if there is one only. Nothing is
    said if all other readings run against the model: then the drive does.
    """
    columns = columns_of(recording, simulated)
    against = {c.name for c in columns if not c.driven and c.correlation < -limits.ALIKE_IN_SHAPE}
    far = _misfit(recording, simulated, set())[0] > limits.LITTLE
    alone = len(recording.drive) == 1
    for first, second in combinations(columns, 2):
        driven = first.driven or second.driven
        if first.unit != second.unit or (driven and not (alone and far)):
            continue
        others = recording.measured.keys() - {first.name, second.name}
        if others and others <= against:
            continue
        read = {first.name: second.read, second.name: first.read}
        other = replace(recording, columns={**recording.columns, **read})
        shown = simulate(other) if driven else simulated
        if shown is None:
            continue
        judged = [c.name for c in columns if not c.driven and (driven or c.name in read)]
        before, after = (
            float(_errors(r, s, judged, zeros=False).mean())
            for r, s in ((recording, simulated), (other, shown))
        )
        if before > limits.LITTLE and after < min(limits.SIMILAR, before / limits.NEARER):
            nearer = f"{before / after:.0f} times nearer" if after else "nearer"
            yield first.warn(
                "exchanged",
                f"the model comes {nearer} to the"
                f" readings if this column and {recording.written(second.name)!r} change places",
                "if their names are exchanged in the file, exchange them in the description; a"
                " drive with the other sign does this to two cables that pull against each other",
                blocks=True,
            )
