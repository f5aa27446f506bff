"""The workflow: calibrate, locate, name, abstain, prove.

Verdicts:

* "nothing missing": calibrated, the model leaves no more than noise and numerics.
* "parameter": what is left goes away when a number that nobody called uncertain is corrected.
* "named": effects that the model lacks make it go away, on data that chose nothing too.
* "unknown": structure remains that nothing in the catalogue explains.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from tendon_mj.diagnosis.catalogue import CATALOGUE, candidates
from tendon_mj.diagnosis.contest import Entrant, Setting
from tendon_mj.diagnosis.effect import Rig, Term
from tendon_mj.diagnosis.gap import Gap, measure_gap
from tendon_mj.diagnosis.interval import intervals
from tendon_mj.diagnosis.locate import locate
from tendon_mj.diagnosis.name import Named, Naming, name_effects
from tendon_mj.diagnosis.numerics import numerical_floor
from tendon_mj.diagnosis.problem import Make, Problem, for_choices, whole
from tendon_mj.diagnosis.regimes import motion
from tendon_mj.diagnosis.verdict import Diagnosis, Finding, Value, Verdict
from tendon_mj.errors import RecordingError
from tendon_mj.simulate.progress import Progress, silent
from tendon_mj.simulate.recording import Recording
from tendon_mj.simulate.simulator import Simulator

_CLOSED = 0.93  # of the reducible gap: with less, a name is no explanation
_NEGLIGIBLE = 0.5  # gap in noise power that is no reason to doubt a name
_FEWEST = 50  # samples
_MARGIN = 0.01  # of its range: nearer to an end a calibrated value is held by it
_LARGEST = 8.0  # the same, above which nothing is named (3 noise rms): most of it is something else


def diagnose(
    train: Sequence[Recording],
    held_out: Sequence[Recording] = (),
    simulator: Make = Simulator,
    *,
    exclude: Collection[str] = (),
    progress: Progress = silent,
) -> Diagnosis:
    """Find what a model lacks against recordings, or which of its numbers is wrong.

    Args:
        train: recordings of one model, for all choices and fits.
        held_out: recordings for the proof alone; without any, the last quarter of each of
            ``train`` is kept for it.
        simulator: makes what simulates recordings; see `tendon_mj.simulate.simulator`.
        exclude: identifiers of effects that are not to be considered.
        progress: called with a label, how much is done, and of how much.

    Raises:
        RecordingError: no recording, recordings of different models or descriptions, nothing
            measured, nothing that moves back and forth, the same data for choice and proof, or
            data under which the model as described becomes unstable.
        UnknownNameError: ``exclude`` names no effect of the catalogue.
    """
    began = time.perf_counter()
    check(train, held_out)
    problem = Problem(tuple(train), simulator(train), for_choices(train, held_out))
    base = {name: p.value for name, p in problem.simulate.parameters.items()}
    _simulates(problem)
    catalogue = tuple(candidates(look_at(problem), frozenset(exclude)))
    calibrated = tuple(
        Term(
            (name,),
            problem.simulate.parameters[name].unit,
            u.value,
            u.low,
            u.high,
            (u.high - u.low) / 20.0,
        )
        for name, u in train[0].uncertain.items()
        if u.high > u.low
    )
    progress("calibrate", 0, 2)
    setting = Setting(problem, base, calibrated, (), 0.0, progress)
    start = setting.enter((), [term.inert for term in calibrated])
    progress("calibrate", 1, 2)
    floor = numerical_floor(problem, start.fit.parameters(base))
    progress("calibrate", 2, 2)
    setting = Setting(problem, base, calibrated, catalogue, floor, progress)
    naming = name_effects(setting, start)
    proof = Problem(tuple(held_out), simulator(held_out), whole(held_out)) if held_out else problem
    return _conclude(setting, naming, proof, bool(held_out), began)


def check(train: Sequence[Recording], held_out: Sequence[Recording]) -> None:
    """Refuse recordings from which no diagnosis can come.

    Raises:
        RecordingError: says which recording, and why.
    """
    if not train:
        raise RecordingError("a diagnosis needs at least one recording")
    first = train[0]
    for recording in (*train, *held_out):
        where = f"recording {recording.name!r}"
        if not recording.measured:
            raise RecordingError(f"{where}: no column is in [measured]: nothing to compare with")
        for name in ("model", "known", "uncertain"):
            mine, theirs = getattr(recording, name), getattr(first, name)
            if mine != theirs:
                raise RecordingError(
                    f"{where}: its {name} {_plain(mine)!r} differs from {_plain(theirs)!r} of"
                    f" {first.name!r}; recordings that are diagnosed together are of one rig"
                )
        motion(recording)
        if recording.time.size < _FEWEST:
            raise RecordingError(
                f"{where}: {recording.time.size} samples; a diagnosis needs {_FEWEST} or more"
            )
        for column in recording.measured:
            if np.ptp(recording.columns[column]) == 0.0:
                raise RecordingError(
                    f"{where}, column {column!r}: never moves, so it tells nothing"
                )
    for recording in held_out:
        if any(_same_data(recording, other) for other in train):
            raise RecordingError(
                f"recording {recording.name!r}: held out, and among those that choose; proof needs"
                " data that no choice has seen"
            )


def _same_data(one: Recording, other: Recording) -> bool:
    return np.array_equal(one.time, other.time) and all(
        column in other.columns and np.array_equal(one.columns[column], other.columns[column])
        for column in one.measured
    )


def _simulates(problem: Problem) -> None:
    """Refuse recordings under which the model, as described, blows up.

    Raises:
        RecordingError: says which recording, and how far its drive goes.
    """
    answers = problem.simulate([{}])[0]
    for recording, series in zip(problem.recordings, answers, strict=True):
        if not all(np.isfinite(series[column]).all() for column in recording.measured):
            ranges = ", ".join(
                f"{column!r} from {recording.columns[column].min():.4g} to"
                f" {recording.columns[column].max():.4g}"
                for column in recording.drive
            )
            raise RecordingError(
                f"recording {recording.name!r}: model {recording.model!r} as described becomes"
                f" unstable under what drives it ({ranges}); are the units right?"
            )


def _plain(value: object) -> object:
    return dict(value) if isinstance(value, Mapping) else value


def look_at(problem: Problem) -> Rig:
    """What the catalogue may know of the model and the recordings."""
    spans: dict[str, float] = {}
    for recording in problem.recordings:
        for column, measured in recording.measured.items():
            span = float(np.ptp(recording.columns[column]))
            spans[measured.sensor] = max(spans.get(measured.sensor, 0.0), span) or 1.0
    first, parameters = problem.recordings[0], problem.simulate.parameters
    joints = sorted({n.rsplit(".", 1)[0] for n, p in parameters.items() if p.kind == "joint"})
    driven = [j for j, is_driven in getattr(problem.simulate, "joints", {}).items() if is_driven]
    return Rig(
        values={name: parameter.value for name, parameter in parameters.items()},
        known=frozenset(first.known),
        uncertain=frozenset(first.uncertain),
        spans=spans,
        inputs=tuple(first.drive.values()),
        free_joints=tuple(joint for joint in joints if joint not in driven),
    )


def _conclude(
    setting: Setting, naming: Naming, proof: Problem, held_out: bool, began: float
) -> Diagnosis:
    problem, base = setting.problem, setting.base
    mask = np.ones(proof.chosen.size, bool) if held_out else ~problem.chosen

    def gaps(after: Entrant) -> tuple[Gap, Gap]:
        """On what the choices saw, and on the proof."""
        fits = naming.calibrated.fit, after.fit
        seen = fits[0].residual, fits[1].residual
        fresh = proof.residuals([f.parameters(base) for f in fits]) if held_out else seen
        return (
            measure_gap(problem, *seen, problem.chosen),
            measure_gap(proof, fresh[0], fresh[1], mask),
        )

    tentative = gaps(naming.final)
    verdict = _decide(setting, naming, tentative[1])
    findings = tuple(_finding(named) for named in naming.named)
    found = verdict in ("named", "parameter")
    model = naming.final if found else naming.calibrated
    train, proven = tentative if found else gaps(model)
    calibrated = _values(setting, model, own=False)
    return Diagnosis(
        verdict=verdict,
        sentence=_say(verdict, findings, tentative[1]) + _doubt(calibrated),
        findings=findings if found else (),
        closest=() if found else tuple(finding.identifier for finding in findings),
        calibrated=calibrated,
        parameters=_values(setting, model, own=True),
        train=train,
        held_out=proven,
        located=locate(problem, naming.calibrated.fit.residual),
        remaining=locate(problem, model.fit.residual),
        before={**base, **naming.calibrated.fit.parameters(base)},
        model={**base, **model.fit.parameters(base)},
        seconds=time.perf_counter() - began,
    )


def _decide(setting: Setting, naming: Naming, proven: Gap) -> Verdict:
    """The verdict, from what the data that chose nothing say."""
    if not naming.named:
        return "nothing missing" if naming.calibrated.gap <= setting.least else "unknown"
    left = proven.after**2 - proven.noise_floor**2
    open_still = proven.reducible_closed < _CLOSED and left > max(_NEGLIGIBLE, setting.least)
    if open_still or left > max(_LARGEST, setting.least):
        return "unknown"
    missing = any(named.candidate.kind == "missing" for named in naming.named)
    return "named" if missing else "parameter"


def _finding(named: Named) -> Finding:
    effect = CATALOGUE[named.candidate.identifier]
    return Finding(
        identifier=effect.identifier,
        name=effect.name,
        equation=effect.equation,
        where=named.candidate.where,
        kind=effect.kind,
        confidence=named.confidence,
        rivals=tuple(dict.fromkeys(other.identifier for other, _ in named.rivals)),
    )


def _values(setting: Setting, model: Entrant, own: bool) -> dict[str, Value]:
    """Fitted parameters: of the findings, or with ``own`` False the calibrated ones."""
    fit, base = model.fit, setting.base
    written = fit.parameters(base)
    ranges = intervals(setting.problem, fit)
    first = len(fit.calibrated)
    values = {}
    for k, term in enumerate(fit.terms):
        if (k >= first) != own:
            continue
        held = bool(fit.free[k]) and (own or _clear_of_ends(fit.values[k], term))
        span = ranges[k] if held else (term.low, term.high)
        for target in term.targets:
            ends = [term.write(float(end), {**base, **written})[target] for end in span]
            unit = setting.problem.simulate.parameters[target].unit
            values[target] = Value(written[target], min(ends), max(ends), unit, base[target], held)
    return values


def _clear_of_ends(value: float, term: Term) -> bool:
    """Whether a calibrated value lies inside its range; the fit never quite reaches an end."""
    margin = _MARGIN * (term.high - term.low)
    return bool(term.low + margin < value < term.high - margin)


def _doubt(calibrated: Mapping[str, Value]) -> str:
    """What to say of uncertain values that the data would take beyond their range."""
    return "".join(
        f" {name} stands at an end of its range, {value.low:g} … {value.high:g} {value.unit}: if"
        " that is not the rig's limit, widen it."
        for name, value in calibrated.items()
        if not value.determined
    )


def _say(verdict: Verdict, findings: Sequence[Finding], gap: Gap) -> str:
    shrank = (
        f"on data that chose nothing the error goes from {gap.before:.2f} to {gap.after:.2f} times"
        f" the noise, which closes {gap.reducible_closed:.0%} of what could be closed"
    )
    if verdict == "nothing missing":
        return (
            f"Nothing is missing: calibrated, the model is off by {gap.before:.2f} times the noise."
        )
    names = ", and ".join(
        f"{finding.name} ({finding.where})"
        + (
            f" – or {' or '.join(finding.rivals)}, these data can't tell –"
            if finding.rivals
            else ""
        )
        for finding in findings
    )
    if verdict == "unknown":
        closest = f" The closest is {names}, but {shrank}." if findings else ""
        return f"Something is missing that the catalogue does not hold.{closest}"
    if verdict == "parameter":
        return f"A parameter was wrong: {names}; {shrank}."
    return f"Missing: {names}; {shrank}."
