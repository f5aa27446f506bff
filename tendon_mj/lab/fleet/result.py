"""Result of a fleet: for each rig whether it changed, whether it differs, and both in words.

Of a number x_r with standard error s_r on rig r, the fleet has the median m and, from the median
absolute deviation, a spread S that a few rigs do not widen. A rig differs where

    |x_r − m| > 5 √(S² + s_r²),

whichever recording of it is left out, so that one odd day is not a difference. Its misfit, the rms
residual of the calibrated model, differs where it is also twice the median.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from itertools import pairwise
from statistics import median
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

import mujoco
import numpy as np
import pandas as pd
import scipy

from tendon_mj.lab.data_check import timing_warnings
from tendon_mj.lab.diagnosis import CATALOGUE
from tendon_mj.lab.fleet.changes import LEAST_DAYS, SIGNIFICANT, Change
from tendon_mj.lab.fleet.observation import NumberSeries
from tendon_mj.lab.fleet.rigs import stamp
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.units import engineering_unit, plain, quantity
from tendon_mj.models import model_digest

FEWEST = 5  # rigs, for a spread between them
MISFIT = "misfit"  # in place of a parameter's name [noise]

_RigVerdict = Literal[
    "changed", "differs", "consistent with the fleet", "unchanged", "not judged", "failed"
]

ILL = 3.0  # misfit of the median rig [noise], above which the model does not describe the data
_GAP = 2.0  # times the usual time between two recordings, above which the day is not known
_SHARE = 0.5  # of the sum of squares, above which one recording is odd
_ABOVE = 2.0  # times that of the median rig, above which a residual is reported
_FEWEST = 3  # recordings, for one of them to be odd


class FleetSpread(NamedTuple):
    """A number on all rigs of a fleet: its median, and its spread between them [its unit]."""

    median: float
    between: float


class RigDifference(NamedTuple):
    """A number of a rig that is not consistent with the fleet [its unit], and how far [spreads]."""

    name: str
    value: float
    spread: FleetSpread
    significance: float


def spread_between(values: Mapping[str, float], errors: Mapping[str, float]) -> FleetSpread:
    """Median and spread of rig → value, in excess of their standard errors."""
    every = np.array(list(values.values()))
    deviation = float(scipy.stats.median_abs_deviation(every, scale="normal"))
    noise = float(np.median([errors[rig] for rig in values]))
    return FleetSpread(float(np.median(every)), float(np.sqrt(max(deviation**2 - noise**2, 0.0))))


def rig_differences(
    name: str,
    values: Mapping[str, float],
    errors: Mapping[str, float],
    spread: FleetSpread,
    one_out: Mapping[str, Sequence[float]] = MappingProxyType({}),
) -> dict[str, RigDifference]:
    """Rig → its difference, of the rigs that differ; empty if there are fewer than five rigs.

    ``values, errors``: rig → value of the number and its standard error [its unit]; ``one_out``:
    rig → its value with each of its recordings left out, if there are several.
    """
    if len(values) < FEWEST:
        return {}
    outliers = {}
    for rig, value in values.items():
        expected = float(np.hypot(spread.between, errors[rig]))
        side = np.sign(value - spread.median)
        away = min(side * (x - spread.median) for x in [value, *one_out.get(rig, ())])
        if away > SIGNIFICANT * expected:
            ratio = away / expected if expected > 0.0 else np.inf
            outliers[rig] = RigDifference(name, value, spread, float(ratio))
    return outliers


def larger_misfits(
    misfits: Mapping[str, float], one_out: Mapping[str, Sequence[float]] = MappingProxyType({})
) -> dict[str, RigDifference]:
    """Like `rig_differences`, of the misfit [noise]."""
    errors = dict.fromkeys(misfits, 0.0)
    spread = spread_between(misfits, errors)
    outliers = rig_differences(MISFIT, misfits, errors, spread, one_out)
    least = {rig: min([misfits[rig], *one_out.get(rig, ())]) for rig in outliers}
    return {rig: one for rig, one in outliers.items() if least[rig] > _ABOVE * spread.median}


def kind(recording: Recording, model: mujoco.MjModel) -> dict[str, str]:
    """Everything that rigs need to have in common: part of the description → its content."""
    tables = {"[uncertain]": recording.uncertain, "[known]": recording.known}
    contents = {name: repr(sorted(t.items())) for name, t in tables.items()}
    return {"model": model_digest(model)} | contents


def unlike(kinds: Mapping[str, Mapping[str, str]]) -> dict[str, list[str]]:
    """Rig → the parts of its `kind` that differ from most rigs', of the rigs that have any."""
    parts = sorted({part for one in kinds.values() for part in one}, key=lambda p: p[0] == "[")
    usual = {p: Counter(one[p] for one in kinds.values()).most_common(1)[0][0] for p in parts}
    differing = {rig: [p for p in parts if one[p] != usual[p]] for rig, one in kinds.items()}
    return {rig: parts for rig, parts in differing.items() if parts}


