"""What changed on one rig between two states of it, each with recordings of its own.

Every number that may change is watched as on a rig of a fleet (`observation`): the uncertain
parameters, and the effects of the catalogue. Those of which a change between the states explains
most, to first order, are fitted to each recording by itself, everything else to all of them. Of the
values x of a state, as they are if everything else may differ by its reproducibility too, and their
standard errors s,

    x̄ = Σ x/s² / Σ 1/s²,   s̄² = max(1 / Σ 1/s², Σ (x − x̄)² / (n (n−1))).

Reproducibility is a share of each fitted number, and √`SMALLEST_EXCESS` of its noise for the zero
of a sensor. So no number changes by what several that come back explain together. The change is
significant where |x̄_new − x̄_old| is 5 times √(s̄_old² + s̄_new²) or more. Numbers explain the
recordings as well as each other where they leave the same but for the limit of a diagnosis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from tendon_mj.errors import InvalidValueError, RecordingError
from tendon_mj.lab.diagnosis import SMALLEST_EXCESS
from tendon_mj.lab.fleet.changes import SIGNIFICANT, explained, most_promising
from tendon_mj.lab.fleet.observation import (
    REPRODUCIBILITY,
    NumberSeries,
    fit_series,
    observe,
    usable,
)
from tendon_mj.lab.fleet.result import ILL, entries, in_one_unit, label, or_as_well
from tendon_mj.lab.fleet.rigs import RigData
from tendon_mj.lab.recordings import Recording
from tendon_mj.typing import BoolArray


@dataclass(frozen=True)
class StatesCompared:
    """Two states of a rig: the number that changed, or how small a change would have been found."""

    # recording by recording, the old ones first; without a change the one that explains most
    series: NumberSeries
    changed: bool
    rivals: Sequence[NumberSeries]  # others of which a change explains the recordings as well
    before: float  # of that number [its unit]
    after: float
    significance: float  # the change over its standard error
    # name and unit of each uncertain parameter → the least change that would have been found
    least: dict[tuple[str, str], float]
    misfit: float  # rms residual of the calibrated model, without the change [noise]
    left: float  # with it, or without where none was found

    @property
    def sentence(self) -> str:
        """The result in a sentence."""
        warning = ""
        if self.left > ILL:
            warning = (
                f" With that the model leaves {self.left:.2g} times the noise in the two states"
                " together: either it lacks an effect, or what changed is no number that was tried."
                " Run tendon-mj diagnose on the old recordings and on the new ones."
            )
        before, after = in_one_unit([self.before, self.after], self.series.unit)
        if not self.changed:
            seen = [
                f"{name} by {in_one_unit([size], unit)[0]}"
                for (name, unit), size in self.least.items()
            ]
            found = f" One of {', or of '.join(seen)} would have been." if seen else ""
            return (
                f"No change was found. What explains most is {label(self.series)}"
                f" {before} → {after}, {self.significance:.2g} standard errors, of"
                f" {SIGNIFICANT:g} that are asked.{found}{warning}"
            )
        return (
            f"Changed: {label(self.series)} {before} → {after},"
            f" {self.significance:.2g} standard errors{or_as_well(self.rivals)}.{warning}"
        )

    def result(self) -> dict[str, object]:
        """Plain numbers and words, as in `result.json`."""
        return {
            "sentence": self.sentence,
            "changed": self.changed,
            **entries(self.series, self.rivals),
            "before": self.before,
            "after": self.after,
            "significance": self.significance,
            "least": {name: size for (name, _), size in self.least.items()},
            "misfit": self.misfit,
            "left": self.left,
        }


def compare_states(
    old: Sequence[Recording],
    new: Sequence[Recording],
    model: mujoco.MjModel,
    reproducibility: float = REPRODUCIBILITY,
) -> StatesCompared:
    """Find the number that changed on a rig between old and new recordings.

    Args:
        old: recordings of the rig as it was.
        new: of the rig as it is.
        model: of both.
        reproducibility: share of itself by which a number comes back if nothing changed.

    Raises:
        InvalidValueError: a reproducibility that is negative or not finite.
        RecordingError: a recording cannot be calibrated with the others, or its [known] differs
            from theirs.
    """
    if not 0.0 <= reproducibility < np.inf:
        raise InvalidValueError(f"reproducibility = {reproducibility:g} must be 0 or more")
    named = [
        replace(recording, name=f"{state} {k + 1} ({recording.name})")
        for state, recordings in (("old", old), ("new", new))
        for k, recording in enumerate(recordings)
    ]
    for one in named[1:]:
        if other := dict(one.known.items() ^ named[0].known.items()):
            raise RecordingError(
                f"recordings {named[0].name!r} and {one.name!r} differ in [known]"
                f" {', '.join(sorted(other))}, which would be taken for a change of the rig; give"
                " one description for all"
            )
    if faults := list(filter(None, usable(RigData([*named], [""] * len(named), model)))):
        raise RecordingError("\n".join(faults))
    observation = observe(named, model)
    is_new = np.arange(len(named)) >= len(old)
    changes, gains = explained(observation, is_new.astype(float))

    def fitted(numbers: set[int]) -> list[NumberSeries]:
        suspected = {observation.numbers[k]: changes[k] * is_new for k in numbers}
        return fit_series(named, model, observation.terms.tolist(), suspected, reproducibility)

    suspects = {*most_promising(observation, gains), *range(observation.shared)}
    series = fitted(suspects)
    if series[0].square.mean() > ILL**2:  # play explains far more than it does to first order
        gains[[*suspects]] = 0.0
        more = {k for k in most_promising(observation, gains) if gains[k] > 0.0}
        series = sorted(series + fitted(more), key=lambda one: float(one.square.mean()))
    misfit = float(np.sqrt(observation.square.mean()))
    best = float(series[0].square.mean())
    most = best + SMALLEST_EXCESS * max(1.0, best)
    alike = [one for one in series if float(one.square.mean()) <= most]
    first = min(alike, key=lambda one: bool(one.number.identifier))  # else the first
    before, after, error = _ends(first, is_new)
    significance = abs(after - before) / error
    within = [float(np.clip(x, *first.range)) for x in (before, after)]
    before, after = within if len({*within}) == 2 else (before, after)
    found = significance >= SIGNIFICANT
    return StatesCompared(
        series=first,
        changed=found,
        rivals=[one for one in alike if one is not first] if found else (),
        before=before,
        after=after,
        significance=significance,
        least={
            (one.parameter, one.unit): least
            for one in series
            if not one.number.identifier
            and (least := SIGNIFICANT * _ends(one, is_new)[-1]) < np.ptp(one.range)
        },
        misfit=misfit,
        left=float(np.sqrt(first.square.mean())) if found else misfit,
    )


def _ends(series: NumberSeries, is_new: BoolArray) -> tuple[float, float, float]:
    """Means of a number over both states, and the standard error of their difference."""
    old, new = (_mean(series, state) for state in (~is_new, is_new))
    return old[0], new[0], float(np.hypot(old[1], new[1]))


def _mean(series: NumberSeries, state: BoolArray) -> tuple[float, float]:
    """Mean of a number over the recordings of a state, and its standard error.

    A number that changes nothing in any of them has an infinite one.
    """
    values, weights = series.apart[state], 1.0 / series.errors_apart[state] ** 2
    if not weights.any():
        return float(values.mean()), np.inf
    mean, count = float(np.average(values, weights=weights)), values.size
    scatter = np.sum((values - mean) ** 2) / (count * (count - 1)) if count > 1 else 0.0
    return mean, float(np.sqrt(max(1.0 / weights.sum(), scatter)))
