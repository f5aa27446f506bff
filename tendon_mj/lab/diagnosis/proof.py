"""Proof on held-out data: from the models of a selection to a verdict and a result.

Fitted models simulate the held-out data in one of three ways.

* Recordings that were held out: all of each.
* None, and recordings of different states of the rig: each by a model that is fitted to the others.
* None, and recordings of one state: the last quarter of each.

Values that were set anew for a recording are fitted to it, by every model alike. An event of one
recording is in no other one: a recording in which one was found is judged next to those that were
held out, and with the event as it was fitted to it.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendon_mj.lab.data_check import DataWarning
from tendon_mj.lab.diagnosis.data import (
    Problem,
    by_recording,
    session_terms,
    spreads,
    step_error,
    with_more_guides,
    with_step,
)
from tendon_mj.lab.diagnosis.effects.effect import Effect, Term
from tendon_mj.lab.diagnosis.fitting import Fit, fit, fit_without, near_differences
from tendon_mj.lab.diagnosis.limits import (
    LARGEST_EXCESS,
    SMALLEST_EXCESS,
    detection_limit,
    discretisation_error,
)
from tendon_mj.lab.diagnosis.model_faults import (
    LumpedSheath,
    too_few_guides,
    warn_of_guides,
    warn_of_ringing,
    warn_of_servos,
    warn_of_soft_flanks,
    warn_of_soft_friction,
)
from tendon_mj.lab.diagnosis.regimes import locate
from tendon_mj.lab.diagnosis.reproducibility import bar, reproducibility
from tendon_mj.lab.diagnosis.result import Diagnosis, Finding, Ranked, Value
from tendon_mj.lab.diagnosis.selection import Selection, SelectionContext
from tendon_mj.lab.diagnosis.statistics import (
    FittedCandidate,
    SelectedEffect,
    beyond_range,
    intervals,
    over_intervals,
)
from tendon_mj.lab.diagnosis.verdict import Evidence, Verdict, decide, measure_errors
from tendon_mj.lab.diagnosis.wording import (
    ABOVE_NOISE,
    state,
    state_finding,
    warn_of_ends,
    warn_of_step_and_noise,
)
from tendon_mj.lab.parameter_names import parameter_of, recording_of, value_in
from tendon_mj.lab.replay import Parameter
from tendon_mj.typing import FloatArray

_TOLD = 0.8  # of its range, in which an interval tells something of a number
_EXPLAINS = 0.01  # of the excess χ², to be in the ranking
# A calibrated value this near to an end is held by it: a hundredth of the range, or, in a range of
# decades, of the range about its guess.
_MARGIN = 0.2  # of a probe
_FAR = 10.0  # times as much left without an effect tells enough, converged or not
_SESSION = 8  # evaluations, of a few numbers that hardly depend on each other


@dataclass(frozen=True, eq=False)
class Unseen:
    """Held-out data as one model simulates them."""

    extrapolated: FloatArray  # (m,) residual for a step of zero
    correction: FloatArray  # (m,) extrapolated less simulated residual
    stated: FloatArray  # (m,) residual with the model's own step
    # values set anew for each recording outside the training data, <parameter> @ <recording> →
    # value
    sessions: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Data of a proof."""

    problem: Problem  # training data, with the step of the search
    own: Problem  # training data with the model's own step
    proof: Problem  # held-out recordings with the model's own step; own if there are none
    step: float | None  # of the search, see with_step
    base: Mapping[str, float]  # parameter → value of the model
    _refits: dict[Fit, list[Fit]] = field(default_factory=dict, init=False)

    @property
    def has_recordings(self) -> bool:
        """Whether recordings were held out."""
        return self.proof is not self.own

    @property
    def leaves_one_out(self) -> bool:
        """Whether each recording is held out in turn."""
        return not self.has_recordings and by_recording(self.own.recordings)

    @property
    def mask(self) -> NDArray[np.bool_]:
        """(m,) residuals of ``proof`` that are held out."""
        if self.has_recordings or self.leaves_one_out:
            return np.ones(self.proof.in_train.size, bool)
        return ~self.own.in_train

    def simulate(self, fitted: Fit) -> Unseen:
        """Simulate the held-out data with a model that was fitted to the training data."""
        if self.has_recordings:
            return self._recordings(fitted)
        if self.leaves_one_out:
            return self._each_by_the_others(fitted)
        parameters, searched = fitted.parameters(self.base), with_step(self.own, self.step)
        (stated,), (simulated,) = (p.residuals([parameters]) for p in (self.own, searched))
        extrapolated = searched.extrapolate(parameters, simulated)
        with np.errstate(invalid="ignore"):  # of a simulation that failed
            correction = extrapolated - simulated
        return Unseen(extrapolated, correction, stated, {})

    def _recordings(self, fitted: Fit) -> Unseen:
        shared, judged = _shared(fitted, self.base), with_step(self.proof, self.step)
        shared |= _events(fitted, self.base, {r.name for r in self.proof.recordings})
        terms = session_terms(self.proof.recordings, self.proof.simulate)
        alone = _fit_sessions(judged, shared, terms)
        sessions = alone.parameters(self.base)
        stated = self.proof.residuals([{**shared, **sessions}])[0]
        return Unseen(alone.residual, alone.correction, stated, sessions)

    def _each_by_the_others(self, fitted: Fit) -> Unseen:
        rows = self.problem.recording_of
        parts = np.empty((3, rows.size))
        for k, refitted in enumerate(self.refits(fitted)):
            recording = self.problem.recordings[k]
            shared = _shared(refitted, self.base) | _events(fitted, self.base, {recording.name})
            terms = [t for t in fitted.calibrated if recording_of(t.targets[0]) == recording.name]
            masks = [np.full(t.size, j == k) for j, t in enumerate(self.problem.train)]
            alone = _fit_sessions(replace(self.problem, train=tuple(masks)), shared, terms)
            stated = self.own.residuals([{**shared, **alone.parameters(self.base)}])[0]
            own = rows == k
            parts[:, own] = alone.residual[own], alone.correction[own], stated[own]
        return Unseen(parts[0], parts[1], parts[2], {})

    def refits(self, fitted: Fit) -> list[Fit]:
        """The model fitted to all recordings but each; none if all are of one state."""
        if not by_recording(self.problem.recordings):
            return []
        if fitted not in self._refits:
            self._refits[fitted] = [
                fit_without(self.problem, self.base, fitted, k)
                for k in range(len(self.problem.recordings))
            ]
        return self._refits[fitted]