@dataclass(frozen=True, kw_only=True)
class RigResult:
    """Result of one rig."""

    name: str  # of its folder
    dates: tuple[datetime, ...]  # of its recordings
    error: str = ""  # why it could not be fitted; empty if it could
    # parameter → fitted value and its standard error [its unit]; where it changed, before that
    values: Mapping[str, float] = field(default_factory=dict)
    errors: Mapping[str, float] = field(default_factory=dict)
    # parameter, or `MISFIT` → likewise with each of its recordings left out
    one_out: Mapping[str, Sequence[float]] = field(default_factory=dict)
    misfit: float = float("nan")  # rms residual of the calibrated model [noise]
    left: float = float("nan")  # likewise, with the change
    # (n,) mean square residual of each recording, with the change [noise²]
    square: Sequence[float] = ()
    change: Change | None = None  # its course and dates; None without a change
    series: NumberSeries | None = None  # the number that changed, day by day
    # other numbers of which a change explains the recordings equally well
    rivals: Sequence[NumberSeries] = ()
    differences: Sequence[RigDifference] = ()  # numbers that are not consistent with the fleet
    compared: int = 0  # number of fitted rigs, this one included
    remarks: Sequence[str] = ()  # further findings

    @property
    def verdict(self) -> _RigVerdict:
        """The verdict in a few words."""
        if self.error:
            return "failed"
        if self.change:
            return "changed"
        if self.differences:
            return "differs"
        if self.compared >= FEWEST:
            return "consistent with the fleet"
        return "unchanged" if len(self.dates) >= 2 * LEAST_DAYS else "not judged"

    def sentence(self, units: Mapping[str, str]) -> str:
        """Summary of the rig, with units; ``units``: parameter → its unit."""
        parts = [self.error.removesuffix(".")] if self.error else []
        if self.change and self.series:
            parts.append(change_sentence(self.change, self.series, self.rivals, self.dates))
        for d in self.differences:
            unit, middle = units.get(d.name, "noise"), d.spread.median
            value, _ = in_one_unit([d.value, middle], unit)
            parts.append(f"{d.name} is {value}, the fleet's median {quantity(middle, unit)}")
        if not parts:
            parts = [self.verdict]
            if len(self.dates) < 2 * LEAST_DAYS:
                needed, there = 2 * LEAST_DAYS, len(self.dates)
                parts.append(f"a change needs {needed} recordings or more, and there are {there}")
            if self.compared < FEWEST:
                parts.append(
                    f"a comparison needs {FEWEST} fitted rigs or more, and there are"
                    f" {self.compared}"
                )
        return f"{self.name}: {'; '.join([*parts, *self.remarks])}."

    def result(self) -> dict[str, Any]:
        """Plain numbers and words, as in `result.json`."""
        differs = [
            {"name": d.name, "value": d.value, **d.spread._asdict(), "significance": d.significance}
            for d in self.differences
        ]
        return {
            "rig": self.name,
            "verdict": self.verdict,
            "error": self.error,
            "dates": [date.isoformat() for date in self.dates],
            "values": dict(self.values),
            "errors": dict(self.errors),
            "remarks": list(self.remarks),
            "misfit": self.misfit,
            "left": self.left,
            "changed": self._changed(),
            "differs": differs,
        }

    def _changed(self) -> dict[str, Any] | None:
        change, series = self.change, self.series
        if change is None or series is None:
            return None
        dates = {k: v.isoformat() for k, v in vars(change).items() if isinstance(v, datetime)}
        return {
            **vars(change),
            **dates,
            **entries(series, self.rivals),
        }

    def row(self) -> dict[str, Any]:
        """Its row of the fleet's table."""
        changed, dates = self._changed() or {}, [date.isoformat() for date in self.dates]
        numbers = {k: changed.get(k) for k in ("before", "between", "after")}
        return {
            "rig": self.name,
            "verdict": self.verdict,
            "recordings": len(dates),
            "first": dates[0] if dates else "",
            "last": dates[-1] if dates else "",
            "changed": changed.get("parameter", ""),
            **{k: changed.get(k, "") for k in ("effect", "since", "course")},
            **numbers,
            "until": changed.get("until") or "",
            "unit": changed.get("unit", ""),
            "significance": changed.get("significance"),
            "differs": "; ".join(d.name for d in self.differences),
            "misfit_noise": self.misfit,
            "left_noise": self.left,
            **self.values,
            "remarks": "; ".join(self.remarks),
            "error": self.error,
        }


