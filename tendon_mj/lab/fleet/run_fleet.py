"""A fleet of rigs of one kind: which one changed, in what and since when, and which one differs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from tendon_mj.errors import TendonError
from tendon_mj.lab.fleet.changes import SIGNIFICANT, reproducibility, suspects
from tendon_mj.lab.fleet.fellows import (
    MISFIT,
    Difference,
    Spread,
    differences,
    larger_misfits,
    spread_between,
)
from tendon_mj.lab.fleet.number import Label
from tendon_mj.lab.fleet.observation import Observation, observe
from tendon_mj.lab.fleet.one_out import one_out
from tendon_mj.lab.fleet.remarks import kind, left_out, left_over, odd_day, odd_times, unlike
from tendon_mj.lab.fleet.result import FleetFound, RigFound
from tendon_mj.lab.fleet.rig import Rig, find_rigs, none_left
from tendon_mj.lab.fleet.series import Asked, Series, explanation, fit_series
from tendon_mj.lab.fleet.since import find_change
from tendon_mj.lab.fleet.store import RigFiles, digest_of
from tendon_mj.lab.fleet.suited import suited
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.tasks import Workers, run_tasks
from tendon_mj.models import load_model, model_digest

_ERROR, _SERIES, _REFUSED, _TIMES = "error", "series", "refused", "times"

_Refused = dict[datetime, str]  # date of a recording → why it is left out
_Task = tuple[dict[datetime, Recording], _Refused, mujoco.MjModel] | str


def run_fleet(
    folder: Path,
    out: Path,
    *,
    on: Workers | None = None,
    again: bool = False,
    begin: Callable[[], None] = lambda: None,
    progress: Progress = silent,
) -> FleetFound:
    """Find which rigs of a fleet changed, and which differ from their fellows.

    Each rig is calibrated by itself. What differs between days where nothing changed, and between
    rigs that are alike, is estimated from all of them, and is what a change or a difference is
    judged by. A recording that cannot be read or fitted is left out, and told. What was computed of
    a rig is kept in ``out``, and is computed again only where its recordings, its model or the
    version are others.

    Args:
        folder: see `find_rigs`.
        out: for what is kept; no rig is sought in it.
        on: where to run; default: this machine's cores.
        again: compute also what is kept.
        begin: called when nothing more is refused, before the first rig is computed.
        progress: called with a label, how many rigs are done, and of how many.

    Raises:
        RecordingError: the folder is no fleet, or a file of it cannot be read.
        WorkerError: see `run_tasks`.
    """
    whole = {rig.name: rig for rig in find_rigs(folder, apart=out)}
    rigs = dict(whole)
    errors = {name: rig.error for name, rig in rigs.items() if rig.error}
    of, kinds = dict[str, str](), dict[str, dict[str, str]]()
    for name, rig in rigs.items():
        try:
            if not rig.error:
                kinds[name] = _kind(rig)
                of[name] = digest_of(rig, kinds[name]["model"])
        except (TendonError, OSError) as error:
            errors[name] = str(error)
    kept = RigFiles(out / "observations", of, again=again)
    run_tasks(
        _observe,
        None,
        list(of),
        lambda name: _task(rigs[name]),
        kept,
        on=on,
        begin=begin,
        progress=progress,
        what="calibrate",
    )
    read = {name: kept.read(name) for name in of}
    errors |= {name: found[_ERROR] for name, found in read.items() if _ERROR in found}
    seen = {n: Observation.from_plain(f) for n, f in read.items() if _ERROR not in f}
    refused = {name: _refused(found) for name, found in read.items()}
    rigs |= {name: rigs[name].without(refused[name]) for name in seen}
    spreads = reproducibility(list(seen.values()))
    asked = {
        name: [
            Asked(one.numbers[s.index], tuple((s.change * s.template.weights).tolist()))
            for s in suspects(one, rigs[name].dates, spreads)
        ]
        for name, one in seen.items()
    }
    digests = {name: f"{of[name]} {found}" for name, found in asked.items() if found}
    daily = RigFiles(out / "changes", digests, again=again)
    run_tasks(
        _fit_series,
        None,
        list(digests),
        lambda name: (_task(rigs[name]), seen[name].terms.tolist(), asked[name]),
        daily,
        on=on,
        progress=progress,
        what="day by day",
    )
    series = {n: [Series.from_plain(one) for one in daily.read(n)[_SERIES]] for n in digests}
    found = [
        replace(
            _found(rig, seen.get(name), series.get(name, []), spreads, errors.get(name, "")),
            remarks=(
                *left_out(whole[name].tables, refused.get(name, {})),
                *read.get(name, {}).get(_TIMES, []),
            ),
        )
        for name, rig in rigs.items()
    ]
    odd = unlike({name: kinds[name] for name in seen})
    return _beside_fellows(found, _units(seen.values()), odd)


def _task(rig: Rig) -> _Task:
    """A rig's recordings, why others are left out, and its model; or why there are none."""
    recordings, refused = rig.read_each()
    if not recordings:
        return none_left(rig.dates, refused[rig.dates[0]])
    try:
        return recordings, refused, _model_of(next(iter(recordings.values())))
    except (TendonError, OSError) as error:
        return str(error)