def _shared(fitted: Fit, base: Mapping[str, float]) -> dict[str, float]:
    """Parameter → value that holds in all recordings."""
    return {n: value for n, value in fitted.parameters(base).items() if not recording_of(n)}


def _events(fitted: Fit, base: Mapping[str, float], names: Collection[str]) -> dict[str, float]:
    """Parameter → value of the events of a model in recordings of these names."""
    written = fitted.parameters(base)
    own = {n for e in fitted.effects for t in e.terms for n in t.write(0.0, {**base, **written})}
    return {n: v for n, v in written.items() if n in own and recording_of(n) in names}


def _fit_sessions(problem: Problem, shared: Mapping[str, float], terms: Sequence[Term]) -> Fit:
    """Fit the values of single recordings, with all others fixed; or simulate them."""
    start = np.array([term.inert for term in terms])
    return fit(replace(problem, fixed=shared), {}, terms, (), start, evaluations=_SESSION)


class Judgement(NamedTuple):
    """A selection less what its proof took out, with the verdict."""

    context: SelectionContext
    selection: Selection
    data: HeldOut
    before: Unseen  # of the calibrated model
    after: Unseen  # of the final model
    evidence: Evidence
    verdict: Verdict


@dataclass(frozen=True, eq=False, kw_only=True)
class Proof:
    """Data on which selections are proven, and everything that goes from there into a result."""

    own: Problem  # training data with the model's own step
    held_out: Problem  # held-out recordings, likewise; own if there are none
    catalogue: Mapping[str, Effect]  # identifier → effect, of all that could have been named
    excluded: Collection[str]  # identifiers of effects that were not considered
    checks: Sequence[DataWarning]  # warnings about the recordings
    began: float  # start of the diagnosis (time.perf_counter) [s]

    def judge_selection(
        self, context: SelectionContext, selection: Selection, step: float | None
    ) -> Judgement:
        """Simulate the held-out data with the models of a selection, and reach a verdict.

        The decision rests on extrapolated errors, in units of noise and reproducibility together.
        Where part of the error remains, an effect that explains less than that is taken out; and so
        is one beside others whose strength ended at an end of its range. ``step`` is that of the
        selection, see `with_step`.
        """
        data = HeldOut(context.problem, self.own, self.held_out, step, context.base)
        before = data.simulate(selection.calibrated.fit)
        while True:
            after = data.simulate(selection.final.fit) if selection.effects else before
            evidence, bars = _weigh(context, selection, data, (before, after))
            verdict = decide(evidence)
            fewer = selection
            if verdict == "unknown" and evidence.agrees:
                fewer = replace(selection, final=selection.calibrated, effects=())
            elif verdict == "partly":
                fewer = _without_imitation(context, selection, data, after, bars, evidence.limit)
            elif verdict == "unknown" and evidence.at_end:
                fewer = without_undetermined(context, selection)
            if len(fewer.effects) == len(selection.effects):
                break
            selection = fewer
        return Judgement(context, selection, data, before, after, evidence, verdict)

    def state_result(self, judged: Judgement) -> Diagnosis:
        """The result of a judgement, with intervals; errors are those of the model's own step."""
        context, selection, data, before, after, evidence, verdict = judged
        base, final = context.base, selection.final.fit
        parameters = [fit.parameters(base) for fit in (selection.calibrated.fit, final)]
        known, final_values = self.own.simulate.parameters, {**base, **parameters[1]}
        findings = tuple(
            _finding(effect, known, base, final_values) for effect in selection.effects
        )
        model = {**final_values, **after.sessions}
        if context.problem.lumped is None:  # too little to be corrected, and known to intervals
            split = with_more_guides(context.problem, parameters[1])
            context = replace(context, problem=replace(context.problem, lumped=split.lumped))
        near = near_differences(context.problem, base, final)
        over = over_intervals(context.problem, base, final, near)
        ranges = intervals(context.problem, over, data.refits(final))
        calibrated, fitted = fitted_values(context.problem, base, over, ranges)
        selection = replace(selection, final=replace(selection.final, fit=over))
        lumped = self._too_few_guides(model, evidence.held_out.after)
        limits = [*warn_of_ends(calibrated), *warn_of_guides(lumped), *warn_of_ringing(near)]
        if verdict in ("partly", "unknown"):
            limits += warn_of_soft_friction(self.own.simulate, model)
            limits += warn_of_servos(self.own)
        limits += warn_of_soft_flanks(self.own.simulate, model, {**calibrated, **fitted})
        seen, first = self.own.residuals(parameters), len(final.calibrated)
        proven = verdict in ("named", "parameter", "partly")
        excluded, faults = sorted(self.excluded), [w.sentence for w in self.checks if w.blocks]
        sentence = state(verdict, findings, evidence, excluded=excluded, faults=faults)
        return Diagnosis(
            verdict=verdict,
            sentence=" ".join([sentence, *limits]),
            findings=findings if proven else (),
            closest=() if proven else tuple(f.identifier for f in findings),
            excluded=tuple(excluded),
            ranking=ranking(selection, context.problem.in_train),
            calibrated=calibrated,
            parameters=fitted,
            sessions=spreads(final.calibrated, final.values[:first]),
            train=measure_errors(self.own, seen[0], seen[1], self.own.in_train),
            evidence=evidence,
            located=locate(self.own, seen[0], self.own.in_train),  # held-out tails stay unseen
            remaining=locate(self.own, seen[1], self.own.in_train),
            proof=(
                locate(self.held_out, before.stated, data.mask),
                locate(self.held_out, after.stated, data.mask),
            ),
            before={**base, **parameters[0], **before.sessions},
            model=model,
            seconds=time.perf_counter() - self.began,
            catalogue=self.catalogue,
            simulator=self.held_out.simulate,
            recordings=self.own.recordings,
            held_out_recordings=self.held_out.recordings if data.has_recordings else (),
            search=(context, selection),
            warnings=(
                *(f"Before any fit: {warning.sentence}." for warning in self.checks),
                *warn_of_step_and_noise(findings, evidence),
                *limits,
            ),
            checks=tuple(self.checks),
        )

    def _too_few_guides(self, model: Mapping[str, float], left: float) -> list[LumpedSheath]:
        """Sheaths of too few guides in a replay, where a fit may have allowed for more."""
        if self.held_out.lumping:  # measured: a replay lacks what more guides change
            left = float(np.sqrt(np.mean(np.square(self.held_out.by_guides))))
        return too_few_guides(self.held_out, model, left) if left > ABOVE_NOISE else []