@dataclass(frozen=True)
class FleetResult:
    """Result of a fleet."""

    rigs: Sequence[RigResult]  # in the order of their names
    spreads: Mapping[str, FleetSpread]  # parameter → median and spread between rigs [its unit]
    units: Mapping[str, str]  # parameter → its unit

    def __repr__(self) -> str:
        return f"FleetResult: {self.sentence} {self.warning}".rstrip()

    def to_dataframe(self) -> pd.DataFrame:
        """A row a rig: its verdict, errors and parameters, as in `rigs.csv`."""
        return pd.DataFrame([rig.row() for rig in self.rigs])

    def of(self, verdict: _RigVerdict) -> list[RigResult]:
        """The rigs with a verdict."""
        return [rig for rig in self.rigs if rig.verdict == verdict]

    @property
    def sentence(self) -> str:
        """The result in a sentence."""
        differ = "differs" if len(self.of("differs")) == 1 else "differ"
        words: dict[_RigVerdict, str] = {
            "changed": "changed",
            "differs": f"{differ} from the fleet",
            "not judged": "could not be judged",
            "failed": "could not be fitted",
        }
        parts = []
        for verdict, what in words.items():
            names = [rig.name for rig in self.of(verdict)]
            listed = f" ({', '.join(names)})" if names and verdict != "not judged" else ""
            if names or verdict == "changed":
                parts.append(f"{len(names)} {what}{listed}")
        return f"Of {len(self.rigs)} {'rig' if len(self.rigs) == 1 else 'rigs'} {', '.join(parts)}."

    @property
    def warning(self) -> str:
        """Warning that the model does not describe the recordings; empty if it does."""
        residuals = [rig.left for rig in self.rigs if not rig.error]
        usual = median(residuals) if residuals else 0.0
        if usual <= ILL:
            return ""
        return (
            f"The model does not describe the recordings: the residual of the median rig is"
            f" {usual:.2g} times the noise; run tendon-mj diagnose on the recordings of one."
        )

    @property
    def with_findings(self) -> list[RigResult]:
        """Rigs with findings or remarks, those that changed first."""
        verdicts: tuple[_RigVerdict, ...] = ("changed", "differs", "failed")
        rigs = [rig for verdict in verdicts for rig in self.of(verdict)]
        return rigs + [rig for rig in self.rigs if rig.remarks and rig.verdict not in verdicts]

    def result(self) -> dict[str, Any]:
        """Plain numbers and words, as in `result.json`."""
        spreads = {n: {**s._asdict(), "unit": self.units[n]} for n, s in self.spreads.items()}
        return {
            "sentence": self.sentence,
            "warning": self.warning,
            "rigs": [{**rig.result(), "sentence": rig.sentence(self.units)} for rig in self.rigs],
            "spreads": spreads,
        }


