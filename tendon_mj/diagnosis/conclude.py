"""From fitted models to a verdict: what is proven on data that chose nothing, and how to say it."""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import NDArray

from tendon_mj.diagnosis.contest import CLOSED, Entrant, Setting, grain, least_gap
from tendon_mj.diagnosis.effects.effect import Effect, Term
from tendon_mj.diagnosis.fit import Fit
from tendon_mj.diagnosis.gap import Gap, measure_gap
from tendon_mj.diagnosis.interval import beyond_range, intervals
from tendon_mj.diagnosis.locate import locate
from tendon_mj.diagnosis.name import Named, Naming
from tendon_mj.diagnosis.numerics import in_steps, step_error
from tendon_mj.diagnosis.problem import Problem
from tendon_mj.diagnosis.sentence import doubt, say
from tendon_mj.diagnosis.verdict import Diagnosis, Finding, Ranked, Value, Verdict

_LARGEST = 8.0  # gap (3 noise rms), or the grain: above it most is something else, and unnamed
_EXPLAINS = 0.01  # of the gap, to be in the ranking
_MARGIN = 0.01  # of its range: nearer to an end a calibrated value is held by it


def conclude(
    setting: Setting,
    naming: Naming,
    own: Problem,
    proof: Problem,
    steps: float | None,
    catalogue: Mapping[str, Effect],
    excluded: Collection[str],
    began: float,
) -> Diagnosis:
    """Prove what was named, decide, and put it into words.

    What decides is refined; what is stated is what anyone finds who replays the models.

    Args:
        setting, naming: the data, and the models that came of them.
        own: the same data in the model's own steps.
        proof: recordings that no choice has seen, likewise; ``own`` where only tails were kept.
        steps: in which the setting's problem is searched, see `in_steps`.
        catalogue: identifier → effect, of all that could have been named.
        excluded: effects that were not to be considered.
        began: when the diagnosis did (`time.perf_counter`) [s].
    """
    problem, base, held_out = setting.problem, setting.base, proof is not own
    mask = np.ones(proof.chosen.size, bool) if held_out else ~own.chosen
    fits = naming.calibrated.fit, naming.final.fit
    sets = [fitted.parameters(base) for fitted in fits]

    judged, fresh, added = problem, (fits[0].residual, fits[1].residual), fits[1].refined
    if held_out:
        judged = in_steps(proof, steps)
        rough = judged.residuals(sets)
        fresh = judged.refine(sets[0], rough[0]), judged.refine(sets[1], rough[1])
        added = fresh[1] - rough[1]
    least = least_gap(judged, step_error(added[mask]))
    refined = measure_gap(judged, fresh[0], fresh[1], mask)
    seen = own.residuals(sets)
    unseen = proof.residuals(sets) if held_out else seen
    stated = measure_gap(proof, unseen[0], unseen[1], mask)
    beyond = _beyond(problem, fits[1])
    most = max(_LARGEST, grain(judged))
    verdict = _decide(setting, naming, refined, stated, (least, most), bool(beyond))

    findings = tuple(_finding(named, catalogue) for named in naming.named)
    non_smooth = any(named.candidate.non_smooth for named in naming.named)
    excluded = sorted(excluded)
    found = verdict in ("named", "parameter")
    model = naming.final if found else naming.calibrated
    after = 1 if found else 0
    calibrated = _values(setting, model, own=False)
    return Diagnosis(
        verdict=verdict,
        sentence=say(verdict, findings, stated, refined.after, least, beyond, excluded, non_smooth)
        + doubt(calibrated),
        findings=findings if found else (),
        closest=() if found else tuple(finding.identifier for finding in findings),
        excluded=tuple(excluded),
        ranking=_ranking(naming, problem.chosen),
        calibrated=calibrated,
        parameters=_values(setting, model, own=True),
        train=measure_gap(own, seen[0], seen[after], own.chosen),
        held_out=measure_gap(proof, unseen[0], unseen[after], mask),
        located=locate(own, seen[0], own.chosen),  # to look is to choose
        remaining=locate(own, seen[after], own.chosen),
        proof=(locate(proof, unseen[0], mask), locate(proof, unseen[after], mask)),
        before={**base, **sets[0]},
        model={**base, **sets[after]},
        seconds=time.perf_counter() - began,
        catalogue=catalogue,
        simulator=proof.simulate,
        recordings=own.recordings,
        held_out_recordings=proof.recordings if held_out else (),
    )