def _weigh(
    context: SelectionContext, selection: Selection, data: HeldOut, unseen: tuple[Unseen, Unseen]
) -> tuple[Evidence, FloatArray]:
    """Evidence of a selection; and (m,) bars of the held-out residuals."""
    before, after = unseen
    judged, mask, final = data.proof, data.mask, selection.final.fit
    deviations = reproducibility(context.problem, final.residual)
    bars = bar(judged, deviations)
    step = step_error((after.correction / bars)[mask])
    lumping = discretisation_error(judged, bars, mask, before.extrapolated)
    base, effects = context.base, [selected.candidate for selected in selection.effects]
    values = {**base, **final.parameters(base)}
    evidence = Evidence(
        kinds=[candidate.kind_found(base, values) for candidate in effects],
        calibrated=selection.calibrated.excess <= context.detection_limit,
        held_out=measure_errors(judged, before.stated, after.stated, mask),
        weighed=measure_errors(judged, before.stated, after.stated, mask, bars),
        extrapolated=measure_errors(judged, before.extrapolated, after.extrapolated, mask, bars),
        zero_step=float(np.sqrt(np.mean(after.extrapolated[mask] ** 2))),
        reproducibility=deviations,
        limit=detection_limit(judged, step, bars, mask, before.extrapolated),
        largest=max(LARGEST_EXCESS, lumping),
        beyond=parameters_beyond_range(context.problem, final),
        at_end=not all(final.determines(candidate) for candidate in effects),
        non_smooth=any(candidate.effect.non_smooth for candidate in effects),
        excess=selection.calibrated.excess,
        step=step,
        lumping=lumping,
    )
    if decide(evidence) == "unknown":
        alone = selection.calibrated.fit.parameters(base)
        trained = data.own.residuals([alone])[0][data.own.in_train]
        left = max(evidence.weighed.before**2, float(np.mean(trained**2))) - 1.0
        evidence = replace(evidence, agrees=left <= SMALLEST_EXCESS)
    return evidence, bars


