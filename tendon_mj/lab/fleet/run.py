"""Analysis of a fleet: each rig by itself, then its changes day by day, then the comparison."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field, fields, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from tendon_mj.errors import TendonError
from tendon_mj.lab.fleet.changes import SIGNIFICANT, daily_deviations, find_change, suspects
from tendon_mj.lab.fleet.observation import (
    Label,
    Number,
    NumberSeries,
    Observation,
    explanation,
    fit_series,
    observe,
    one_out,
    usable,
)
from tendon_mj.lab.fleet.result import (
    MISFIT,
    FleetResult,
    FleetSpread,
    RigDifference,
    RigResult,
    kind,
    larger_misfits,
    odd_day,
    other_kind,
    remaining,
    rig_differences,
    spread_between,
    timing_remarks,
    unlike,
)
from tendon_mj.lab.fleet.rigs import Rig, RigData
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.workers import Workers, run_tasks
from tendon_mj.typing import FloatArray
from tendon_mj.whole_file import whole_file

_Changes = dict[Number, tuple[float, ...]]  # number → change on each day [probes]
_Kept = TypeVar("_Kept")


@dataclass(frozen=True)
class _Observed:
    """Result of the first pass over a rig, as it is kept."""

    error: str = ""  # why there is no observation; empty if there is one
    observation: Observation | None = None  # of its recordings
    reasons: Sequence[str] = ()  # why each recording is left out; empty if it is not
    remarks: Sequence[str] = ()  # on the times of its recordings
    kind: Mapping[str, str] = field(default_factory=dict)  # see `kind`


def run_fleet(
    rigs: Sequence[Rig],
    out: Path,
    *,
    on: Workers | None = None,
    again: bool = False,
    begin: Callable[[], None] = lambda: None,
    progress: Progress = silent,
) -> FleetResult:
    """Find which rigs of a fleet changed, and which differ from the others.

    Each rig is calibrated by itself. The scatter between days where nothing changed, and between
    rigs that are alike, is estimated from all of them, and changes and differences are tested
    against it. A recording that cannot be used is left out with a remark. Results are kept in
    ``out``, and computed again where a rig's recordings, its model or the version changed, or all
    ``again``. ``begin`` is called before the first rig is computed, when nothing more is refused.
    """
    run = partial(run_tasks, on=on, progress=progress)
    by_name = {rig.name: rig for rig in rigs}

    def read(name: str) -> RigData:
        return by_name[name].read()

    digests = {rig.name: rig.digest() for rig in rigs if not rig.error}
    first = _RigFiles(out / "observations", digests, again=again)
    run(_observe, None, list(digests), read, first, begin=begin, what="calibrate")
    observed = {rig.name: _Observed(error=rig.error) for rig in rigs}
    observed |= {name: _restored(_Observed, first.results[name]) for name in digests}
    seen = {name: one.observation for name, one in observed.items() if one.observation}
    used = {name: by_name[name].without(observed[name].reasons) for name in seen}
    spreads = daily_deviations(list(seen.values()))
    suspected = {
        name: {
            observation.numbers[s.index]: tuple((s.change * s.template.weights).tolist())
            for s in suspects(observation, used[name].dates, spreads)
        }
        for name, observation in seen.items()
    }
    suspected = {name: changes for name, changes in suspected.items() if changes}
    of = {name: f"{digests[name]} {changes}" for name, changes in suspected.items()}
    second = _RigFiles(out / "changes", of, again=again)
    run(
        _fit_series,
        None,
        list(suspected),
        lambda name: (used[name].read(), seen[name].terms.tolist(), suspected[name]),
        second,
        what="day by day",
    )
    results = []
    for rig in rigs:
        kept = second.results[rig.name]["series"] if rig.name in suspected else []
        series = [_restored(NumberSeries, one) for one in kept]
        results.append(_result(rig, observed[rig.name], series, spreads))
    return _compared(results, seen, unlike({name: observed[name].kind for name in seen}))


def _observe(_: None, data: RigData) -> dict[str, Any]:
    reasons = usable(data)
    pairs = zip(data.recordings, reasons, strict=True)
    kept = [recording for recording, reason in pairs if recording and not reason]
    if not kept or data.model is None:
        none = f"none of its {len(reasons)} recordings can be used; the first: "
        return asdict(_Observed(f"{none if len(reasons) > 1 else ''}{reasons[0]}"))
    observed = _Observed(
        reasons=reasons, remarks=timing_remarks(kept), kind=kind(kept[0], data.model)
    )
    try:
        return asdict(replace(observed, observation=observe(kept, data.model)))
    except TendonError as error:
        return asdict(replace(observed, error=str(error)))


def _fit_series(_: None, task: tuple[RigData, list[float], _Changes]) -> dict[str, Any]:
    (recordings, _reasons, model), start, changes = task
    read = [recording for recording in recordings if recording]
    series = fit_series(read, model, start, changes) if model else []
    return {"series": [asdict(one) for one in series]}


class _RigFiles:
    """Keeps a JSON file for each rig, valid for one digest of its inputs, and if it has no error.

    ``of``: rig → digest of the inputs of its file; ``again``: whether all are computed again.
    """

    def __init__(self, folder: Path, of: Mapping[str, str], *, again: bool = False) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._folder, self._of = folder, of
        self.results = dict[str, dict[str, Any]]()
        for rig in () if again else of:
            with suppress(OSError, ValueError, KeyError, TypeError):
                kept = json.loads((folder / f"{rig}.json").read_text(encoding="utf-8"))
                if kept["of"] == of[rig] and not kept["result"].get("error"):
                    self.results[rig] = kept["result"]

    def done(self) -> Collection[str]:
        """Rigs with a valid file."""
        return self.results.keys()

    def write(self, key: str, result: Mapping[str, Any]) -> None:
        """Keep the result of a rig."""
        text = json.dumps({"of": self._of[key], "result": result}, default=np.ndarray.tolist)
        with whole_file(self._folder / f"{key}.json") as made:
            made.write_text(text, encoding="utf-8")
        self.results[key] = json.loads(text)["result"]


def _restored(kept: type[_Kept], values: Mapping[str, Any]) -> _Kept:
    """A dataclass out of what `asdict` and JSON made of it."""
    read: dict[Any, Callable[[Any], Any]] = {
        "FloatArray": partial(np.array, dtype=float),
        "tuple[float, ...]": tuple,
        "Number": partial(_restored, Number),
        "tuple[Number, ...]": lambda many: tuple(_restored(Number, one) for one in many),
        "Observation | None": lambda one: one and _restored(Observation, one),
    }
    kinds = {one.name: one.type for one in fields(kept)}  # type: ignore[arg-type]
    return kept(**{name: read.get(kinds[name], lambda v: v)(v) for name, v in values.items()})


def _result(
    rig: Rig, observed: _Observed, series: Sequence[NumberSeries], spreads: Mapping[Label, float]
) -> RigResult:
    """The result of one rig, before it is compared."""
    observation = observed.observation
    remarks = [
        f"{table} is left out: " + reason.removeprefix(str(table)).lstrip(":, ").removesuffix(".")
        for (table, _), reason in zip(rig.files.values(), observed.reasons, strict=False)
        if reason
    ]
    remarks += observed.remarks
    if observation is None:
        return RigResult(name=rig.name, dates=rig.dates, error=observed.error, remarks=remarks)
    dates = rig.without(observed.reasons).dates
    names = [number.name for number in observation.fitted]
    values = dict(zip(names, observation.values.tolist(), strict=True))
    without, misfits = one_out(observation)
    misfit = _rms(observation.square)
    unchanged = RigResult(
        name=rig.name,
        dates=dates,
        values=values,
        errors=dict(zip(names, observation.errors.tolist(), strict=True)),
        one_out={**dict(zip(names, without.T.tolist(), strict=True)), MISFIT: misfits.tolist()},
        misfit=misfit,
        left=misfit,
        square=observation.square.tolist(),
        remarks=remarks,
    )
    if not series:
        return unchanged
    first, rivals = explanation(series)
    deviations = np.hypot(
        first.errors, spreads[first.number.label] * first.probe / first.number.probe
    )
    change = find_change(dates, first.values, deviations, first.range)
    if change.significance < SIGNIFICANT:
        return unchanged
    before = {**first.others, first.number.name: change.before}
    return replace(
        unchanged,
        values={name: before.get(name, value) for name, value in values.items()},
        one_out={MISFIT: [_rms(np.delete(first.square, k)) for k in range(len(dates))]},
        left=_rms(first.square),
        square=first.square.tolist(),
        change=change,
        series=first,
        rivals=rivals,
    )


def _compared(
    rigs: Sequence[RigResult],
    seen: Mapping[str, Observation],
    other_kinds: Mapping[str, Sequence[str]],
) -> FleetResult:
    """Compare the fitted numbers between rigs; ``other_kinds``: see `unlike`."""
    units = {n.name: n.unit for observation in seen.values() for n in observation.fitted}
    fitted = [rig for rig in rigs if not rig.error]
    spreads, outliers = _outliers(fitted, units)
    usual = float(np.median([rig.left for rig in fitted])) if fitted else 0.0

    def judged(rig: RigResult) -> RigResult:
        differences = outliers[rig.name]
        known = any(one.name == MISFIT for one in differences)  # reported already
        remarks = (
            *rig.remarks,
            other_kind(other_kinds.get(rig.name, ())),
            remaining(rig.left, usual) if rig.change and not known else "",
            odd_day(rig.dates, rig.square, usual),
        )
        kept = list(filter(None, remarks))
        return replace(rig, differences=differences, compared=len(fitted), remarks=kept)

    return FleetResult([rig if rig.error else judged(rig) for rig in rigs], spreads, units)


def _outliers(
    fitted: Sequence[RigResult], names: Iterable[str]
) -> tuple[dict[str, FleetSpread], dict[str, list[RigDifference]]]:
    """Spread of each number between rigs, and in what each rig differs from the others."""
    spreads = dict[str, FleetSpread]()
    outliers: dict[str, list[RigDifference]] = {rig.name: [] for rig in fitted}
    for name in names:
        having = [rig for rig in fitted if name in rig.values]
        values = {rig.name: rig.values[name] for rig in having}
        errors = {rig.name: rig.errors[name] for rig in having}
        spreads[name] = spread_between(values, errors)
        others = {rig.name: rig.one_out.get(name, ()) for rig in fitted}
        for other, one in rig_differences(name, values, errors, spreads[name], others).items():
            outliers[other].append(one)
    if fitted:
        others = {rig.name: rig.one_out.get(MISFIT, ()) for rig in fitted}
        for other, one in larger_misfits({rig.name: rig.left for rig in fitted}, others).items():
            outliers[other].append(one)
    return spreads, outliers


def _rms(square: FloatArray) -> float:
    return float(np.sqrt(np.mean(square)))