def change_sentence(
    change: Change, series: NumberSeries, rivals: Sequence[NumberSeries], dates: Sequence[datetime]
) -> str:
    """A change in words, with values and dates; ``rivals``: series that explain it as well."""
    apart = f", except {stamp(change.apart)}" if change.apart is not None else ""
    return f"{label(series)} {_course(change, series, dates)}{apart}{or_as_well(rivals)}"


def label(series: NumberSeries) -> str:
    """A number by its name, and by that of its effect."""
    number = series.number
    return number.name + (f" ({CATALOGUE[number.identifier].name})" if number.identifier else "")


def or_as_well(rivals: Sequence[NumberSeries]) -> str:
    """The end of a sentence that names numbers which explain as much; empty without any."""
    return f", or as well {', or '.join(map(label, rivals))}" if rivals else ""


def entries(series: NumberSeries, rivals: Sequence[NumberSeries]) -> dict[str, Any]:
    """A number, and those that explain as much, as in `result.json`."""
    names, *others = (
        {"parameter": one.parameter, "effect": one.number.identifier} for one in (series, *rivals)
    )
    values, errors = series.values.tolist(), series.errors.tolist()
    return {**names, "unit": series.unit, "values": values, "errors": errors, "rivals": others}


def _course(change: Change, series: NumberSeries, dates: Sequence[datetime]) -> str:
    """Values before and after, and since when; both days, where the gap between them is long."""
    if change.course == "varying":
        ends = [float(series.values.min()), float(series.values.max())]
        low, high = in_one_unit(ends, series.unit)
        return f"varies from {low} to {high}, with no single change"
    if change.between is not None and change.until is not None:
        values = [change.after, change.before, change.between]
        after, before, between = in_one_unit(values, series.unit)
        during = f"from {stamp(change.since)} to {stamp(change.until)}"
        return f"{before} → {between} {during}, {after} since"
    before, after = in_one_unit([change.before, change.after], series.unit)
    growing = change.course == "ramp"
    usual = float(np.median([(b - a).total_seconds() for a, b in pairwise(dates)]))
    days = f"since {stamp(change.since)}"
    if (change.since - change.last_same).total_seconds() > _GAP * usual:
        begun = "since a day " if growing else ""
        days = f"{begun}between {stamp(change.last_same)} and {stamp(change.since)}"
    return f"{before} → {after} {'growing ' if growing else ''}{days}"


def in_one_unit(values: Sequence[float], unit: str) -> list[str]:
    """Values in one unit, the last with its symbol."""
    chosen = engineering_unit(unit, values)
    *others, last = values
    return [*(plain(value * chosen.factor) for value in others), chosen.write(last)]


def other_kind(parts: Sequence[str]) -> str:
    """Remark on a rig with another model or description than most rigs; empty without parts."""
    if not parts:
        return ""
    verb = "differ" if len(parts) > 1 else "differs"
    return f"its {' and '.join(parts)} {verb} from most rigs', so that it is not comparable"


def odd_day(dates: Sequence[datetime], square: Sequence[float], usual: float) -> str:
    """Remark on the recording with most of a rig's residual; empty without one.

    ``square``: (n,) mean square residuals [noise²]; ``usual``: rms of the median rig [noise].
    """
    largest, whole = int(np.argmax(square)), float(np.sum(square))
    rms = float(np.sqrt(square[largest]))
    if len(dates) < _FEWEST or square[largest] < _SHARE * whole or rms < _ABOVE * usual:
        return ""
    return f"most of its misfit is on {stamp(dates[largest])}, {rms:.2g} noise"


def remaining(residual: float, usual: float) -> str:
    """Remark on the rms residual after a change, where it is far more than usual [noise]."""
    if residual <= _ABOVE * usual:
        return ""
    return f"{residual:.2g} noise remains, so that more may have changed"


def timing_remarks(recordings: Iterable[Recording]) -> list[str]:
    """The first timing warning of each kind, and the number of recordings that have it."""
    sentences: dict[str, list[str]] = {}
    for recording in recordings:
        for warning in timing_warnings(recording):
            sentences.setdefault(warning.identifier, []).append(warning.sentence)
    return [
        f"{first}; so in {1 + len(others)} recordings" if others else first
        for first, *others in sentences.values()
    ]