def _without_imitation(
    context: SelectionContext,
    selection: Selection,
    data: HeldOut,
    after: Unseen,
    bars: FloatArray,
    limit: float,
) -> Selection:
    """The selection without the effect that the held-out data can best do without, if any.

    An effect holds if it explains more of the held-out data than is left unexplained: an effect
    that explains less may stand for a part of that. And it explains more than the limit.
    """
    if len(selection.effects) < 2:
        return selection
    left = float(np.mean((after.extrapolated / bars)[data.mask] ** 2))
    least, imitation = max(limit, left), selection
    for selected in selection.effects:
        reduced = context.without(selection.final, selected.candidate)
        if reduced.excess < _FAR * (1.0 + selection.final.excess):
            reduced = context.polish(reduced)
        unseen = data.simulate(reduced.fit)
        explained = float(np.mean((unseen.extrapolated / bars)[data.mask] ** 2)) - left
        if explained < least:
            others = tuple(s for s in selection.effects if s is not selected)
            least, imitation = explained, replace(selection, final=reduced, effects=others)
    return imitation


def without_undetermined(context: SelectionContext, selection: Selection) -> Selection:
    """The selection without one effect, not its only one, whose strength is not determined."""
    final = selection.final
    for selected in selection.effects:
        if len(selection.effects) > 1 and not final.fit.determines(selected.candidate):
            reduced = context.polish(context.without(final, selected.candidate))
            others = tuple(s for s in selection.effects if s is not selected)
            return replace(selection, final=reduced, effects=others)
    return selection


def _finding(
    selected: SelectedEffect,
    parameters: Mapping[str, Parameter],
    before: Mapping[str, float],
    after: Mapping[str, float],
) -> Finding:
    candidate, rivals = selected.candidate, selected.rivals  # these may be the same one elsewhere
    effect = candidate.effect
    others = dict.fromkeys(r.identifier for r in rivals if r.identifier != effect.identifier)
    return Finding(
        identifier=effect.identifier,
        name=effect.name,
        equation=effect.equation,
        where=candidate.where,
        kind="parameter" if candidate.in_model(before) else effect.kind,
        confidence=selected.confidence,
        rivals=tuple(others),
        elsewhere=tuple(r.where for r in rivals if r.identifier == effect.identifier),
        statement=state_finding(candidate, parameters, before, after),
        parameter=candidate.terms[0].targets[0],
        recording=candidate.recording,
    )


