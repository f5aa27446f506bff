"""Result of a fleet: for each rig whether it changed, and whether it differs from the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from datetime import datetime
from statistics import median
from typing import Any, Literal

from tendon_mj.lab.fleet.changes import LEAST_DAYS, Change
from tendon_mj.lab.fleet.comparison import FEWEST, Difference, Spread
from tendon_mj.lab.fleet.series import Series
from tendon_mj.lab.fleet.wording import (
    change_sentence,
    difference_sentence,
    fleet_sentence,
    not_judged,
)

Verdict = Literal[
    "changed", "differs", "consistent with the fleet", "unchanged", "not judged", "failed"
]

_ILL = 3.0  # misfit of the median rig [noise], above which the model does not describe the data


@dataclass(frozen=True, kw_only=True)
class RigFound:
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
        rivals: numbers whose change explains the recordings as well.
        differences: numbers that are not consistent with the fleet.
        fellows: number of rigs that could be fitted, this one included.
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
    square: tuple[float, ...] = ()
    change: Change | None = None
    series: Series | None = None
    rivals: tuple[Series, ...] = ()
    differences: tuple[Difference, ...] = ()
    fellows: int = 0
    remarks: tuple[str, ...] = ()

    @property
    def verdict(self) -> Verdict:
        """The verdict in a few words."""
        if self.error:
            return "failed"
        if self.change:
            return "changed"
        if self.differences:
            return "differs"
        if self.fellows >= FEWEST:
            return "consistent with the fleet"
        return "unchanged" if len(self.dates) >= 2 * LEAST_DAYS else "not judged"

    def sentence(self, units: Mapping[str, str]) -> str:
        """Summary of the rig, with units; ``units``: parameter → its unit."""
        parts = [self.error.removesuffix(".")] if self.error else []
        if self.change and self.series:
            parts.append(change_sentence(self.change, self.series, self.rivals, self.dates))
        parts += [difference_sentence(d, units.get(d.name, "noise")) for d in self.differences]
        if not parts:
            parts = [self.verdict, *not_judged(len(self.dates), self.fellows)]
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
                    "median": d.spread.median,
                    "between": d.spread.between,
                    "significance": d.significance,
                }
                for d in self.differences
            ],
        }

    def _changed(self) -> dict[str, Any] | None:
        change, series = self.change, self.series
        if change is None or series is None:
            return None
        plain = {k: _plain(value) for k, value in asdict(change).items()}
        return {
            **plain,
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


def _plain(value: object) -> object:
    return value.isoformat() if isinstance(value, datetime) else value


@dataclass(frozen=True)
class FleetFound:
    """Result of a fleet.

    Attributes:
        rigs: in the order of their names.
        spreads: parameter → median and spread between rigs [its unit].
        units: parameter → its unit.
    """

    rigs: Sequence[RigFound]
    spreads: Mapping[str, Spread]
    units: Mapping[str, str]

    def of(self, verdict: Verdict) -> list[RigFound]:
        """The rigs with a verdict."""
        return [rig for rig in self.rigs if rig.verdict == verdict]

    @property
    def sentence(self) -> str:
        """The result in a sentence."""
        verdicts: tuple[Verdict, ...] = ("changed", "differs", "failed")
        changed, different, failed = ([rig.name for rig in self.of(v)] for v in verdicts)
        unknown = len(self.of("not judged"))
        return fleet_sentence(len(self.rigs), changed, different, unknown, failed)

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
    def with_findings(self) -> list[RigFound]:
        """Rigs with findings or remarks, those that changed first."""
        verdicts: tuple[Verdict, ...] = ("changed", "differs", "failed")
        rigs = [rig for verdict in verdicts for rig in self.of(verdict)]
        return rigs + [rig for rig in self.rigs if rig.remarks and rig.verdict not in verdicts]

    def result(self) -> dict[str, Any]:
        """Plain numbers and words, as in `result.json`."""
        return {
            "sentence": self.sentence,
            "warning": self.warning,
            "rigs": [{**rig.result(), "sentence": rig.sentence(self.units)} for rig in self.rigs],
            "spreads": {
                name: {**asdict(s), "unit": self.units[name]} for name, s in self.spreads.items()
            },
        }

    def table(self) -> list[dict[str, Any]]:
        """A row for each rig."""
        return [rig.row() for rig in self.rigs]
