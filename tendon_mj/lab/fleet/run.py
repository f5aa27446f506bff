"""Analysis of a fleet: each rig by itself, then its changes day by day, then the comparison."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from tendon_mj.errors import RecordingError, TendonError
from tendon_mj.lab.fleet.changes import SIGNIFICANT, daily_deviations, find_change, suspects
from tendon_mj.lab.fleet.comparison import (
    MISFIT,
    FleetSpread,
    RigDifference,
    kind,
    larger_misfits,
    rig_differences,
    spread_between,
    unlike,
)
from tendon_mj.lab.fleet.observation import Label, Number, Observation, observe, one_out, usable
from tendon_mj.lab.fleet.result import (
    FleetFound,
    RigFound,
    left_out,
    odd_day,
    other_kind,
    remaining,
    timing_remarks,
)
from tendon_mj.lab.fleet.rigs import Rig, unusable
from tendon_mj.lab.fleet.series import NumberSeries, explanation, fit_series
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.tasks import Workers, run_tasks, versions
from tendon_mj.models import load_model, model_digest
from tendon_mj.typing import FloatArray
from tendon_mj.whole_file import whole_file

_Recordings = tuple[dict[datetime, Recording], dict[datetime, str], mujoco.MjModel]
_Changes = dict[Number, tuple[float, ...]]  # number → change on each day [probes]


@dataclass(frozen=True)
class _Observed:
    """Result of the first pass over a rig, as it is kept.

    Attributes:
        error: why there is no observation; empty where there is one.
        observation: of its recordings.
        refused: date in ISO 8601 → why that recording is left out.
        remarks: on the times of its recordings.
    """

    error: str = ""
    observation: Observation | None = None
    refused: Mapping[str, str] = field(default_factory=dict)
    remarks: Sequence[str] = ()

    @property
    def left_out(self) -> dict[datetime, str]:
        """Date → why that recording is left out."""
        return {datetime.fromisoformat(date): reason for date, reason in self.refused.items()}


def run_fleet(
    rigs: Sequence[Rig],
    out: Path,
    *,
    on: Workers | None = None,
    again: bool = False,
    begin: Callable[[], None] = lambda: None,
    progress: Progress = silent,
) -> FleetFound:
    """Find which rigs of a fleet changed, and which differ from the others.

    Each rig is calibrated by itself. The scatter between days where nothing changed, and between
    rigs that are alike, is estimated from all of them, and changes and differences are tested
    against it. A recording that cannot be used is left out with a remark. Results are kept in
    ``out``, and computed again where a rig's recordings, its model or the version changed.

    Args:
        rigs: see `find_rigs`.
        out: folder for intermediate results.
        on: where to run; default: this machine's cores.
        again: compute everything again.
        begin: called before the first rig is computed, when nothing more is refused.
        progress: called with a label, how many rigs are done, and of how many.

    Raises:
        WorkerError: see `run_tasks`.
    """
    run = partial(run_tasks, on=on, progress=progress)
    by_name = {rig.name: rig for rig in rigs}
    digests, kinds, errors = _digests(rigs)
    first = _RigFiles(out / "observations", digests, again=again)
    run(
        _observe,
        None,
        list(digests),
        lambda name: _read(by_name[name]),
        first,
        begin=begin,
        what="calibrate",
    )
    observed = {name: _restored(first.read(name)) for name in digests}
    observed |= {name: _Observed(error=error) for name, error in errors.items()}
    seen = {name: one.observation for name, one in observed.items() if one.observation}
    used = {name: by_name[name].without(observed[name].left_out) for name in seen}
    spreads = daily_deviations(list(seen.values()))
    suspected = _suspected(used, seen, spreads)
    of = {name: f"{digests[name]} {changes}" for name, changes in suspected.items()}
    second = _RigFiles(out / "changes", of, again=again)
    run(
        _fit_series,
        None,
        list(suspected),
        lambda name: (_read(used[name]), seen[name].terms.tolist(), suspected[name]),
        second,
        what="day by day",
    )
    series = {name: [_series(one) for one in second.read(name)["series"]] for name in suspected}
    results = [_result(rig, observed[rig.name], series.get(rig.name, []), spreads) for rig in rigs]
    return _compared(results, seen, unlike({name: kinds[name] for name in seen}))


def _suspected(
    rigs: Mapping[str, Rig], seen: Mapping[str, Observation], spreads: Mapping[Label, float]
) -> dict[str, _Changes]:
    """Rig → the numbers that may have changed, of the rigs that have any."""
    changes = {
        name: {
            observation.numbers[s.index]: tuple((s.change * s.template.weights).tolist())
            for s in suspects(observation, rigs[name].dates, spreads)
        }
        for name, observation in seen.items()
    }
    return {name: numbers for name, numbers in changes.items() if numbers}


def _digests(
    rigs: Sequence[Rig],
) -> tuple[dict[str, str], dict[str, dict[str, str]], dict[str, str]]:
    """Rig → digest of its files, model and versions; → its `kind`; and → why it cannot be used."""
    digests, kinds, errors = dict[str, str](), dict[str, dict[str, str]](), dict[str, str]()
    for rig in rigs:
        digest = hashlib.sha256(json.dumps(versions(), sort_keys=True).encode())
        try:
            if rig.error:
                raise RecordingError(rig.error)
            first = rig.read_first()
            kinds[rig.name] = kind(first, model_digest(_model_of(first)))
        except (TendonError, OSError) as error:
            errors[rig.name] = str(error)
            continue
        digest.update(kinds[rig.name]["model"].encode())
        for date, table in rig.tables.items():
            digest.update(date.isoformat().encode())
            for file in (table, rig.descriptions[date]):
                with suppress(OSError):  # it is left out when it is read
                    digest.update(file.read_bytes())
        digests[rig.name] = digest.hexdigest()[:16]
    return digests, kinds, errors


def _read(rig: Rig) -> _Recordings:
    recordings, refused = rig.read()
    return recordings, refused, _model_of(next(iter(recordings.values())))


def _model_of(recording: Recording) -> mujoco.MjModel:
    return load_model(recording.model, beside=recording.beside)


def _observe(_: None, task: _Recordings) -> dict[str, Any]:
    recordings, refused, model = task
    kept, unsuited = usable(recordings, model)
    refused = refused | unsuited
    if not kept:
        return asdict(_Observed(unusable(refused)))
    observed = _Observed(
        refused={date.isoformat(): reason for date, reason in refused.items()},
        remarks=timing_remarks(kept.values()),
    )
    try:
        return asdict(replace(observed, observation=observe(tuple(kept.values()), model)))
    except TendonError as error:
        return asdict(replace(observed, error=str(error)))


def _fit_series(_: None, task: tuple[_Recordings, list[float], _Changes]) -> dict[str, Any]:
    (recordings, _refused, model), start, changes = task
    series = fit_series(tuple(recordings.values()), model, start, changes)
    return {"series": [asdict(one) for one in series]}


class _RigFiles:
    """Keeps a JSON file for each rig, valid for one digest of its inputs.

    Args:
        folder: made if it does not exist.
        of: rig → digest of the inputs of its file.
        again: whether existing files are computed again.
    """

    def __init__(self, folder: Path, of: Mapping[str, str], *, again: bool = False) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._folder, self._of = folder, of
        self._done = set[str]() if again else {rig for rig in of if self._valid(rig)}

    def done(self) -> set[str]:
        """Rigs with a valid file."""
        return set(self._done)

    def write(self, key: str, result: Mapping[str, Any]) -> None:
        """Keep the result of a rig."""
        text = json.dumps({"of": self._of[key], "found": result}, default=np.ndarray.tolist)
        with whole_file(self._folder / f"{key}.json") as made:
            made.write_text(text, encoding="utf-8")

    def read(self, key: str) -> dict[str, Any]:
        """The result of a rig."""
        text = (self._folder / f"{key}.json").read_text(encoding="utf-8")
        return dict(json.loads(text)["found"])

    def _valid(self, rig: str) -> bool:
        try:
            kept = json.loads((self._folder / f"{rig}.json").read_text(encoding="utf-8"))
            return bool(kept["of"] == self._of[rig])
        except (OSError, ValueError, KeyError, TypeError):
            return False


def _restored(fields: Mapping[str, Any]) -> _Observed:
    observation = fields["observation"]
    if observation is not None:
        numbers = tuple(_number(one) for one in observation["numbers"])
        observation = Observation(**{**_with_arrays(observation, "numbers"), "numbers": numbers})
    return _Observed(**{**fields, "observation": observation})


def _series(fields: Mapping[str, Any]) -> NumberSeries:
    return NumberSeries(**{**_with_arrays(fields), "number": _number(fields["number"])})


def _number(fields: Mapping[str, Any]) -> Number:
    return Number(**{**fields, "shape": tuple(fields["shape"])})


def _with_arrays(fields: Mapping[str, Any], without: str = "") -> dict[str, Any]:
    return {
        name: np.array(value, float) if isinstance(value, list) else value
        for name, value in fields.items()
        if name != without
    }


def _result(
    rig: Rig, observed: _Observed, series: Sequence[NumberSeries], spreads: Mapping[Label, float]
) -> RigFound:
    """The result of one rig, before it is compared."""
    remarks = (*left_out(rig.tables, observed.left_out), *observed.remarks)
    observation = observed.observation
    if observation is None:
        return RigFound(name=rig.name, dates=rig.dates, error=observed.error, remarks=remarks)
    rig = rig.without(observed.left_out)
    names = [number.name for number in observation.fitted]
    values = dict(zip(names, observation.values.tolist(), strict=True))
    misfit = _rms(observation.square)
    without, misfits = one_out(observation)
    unchanged = RigFound(
        name=rig.name,
        dates=rig.dates,
        values=values,
        errors=dict(zip(names, observation.errors.tolist(), strict=True)),
        one_out={**dict(zip(names, without.T.tolist(), strict=True)), MISFIT: misfits.tolist()},
        misfit=misfit,
        left=misfit,
        square=tuple(observation.square.tolist()),
        remarks=remarks,
    )
    if not series:
        return unchanged
    first, rivals = explanation(series)
    deviations = np.hypot(
        first.errors, spreads[first.number.label] * first.probe / first.number.probe
    )
    change = find_change(rig.dates, first.values, deviations, first.range)
    if change.significance < SIGNIFICANT:
        return unchanged
    before = {**first.others, first.number.name: change.before}
    return replace(
        unchanged,
        values={name: before.get(name, value) for name, value in values.items()},
        one_out={MISFIT: [_rms(np.delete(first.square, k)) for k in range(len(rig.dates))]},
        left=_rms(first.square),
        square=tuple(first.square.tolist()),
        change=change,
        series=first,
        rivals=tuple(rivals),
    )


def _compared(
    rigs: Sequence[RigFound],
    seen: Mapping[str, Observation],
    other_kinds: Mapping[str, Sequence[str]],
) -> FleetFound:
    """Compare the fitted numbers between rigs; ``other_kinds``: see `unlike`."""
    units = {n.name: n.unit for observation in seen.values() for n in observation.fitted}
    fitted = [rig for rig in rigs if not rig.error]
    spreads, outliers = _outliers(fitted, units)
    usual = float(np.median([rig.left for rig in fitted])) if fitted else 0.0
    compared = []
    for rig in rigs:
        if not rig.error:
            rig = replace(rig, differences=tuple(outliers[rig.name]), compared=len(fitted))
            remarks = _remarks(rig, usual, other_kinds.get(rig.name, ()))
            rig = replace(rig, remarks=(*rig.remarks, *filter(None, remarks)))
        compared.append(rig)
    return FleetFound(compared, spreads, units)


def _remarks(rig: RigFound, usual: float, other_parts: Sequence[str]) -> tuple[str, str, str]:
    is_outlier = any(one.name == MISFIT for one in rig.differences)  # reported already
    return (
        other_kind(other_parts),
        remaining(rig.left, usual) if rig.change and not is_outlier else "",
        odd_day(rig.dates, rig.square, usual),
    )


def _outliers(
    rigs: Sequence[RigFound], units: Mapping[str, str]
) -> tuple[dict[str, FleetSpread], dict[str, list[RigDifference]]]:
    """Parameter → spread between rigs, and rig → its differences."""
    spreads = dict[str, FleetSpread]()
    outliers: dict[str, list[RigDifference]] = {rig.name: [] for rig in rigs}
    for name in units:
        having = [rig for rig in rigs if name in rig.values]
        values = {rig.name: rig.values[name] for rig in having}
        errors = {rig.name: rig.errors[name] for rig in having}
        spreads[name] = spread_between(values, errors)
        others = {rig.name: rig.one_out.get(name, ()) for rig in rigs}
        for rig, one in rig_differences(name, values, errors, spreads[name], others).items():
            outliers[rig].append(one)
    if rigs:
        others = {rig.name: rig.one_out.get(MISFIT, ()) for rig in rigs}
        for rig, one in larger_misfits({rig.name: rig.left for rig in rigs}, others).items():
            outliers[rig].append(one)
    return spreads, outliers


def _rms(square: FloatArray) -> float:
    return float(np.sqrt(np.mean(square)))