def ranking(selection: Selection, in_train: NDArray[np.bool_]) -> tuple[Ranked, ...]:
    """Rank the candidates for the first effect: fitted ones by their error, others by screening."""
    first = selection.first
    if first is None:
        return ()
    excess = float(np.mean(selection.calibrated.fit.residual[in_train] ** 2)) - 1.0
    fitted = {model.added.label: model for model in (*first.fitted, *first.at_end)}
    ranked: dict[str, Ranked] = {}
    for score in first.scores:
        candidate, share = score.candidate, min(score.explained / excess, 1.0)
        if share >= _EXPLAINS and candidate.label not in ranked:
            left, end, unit = None, None, ""
            if model := fitted.get(candidate.label):
                left = float(np.sqrt(max(1.0 + model.excess, 0.0)))
                if model in first.at_end:
                    end, unit = _nearest_end(model)
            ranked[candidate.label] = Ranked(
                candidate.identifier, candidate.where, share, left, end, unit
            )
    return tuple(
        sorted(
            ranked.values(),
            key=lambda r: (r.left is None, r.at_end is not None, r.left or 0.0, -r.explains),
        )
    )


def _nearest_end(model: FittedCandidate) -> tuple[float, str]:
    """End of its range at which a candidate's strength stands, and its unit."""
    strength = model.fit.terms_of(model.added).start
    term, value = model.fit.terms[strength], float(model.fit.values[strength])
    nearest = term.high if abs(term.high - value) < abs(term.low - value) else term.low
    return nearest, term.unit


def fitted_values(
    problem: Problem, base: Mapping[str, float], fit: Fit, ranges: FloatArray
) -> tuple[dict[str, Value], dict[str, Value]]:
    """Fitted parameters with (p, 2) intervals: the calibrated ones, and those of the effects."""
    parameters = problem.simulate.parameters
    widths = np.array([term.high - term.low for term in fit.terms])
    inside = fit.free & (np.ptp(ranges, axis=1) < widths)
    at_ends = [np.where(inside, end, fit.values) for end in ranges.T]
    around = [{**base, **fit.parameters(base, values)} for values in (fit.values, *at_ends)]
    calibrated, of_effects, near = dict[str, Value](), dict[str, Value](), _near_ends(fit)
    for k, term in enumerate(fit.terms):
        if term.spread > 0.0:
            continue
        values = calibrated if k < len(fit.calibrated) else of_effects
        at_end = bool(near[k])
        determined = bool(fit.free[k] and not at_end and is_narrower(ranges[k], term))
        span = ranges[k] if determined else (term.low, term.high)
        written = [term.write(float(end), others) for end in span for others in around]
        for name in term.targets:
            ends = [values_at[name] for values_at in written]
            unit, before = parameters[parameter_of(name)].unit, value_in(base, name)
            values[name] = Value(
                around[0][name], min(ends), max(ends), unit, before, determined, at_end
            )
        for name, value, low, high in term.constants:
            unit, before = parameters[parameter_of(name)].unit, value_in(base, name)
            values[name] = Value(value, low, high, unit, before)
    return calibrated, of_effects


def is_narrower(interval: FloatArray, term: Term) -> bool:
    """Return whether an interval excludes a fifth of the range of a term: others' may tell less."""
    return bool(interval[1] - interval[0] < _TOLD * (term.high - term.low))


def parameters_beyond_range(problem: Problem, fit: Fit) -> list[str]:
    """Calibrated parameters that the effects of a fit would take beyond their ranges."""
    near = _near_ends(fit)
    if not near.any():
        return []
    beyond = beyond_range(problem, fit, near)
    return [t for k in np.flatnonzero(beyond) for t in fit.terms[k].targets]


def _near_ends(fit: Fit) -> NDArray[np.bool_]:
    """(p,) which terms are calibrated, the same in all recordings, and at an end of their range."""
    near = np.zeros(len(fit.terms), bool)
    for k, term in enumerate(fit.calibrated):
        near[k] = not term.spread and not _clear_of_ends(fit.values[k], term)
    return near


def _clear_of_ends(value: float, term: Term) -> bool:
    """Return whether a calibrated value lies inside its range; the fit never quite reaches an end.

    In a range of decades twice the low end is far from it.
    """
    margin = _MARGIN * term.probe
    low = min(margin, term.low) if term.low > 0.0 else margin
    return bool(term.low + low < value < term.high - margin)