def _decide(
    setting: Setting,
    naming: Naming,
    refined: Gap,
    stated: Gap,
    worth: tuple[float, float],
    beyond: bool,
) -> Verdict:
    """The verdict, from what the data that chose nothing say.

    Less than the first of ``worth`` is not worth a name, and more than the second may not remain
    [noise power].
    """
    least, most = worth
    left = refined.after**2 - refined.noise_floor**2
    if left > most:
        return "unknown"
    if not naming.named:
        small = naming.calibrated.gap <= setting.least and left <= least
        return "nothing missing" if small else "unknown"
    closed = refined.reducible_closed >= CLOSED or left <= least
    if not closed or beyond or stated.after >= stated.before:
        return "unknown"
    missing = any(named.candidate.kind == "missing" for named in naming.named)
    return "named" if missing else "parameter"


def _ranking(naming: Naming, chosen: NDArray[np.bool_]) -> tuple[Ranked, ...]:
    """Candidates for the first finding: fitted ones by what they leave, then by a look at them."""
    if naming.first is None:
        return ()
    excess = float(np.mean(naming.calibrated.fit.residual[chosen] ** 2)) - 1.0
    left = {
        entrant.candidate.label: float(np.sqrt(max(1.0 + entrant.gap, 0.0)))
        for entrant in naming.first.entrants
        if entrant.candidate is not None
    }
    ranked: dict[str, Ranked] = {}
    for sight in naming.first.sights:
        candidate, share = sight.candidate, min(sight.explained / excess, 1.0)
        if share >= _EXPLAINS:
            row = Ranked(candidate.identifier, candidate.where, share, left.get(candidate.label))
            ranked.setdefault(candidate.label, row)
    return tuple(
        sorted(ranked.values(), key=lambda r: (r.left is None, r.left or 0.0, -r.explains))
    )


def _finding(named: Named, catalogue: Mapping[str, Effect]) -> Finding:
    effect = catalogue[named.candidate.identifier]
    rivals = [other for other, _ in named.rivals]
    return Finding(
        identifier=effect.identifier,
        name=effect.name,
        equation=effect.equation,
        where=named.candidate.where,
        kind=effect.kind,
        confidence=named.confidence,
        rivals=tuple(
            dict.fromkeys(r.identifier for r in rivals if r.identifier != effect.identifier)
        ),
        elsewhere=tuple(r.where for r in rivals if r.identifier == effect.identifier),
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
        at_end = not own and not _clear_of_ends(fit.values[k], term)
        narrower = bool(ranges[k][0] > term.low or ranges[k][1] < term.high)
        held = bool(fit.free[k]) and narrower and not at_end
        span = ranges[k] if held else (term.low, term.high)
        for target in term.targets:
            ends = [term.write(float(end), {**base, **written})[target] for end in span]
            unit = setting.problem.simulate.parameters[target].unit
            values[target] = Value(
                written[target], min(ends), max(ends), unit, base[target], held, at_end
            )
    return values


def _beyond(problem: Problem, fitted: Fit) -> list[str]:
    """Calibrated parameters that an explanation would take beyond what was called possible."""
    count = len(fitted.calibrated)
    near = np.array(
        [
            k < count and not _clear_of_ends(value, term)
            for k, (term, value) in enumerate(zip(fitted.terms, fitted.values, strict=True))
        ],
        dtype=bool,
    )
    if not near.any():
        return []
    beyond = beyond_range(problem, fitted, near)
    return [t for k in np.flatnonzero(beyond) for t in fitted.terms[k].targets]


def _clear_of_ends(value: float, term: Term) -> bool:
    """Whether a calibrated value lies inside its range; the fit never quite reaches an end.

    In a range of decades what is twice the low end is far from it.
    """
    margin = _MARGIN * (term.high - term.low)
    low = min(margin, term.low) if term.low > 0.0 else margin
    return bool(term.low + low < value < term.high - margin)
