"""What was found of a fleet: of each rig whether it changed, or differs from its fellows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from datetime import datetime
from statistics import median
from typing import Any, Literal

from tendon_mj.lab.fleet.changes import LEAST_DAYS
from tendon_mj.lab.fleet.fellows import FEWEST, Difference, Spread
from tendon_mj.lab.fleet.sentence import change_sentence, in_one_unit
from tendon_mj.lab.fleet.series import Series
from tendon_mj.lab.fleet.since import Change
from tendon_mj.lab.replay import quantity

Verdict = Literal["changed", "differs", "as its fellows", "unchanged", "not judged", "failed"]

_ILL = 3.0  # misfit of the median rig [noise], above which the model does not describe the data


@dataclass(frozen=True, kw_only=True)
class RigFound:
    """What was found of one rig.

    Attributes:
        name: of its folder.
        dates: of its recordings.
        error: why there is nothing to say of it; empty where there is.
        values, errors: parameter → fitted value and its standard error [its unit]; where it
            changed, before that.
        one_out: parameter, or `MISFIT` → likewise with each of its recordings left out.
        misfit: root mean square of what the calibrated model leaves [noise].
        left: likewise, with the change.
        square: (n,) mean square of that, of each recording [noise²].
        change: what changed, and since when; None where nothing did.
        series: the number that changed, day by day.
        rivals: numbers whose change explains the recordings as well.
        differences: numbers that are not as its fellows'.
        fellows: rigs that could be fitted, with itself.
        remarks: what else is to be known of it.
    """

    name: str
    dates: tuple[datetime, ...]
    error: str = ""
    values: Mapping[str, float]
    errors: Mapping[str, float]
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
        """The verdict in a word or three."""
        if self.error:
            return "failed"
        if self.change:
            return "changed"
        if self.differences:
            return "differs"
        if self.fellows >= FEWEST:
            return "as its fellows"
        return "unchanged" if self._has_enough_days else "not judged"

    @property
    def _has_enough_days(self) -> bool:
        return len(self.dates) >= 2 * LEAST_DAYS

    def sentence(self, units: Mapping[str, str]) -> str:
        """What is to be said of the rig, with units; ``units``: parameter → its unit."""
        parts = [self._changed()] if self.change else []
        for one in self.differences:
            unit = units.get(one.name, "noise")
            text = f"{one.name} is {in_one_unit([one.value, one.spread.median], unit)[0]}"
            parts.append(f"{text}, the fleet's median {quantity(one.spread.median, unit)}")
        if self.error:
            return f"{self.name}: {'; '.join([self.error.removesuffix('.'), *self.remarks])}."
        parts = parts or [self.verdict, *self._not_judged()]
        return f"{self.name}: {'; '.join([*parts, *self.remarks])}."

    def _not_judged(self) -> list[str]:
        """What it takes to judge what could not be."""
        found = []
        if not self._has_enough_days:
            least, own = 2 * LEAST_DAYS, len(self.dates)
            found.append(f"a change is sought in {least} recordings or more, here {own}")
        if self.fellows < FEWEST:
            found.append(
                f"rigs are compared where {FEWEST} or more could be fitted, here {self.fellows}"
            )
        return found

    def _changed(self) -> str:
        change, series = self.change, self.series
        if change is None or series is None:
            return ""
        return change_sentence(change, series, self.rivals, self.dates)

    def result(self) -> dict[str, Any]:
        """Plain numbers and words, as in `result.json`."""
        change, series = self.change, self.series
        changed = None
        if change is not None and series is not None:
            changed = {
                **asdict(change),
                "since": change.since.isoformat(),
                "last_same": change.last_same.isoformat(),
                "until": change.until and change.until.isoformat(),
                "apart": change.apart and change.apart.isoformat(),
                "parameter": series.parameter,
                "effect": series.number.identifier,
                "unit": series.unit,
                "values": series.values.tolist(),
                "errors": series.errors.tolist(),
                "rivals": [
                    {"parameter": r.parameter, "effect": r.number.identifier} for r in self.rivals
                ],
            }
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
            "changed": changed,
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


@dataclass(frozen=True)
class FleetFound:
    """What was found of a fleet.

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
        """What came out, in a sentence."""
        changed, differ, failed = (self.of(v) for v in ("changed", "differs", "failed"))
        parts = [f"{len(changed)} changed" + _names(changed)]
        if differ:
            words = "differs from its" if len(differ) == 1 else "differ from their"
            parts.append(f"{len(differ)} {words} fellows" + _names(differ))
        if judged := self.of("not judged"):
            parts.append(f"{len(judged)} could not be judged")
        if failed:
            parts.append(f"{len(failed)} could not be fitted" + _names(failed))
        rigs = "rig" if len(self.rigs) == 1 else "rigs"
        return f"Of {len(self.rigs)} {rigs} {', '.join(parts)}."

    @property
    def warning(self) -> str:
        """That the model does not describe the recordings, where it does not; else empty."""
        left = [rig.left for rig in self.rigs if not rig.error]
        usual = median(left) if left else 0.0
        if usual <= _ILL:
            return ""
        return (
            f"The model does not describe the recordings: {usual:.2g} times the noise is left of"
            " the median rig; run tendon-mj diagnose on the recordings of one."
        )

    @property
    def told(self) -> list[RigFound]:
        """The rigs of which there is something to say, those that changed first."""
        verdicts: tuple[Verdict, ...] = ("changed", "differs", "failed")
        found = [rig for verdict in verdicts for rig in self.of(verdict)]
        return found + [rig for rig in self.rigs if rig.remarks and rig.verdict not in verdicts]

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
        return [_row(rig) for rig in self.rigs]


def _names(rigs: Sequence[RigFound]) -> str:
    return f" ({', '.join(rig.name for rig in rigs)})" if rigs else ""


def _row(rig: RigFound) -> dict[str, Any]:
    change, series = rig.change, rig.series
    return {
        "rig": rig.name,
        "verdict": rig.verdict,
        "recordings": len(rig.dates),
        "first": rig.dates[0].isoformat() if rig.dates else "",
        "last": rig.dates[-1].isoformat() if rig.dates else "",
        "changed": series.parameter if series and change else "",
        "effect": series.number.identifier if series and change else "",
        "since": change.since.isoformat() if change else "",
        "course": change.course if change else "",
        "before": change.before if change else None,
        "between": change.between if change else None,
        "after": change.after if change else None,
        "until": change.until.isoformat() if change and change.until else "",
        "unit": series.unit if series and change else "",
        "significance": change.significance if change else None,
        "differs": "; ".join(d.name for d in rig.differences),
        "misfit_noise": rig.misfit,
        "left_noise": rig.left,
        **rig.values,
        "remarks": "; ".join(rig.remarks),
        "error": rig.error,
    }
