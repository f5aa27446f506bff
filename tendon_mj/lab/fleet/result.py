"""Result of a fleet: for each rig whether it changed, whether it differs, and both in words."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from itertools import pairwise
from statistics import median
from typing import Any, Literal

import numpy as np

from tendon_mj.lab.data_check import timing_warnings
from tendon_mj.lab.diagnosis import CATALOGUE
from tendon_mj.lab.fleet.changes import LEAST_DAYS, Change
from tendon_mj.lab.fleet.comparison import FEWEST, FleetSpread, RigDifference
from tendon_mj.lab.fleet.rigs import stamp
from tendon_mj.lab.fleet.series import NumberSeries
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import engineering_unit, plain, quantity

_RigVerdict = Literal[
    "changed", "differs", "consistent with the fleet", "unchanged", "not judged", "failed"
]

_ILL = 3.0  # misfit of the median rig [noise], above which the model does not describe the data
_GAP = 2.0  # times the usual time between two recordings, above which the day is not known
_SHARE = 0.5  # of the sum of squares, above which one recording is odd
_ABOVE = 2.0  # times the median residual of the rigs, above which a residual is reported
_FEWEST = 3  # recordings, for one of them to be odd


@dataclass(frozen=True, kw_only=True)
class RigResult:
    """Result of one rig.

    Attributes:
        name: of its folder.
        dates: of its recordings.
        error: why it could not be fitted; empty where it could.
        values, errors: parameter → fitted value and its standard error [its unit]; where it
            changed, before that.
        one_out: parameter, or `MISFIT` → likewise with each of its recordings left out.
        misfit: rms residual of the calibrated model [noise].
        left: likewise, with the change.
        square: (n,) mean square residual of each recording, with the change [noise²].
        change: its course and dates; None without a change.
        series: the number that changed, day by day.
        rivals: other numbers of which a change explains the recordings equally well.
        differences: numbers that are not consistent with the fleet.
        compared: number of fitted rigs, this one included.
        remarks: further findings.
    """

    name: str
    dates: tuple[datetime, ...]
    error: str = ""
    values: Mapping[str, float] = field(default_factory=dict)
    errors: Mapping[str, float] = field(default_factory=dict)
    one_out: Mapping[str, Sequence[float]] = field(default_factory=dict)
    misfit: float = float("nan")
    left: float = float("nan")
    square: Sequence[float] = ()
    change: Change | None = None
    series: NumberSeries | None = None
    rivals: Sequence[NumberSeries] = ()
    differences: Sequence[RigDifference] = ()
    compared: int = 0
    remarks: Sequence[str] = ()

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
            value, _ = _in_one_unit([d.value, middle], unit)
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
            "differs": [
                {
                    "name": d.name,
                    "value": d.value,
                    **d.spread._asdict(),
                    "significance": d.significance,
                }
                for d in self.differences
            ],
        }

    def _changed(self) -> dict[str, Any] | None:
        change, series = self.change, self.series
        if change is None or series is None:
            return None
        dates = {k: v.isoformat() for k, v in vars(change).items() if isinstance(v, datetime)}
        return {
            **vars(change),
            **dates,
            "parameter": series.parameter,
            "effect": series.number.identifier,
            "unit": series.unit,
            "values": series.values.tolist(),
            "errors": series.errors.tolist(),
            "rivals": [
                {"parameter": r.parameter, "effect": r.number.identifier} for r in self.rivals
            ],
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
    """Result of a fleet.

    Attributes:
        rigs: in the order of their names.
        spreads: parameter → median and spread between rigs [its unit].
        units: parameter → its unit.
    """

    rigs: Sequence[RigResult]
    spreads: Mapping[str, FleetSpread]
    units: Mapping[str, str]

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
        """Warning that the model does not describe the recordings; empty where it does."""
        residuals = [rig.left for rig in self.rigs if not rig.error]
        usual = median(residuals) if residuals else 0.0
        if usual <= _ILL:
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
        return {
            "sentence": self.sentence,
            "warning": self.warning,
            "rigs": [{**rig.result(), "sentence": rig.sentence(self.units)} for rig in self.rigs],
            "spreads": {
                name: {**s._asdict(), "unit": self.units[name]} for name, s in self.spreads.items()
            },
        }


def change_sentence(
    change: Change, series: NumberSeries, rivals: Sequence[NumberSeries], dates: Sequence[datetime]
) -> str:
    """A change in words, with values and dates; ``rivals``: series that explain it as well."""
    names = [
        f"{n.name} ({CATALOGUE[n.identifier].name})" if n.identifier else n.name
        for n in (one.number for one in (series, *rivals))
    ]
    apart = f", except {stamp(change.apart)}" if change.apart is not None else ""
    also = f", or as well {', or '.join(names[1:])}" if rivals else ""
    return f"{names[0]} {_course(change, series, dates)}{apart}{also}"


def _course(change: Change, series: NumberSeries, dates: Sequence[datetime]) -> str:
    """Values before and after, and since when; both days, where the gap between them is long."""
    if change.course == "varying":
        ends = [float(series.values.min()), float(series.values.max())]
        low, high = _in_one_unit(ends, series.unit)
        return f"varies from {low} to {high}, with no single change"
    if change.between is not None and change.until is not None:
        values = [change.after, change.before, change.between]
        after, before, between = _in_one_unit(values, series.unit)
        during = f"from {stamp(change.since)} to {stamp(change.until)}"
        return f"{before} → {between} {during}, {after} since"
    before, after = _in_one_unit([change.before, change.after], series.unit)
    growing = change.course == "ramp"
    usual = float(np.median([(b - a).total_seconds() for a, b in pairwise(dates)]))
    days = f"since {stamp(change.since)}"
    if (change.since - change.last_same).total_seconds() > _GAP * usual:
        begun = "since a day " if growing else ""
        days = f"{begun}between {stamp(change.last_same)} and {stamp(change.since)}"
    return f"{before} → {after} {'growing ' if growing else ''}{days}"


def _in_one_unit(values: Sequence[float], unit: str) -> list[str]:
    """Values in one unit, the last with its symbol."""
    chosen = engineering_unit(unit, values)
    symbol = f" {chosen.symbol}" if chosen.symbol and chosen.symbol != "°" else chosen.symbol
    numbers = [plain(value * chosen.factor) for value in values]
    return [*numbers[:-1], f"{numbers[-1]}{symbol}"]


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