def _model_of(recording: Recording) -> mujoco.MjModel:
    return load_model(recording.model, beside=recording.beside)


def _kind(rig: Rig) -> dict[str, str]:
    """What a rig has to have as its fellows have it, see `kind`."""
    first = rig.read_first()
    return kind(first, model_digest(_model_of(first)))


def _observe(_: None, task: _Task) -> dict[str, Any]:
    if isinstance(task, str):
        return {_ERROR: task}
    recordings, refused, model = task
    kept, unsuited = suited(recordings, model)
    refused |= unsuited
    if not kept:
        return {_ERROR: none_left(refused, refused[min(refused)])}
    told = {
        _REFUSED: {date.isoformat(): reason for date, reason in refused.items()},
        _TIMES: odd_times(kept.values()),
    }
    try:
        return observe(tuple(kept.values()), model).plain() | told
    except TendonError as error:
        return {_ERROR: str(error)} | told


def _refused(found: Mapping[str, Any]) -> _Refused:
    """Date → why a recording is left out, of what `_observe` found."""
    given: Mapping[str, str] = found.get(_REFUSED, {})
    return {datetime.fromisoformat(date): reason for date, reason in given.items()}


def _fit_series(_: None, given: tuple[_Task, list[float], list[Asked]]) -> dict[str, Any]:
    task, start, asked = given
    if isinstance(task, str):
        return {_SERIES: []}
    recordings, _refusals, model = task
    found = fit_series(tuple(recordings.values()), start, asked, model)
    return {_SERIES: [one.plain() for one in found]}


def _found(
    rig: Rig,
    observation: Observation | None,
    series: Sequence[Series],
    spreads: Mapping[Label, float],
    error: str,
) -> RigFound:
    """What is found of a rig by itself."""
    make = partial(RigFound, name=rig.name, dates=rig.dates)
    if observation is None:
        return make(error=error, values={}, errors={})
    names = [number.name for number in observation.numbers[: observation.shared]]
    values = dict(zip(names, observation.values.tolist(), strict=True))
    errors = dict(zip(names, observation.errors.tolist(), strict=True))
    misfit = _misfit(observation.square)
    make = partial(make, errors=errors, misfit=misfit)
    without, misfits = one_out(observation)
    unchanged = make(
        values=values,
        left=misfit,
        square=tuple(observation.square.tolist()),
        one_out={**dict(zip(names, without.T.tolist(), strict=True)), MISFIT: misfits.tolist()},
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
    return make(
        values={name: before.get(name, value) for name, value in values.items()},
        left=_misfit(first.square),
        square=tuple(first.square.tolist()),
        one_out={MISFIT: [_misfit(np.delete(first.square, k)) for k in range(len(rig.dates))]},
        change=change,
        series=first,
        rivals=tuple(rivals),
    )


def _beside_fellows(
    rigs: Sequence[RigFound], units: Mapping[str, str], odd: Mapping[str, str]
) -> FleetFound:
    """Compare what was fitted between rigs; ``odd``: rig → in what it is not comparable."""
    solid = [rig for rig in rigs if not rig.error]
    spreads: dict[str, Spread] = {}
    different: dict[str, list[Difference]] = {rig.name: [] for rig in rigs}
    for name in units:
        values = {rig.name: rig.values[name] for rig in solid if name in rig.values}
        errors = {rig.name: rig.errors[name] for rig in solid if name in rig.values}
        spreads[name] = spread_between(values, errors)
        others = {rig.name: rig.one_out.get(name, ()) for rig in solid}
        for rig, one in differences(name, values, errors, spreads[name], others).items():
            different[rig].append(one)
    if solid:
        others = {rig.name: rig.one_out.get(MISFIT, ()) for rig in solid}
        for rig, one in larger_misfits({rig.name: rig.left for rig in solid}, others).items():
            different[rig].append(one)
    usual = float(np.median([rig.left for rig in solid])) if solid else 0.0
    compared = [
        rig
        if rig.error
        else replace(
            rig,
            differences=tuple(different[rig.name]),
            fellows=len(solid),
            remarks=(
                *rig.remarks,
                *_remarks(rig, different[rig.name], usual, odd.get(rig.name, "")),
            ),
        )
        for rig in rigs
    ]
    return FleetFound(compared, spreads, units)


def _remarks(
    rig: RigFound, different: Sequence[Difference], usual: float, odd: str
) -> tuple[str, ...]:
    is_told = any(one.name == MISFIT for one in different)  # that much is left
    more = left_over(rig.left, usual) if rig.change and not is_told else ""
    return tuple(text for text in (odd, more, odd_day(rig.dates, rig.square, usual)) if text)


def _units(observations: Any) -> dict[str, str]:
    return {
        number.name: number.unit for one in observations for number in one.numbers[: one.shared]
    }


def _misfit(square: Any) -> float:
    return float(np.sqrt(np.mean(square)))
