"""The workflow: check, calibrate, screen and select, prove.

Verdicts:

* "nothing missing": calibrated, the model leaves no more than noise and numerical error.
* "parameter": correcting a parameter that no recording calls uncertain removes the error.
* "named": effects that the model lacks remove the error, on held-out data too.
* "partly": they remove much of it there, and nothing was found that explains what remains.
* "undetermined": with other numbers, alone or with one more effect, the model explains as much.
* "unknown": an error remains, and nothing was found that explains it.
"""

from __future__ import annotations

import os
import time
from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from tendon_mj.errors import UnknownNameError
from tendon_mj.lab.data_check import DataWarning, check_recording
from tendon_mj.lab.diagnosis.alternatives import with_alternatives
from tendon_mj.lab.diagnosis.check import check_recordings, check_simulation, make_simulator
from tendon_mj.lab.diagnosis.data import (
    MakeSimulator,
    Problem,
    all_samples,
    describe_system,
    make_problem,
    search_step,
    session_terms,
    step_error,
    training_samples,
    uncertain_terms,
    with_more_guides,
    with_step,
)
from tendon_mj.lab.diagnosis.effects import (
    CATALOGUE,
    Effects,
    by_identifier,
    candidates,
    check_bindings,
)
from tendon_mj.lab.diagnosis.fitting import UNCHANGED, Fit, near_differences, rings
from tendon_mj.lab.diagnosis.limits import SMALLEST_EXCESS, reducible_excess
from tendon_mj.lab.diagnosis.proof import Proof
from tendon_mj.lab.diagnosis.result import Diagnosis
from tendon_mj.lab.diagnosis.selection import CONVERGED, Selection, SelectionContext, select_effects
from tendon_mj.lab.diagnosis.statistics import FittedCandidate
from tendon_mj.lab.diagnosis.verdict import Verdict
from tendon_mj.lab.parameter_names import matching
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.recordings import GivenRecording, Recording, read_given
from tendon_mj.lab.replay import Simulator
from tendon_mj.typing import FloatArray

_EXPLAINED = ("named", "parameter", "nothing missing")
_AT_NOISE = 1.2  # noises that an effect leaves at most, for it to be more than a fault of a column
_ROUNDS = 3  # in which the change by more guides and the fit follow each other
_SHORTEST = 0.5  # times the model's own step
_RINGING = 0.1  # of the mean square residual, by which halving the step changes it
_NEARLY = 2.0  # times the detection limit or the step's error: the rest may be the step's


def diagnose(
    train: GivenRecording | Sequence[GivenRecording],
    held_out: GivenRecording | Sequence[GivenRecording] = (),
    simulator: MakeSimulator = Simulator,
    *,
    description: str | os.PathLike[str] | None = None,
    catalogue: Effects = CATALOGUE,
    exclude: Collection[str] = (),
    checks: Sequence[DataWarning] | None = None,
    progress: Progress = silent,
) -> Diagnosis:
    """Find the effects that a model lacks against recordings, or its wrong parameters.

    Args:
        train: one or several recordings of one model, or paths of their tables or TOML files, for
            selection and fits.
        held_out: recordings for the proof alone; without any, each of ``train`` is held out in turn
            if there are three or more of different states or sessions of the rig, else the last
            quarter of each.
        simulator: makes the simulator of recordings; see `tendon_mj.Simulates`.
        description: path of the TOML file of all that are paths, where theirs do not lie beside
            the tables.
        catalogue: effects that can be named, instead of the package's or with them:
            ``[*CATALOGUE.values(), mine]``.
        exclude: identifiers of effects that are not to be considered.
        checks: warnings of `check_recording` about all recordings; by default it is called here, if
            the simulator is the package's. If a fit cannot see through one of them, only the
            uncertain parameters are fitted, and no effect is named.
        progress: called with a label, how much is done, and of how much.

    Raises:
        RecordingError: no recording, recordings of different models or of other uncertain
            parameters, nothing measured, nothing that moves back and forth, the same data twice or
            both in training and held out, or data under which the model becomes unstable.
        UnknownNameError: ``exclude`` names no effect of the catalogue, or a recording calls a
            parameter uncertain that the simulator does not know.
        InvalidValueError: a catalogue without effects or with two of one identifier, none of which
            binds on the model, or a simulator that lacks a member.
    """
    began = time.perf_counter()
    exclude = {exclude} if isinstance(exclude, str) else exclude
    effects = by_identifier(catalogue)
    train, held_out = _read(train, description), _read(held_out, description)
    check_recordings(train, held_out)
    simulate = make_simulator(simulator, train)
    own = make_problem(train, simulate, training_samples(train, held_out))
    system = describe_system(own)
    for name in train[0].uncertain:
        for target in matching(name, system.values):
            if target not in system.values:
                raise UnknownNameError("parameter", target, system.values)
    check_bindings(system, exclude, effects)
    at_rest = all(recording.quasi_static for recording in train)
    bound = tuple(
        c for c in candidates(system, exclude, effects) if not (at_rest and c.effect.in_motion)
    )
    check_simulation(own)
    if checks is None:
        model = simulate.model if isinstance(simulate, Simulator) else None
        made = (check_recording(r, model, described=True) for r in (*train, *held_out) if model)
        checks = [warning for checked in made for warning in checked.warnings]
    terms = (*uncertain_terms(own), *session_terms(train, simulate))
    context = SelectionContext(own.without_tails(), system.values, terms, (), 0.0, 0.0, progress)
    context, calibrated, step = _calibrate(context, search_step(own), [t.inert for t in terms])
    context = replace(_at(context, calibrated), candidates=bound)

    def select_and_judge(context: SelectionContext) -> Diagnosis:
        selection = select_effects(context, calibrated)
        data = own
        if selection.final.excess > SMALLEST_EXCESS:  # of which lumping may be a part
            data, context, selection = _select_with_more_guides(own, context, selection, step)
        judged = data
        if held_out:  # and training recordings with an event, which no held-out one can show
            names = {s.candidate.recording for s in selection.effects} - {r.name for r in held_out}
            recordings = (*held_out, *(recording for recording in train if recording.name in names))
            judged = make_problem(recordings, simulator(recordings), all_samples(recordings))
            if data.lumping:
                model = selection.final.fit.parameters(context.base)
                judged = with_more_guides(judged, model)
        proof = Proof(
            own=data,
            held_out=judged,
            catalogue=effects,
            excluded=exclude,
            checks=checks,
            began=began,
        )
        return _judge_with_short_steps(context, selection, proof, step)

    result = select_and_judge(context)
    blocked = any(warning.blocks for warning in checks)
    if not blocked or (result.verdict in _EXPLAINED and result.train.after < _AT_NOISE):
        # an effect that leaves no more than noise where the recordings have a fault
        return replace(with_alternatives(result), seconds=time.perf_counter() - began)
    return select_and_judge(replace(context, candidates=()))


def _read(
    given: GivenRecording | Sequence[GivenRecording], description: str | os.PathLike[str] | None
) -> list[Recording]:
    several = [given] if isinstance(given, GivenRecording) else given
    return [read_given(recording, description) for recording in several]


def _select_with_more_guides(
    own: Problem, context: SelectionContext, selection: Selection, step: float | None
) -> tuple[Problem, SelectionContext, Selection]:
    """The data with what more guides change, and the selection on them.

    Anew where lumping had ended it.
    """
    little, data = _NEARLY * context.detection_limit, own
    for _ in range(_ROUNDS):
        before, data = data, with_more_guides(own, selection.final.fit.parameters(context.base))
        change = np.broadcast_to(data.by_guides - before.by_guides, own.in_train.shape)
        if not data.lumping or (before.lumping and np.mean(change[own.in_train] ** 2) <= UNCHANGED):
            break
        problem = with_step(data.without_tails(), step)
        context, selection = _fit_again(context, selection, problem, change)
        if context.smallest_gain < selection.final.excess < little and context.candidates:
            selection = select_effects(context, selection.calibrated)
    return data, context, selection


def _at(context: SelectionContext, calibrated: FittedCandidate) -> SelectionContext:
    """The context of a selection that begins from a calibrated model."""
    problem, fit = context.problem, calibrated.fit
    return replace(
        context,
        step_error=step_error(fit.correction[problem.in_train]),
        initial_excess=reducible_excess(problem, fit.residual),
        residual=fit.residual,
        slopes=[],
        reduced={},
    )


def _judge_with_short_steps(
    context: SelectionContext, selection: Selection, proof: Proof, step: float | None
) -> Diagnosis:
    """Judge a selection, again in shorter steps while these may change the verdict."""
    judged = proof.judge_selection(context, selection, step)
    while step and step > _SHORTEST and _step_matters(context, selection, judged.verdict):
        step *= 0.5
        context.progress("repeat with a shorter step", 0, 1)
        problem = with_step(proof.own.without_tails(), step)
        context, selection = _fit_again(context, selection, problem)
        judged = proof.judge_selection(context, selection, step)
        context.progress("repeat with a shorter step", 1, 1)
    return proof.state_result(judged)


def _calibrate(
    context: SelectionContext, step: float | None, start: Sequence[float] | FloatArray
) -> tuple[SelectionContext, FittedCandidate, float | None]:
    """Fit the uncertain parameters, in shorter steps where the model rings in longer ones."""
    own = context.problem
    while True:
        context.progress("calibrate", 0, 1)
        context = replace(context, problem=with_step(own, step))
        calibrated = context.fit_model((), start, evaluations=CONVERGED)
        context.progress("calibrate", 1, 1)
        if not (step and step > _SHORTEST and _is_too_long(step, context, calibrated.fit, own)):
            return context, calibrated, step
        step *= 0.5


def _is_too_long(step: float, context: SelectionContext, fit: Fit, own: Problem) -> bool:
    """Return whether half of the step changes a residual by much of its mean square.

    Or whether the simulation rings in it, with derivatives of no use, and less in half of it.
    """
    used = own.in_train
    left = float(np.mean(fit.residual[used] ** 2))
    if not step_error(fit.correction[used]) <= max(1.0, _RINGING * left):
        return True
    near = near_differences(context.problem, context.base, fit)
    if not rings(near):
        return False
    return near_differences(with_step(own, 0.5 * step), context.base, fit)[1] < 0.5 * near[1]


def _step_matters(context: SelectionContext, selection: Selection, verdict: Verdict) -> bool:
    """Return whether a shorter step may change the verdict on the effects, or their values."""
    if not selection.effects:
        return False
    error = step_error(selection.final.fit.correction[context.problem.in_train])
    if verdict in ("unknown", "partly"):
        return selection.final.excess < _NEARLY * max(context.detection_limit, error)
    return error > SMALLEST_EXCESS


def _fit_again(
    context: SelectionContext,
    selection: Selection,
    problem: Problem,
    change: FloatArray | None = None,
) -> tuple[SelectionContext, Selection]:
    """Fit the selected models to the same data with another step, or with a ``change``."""
    context = replace(context, problem=problem)
    calibrated = context.polish(selection.calibrated, change)
    initial = reducible_excess(problem, calibrated.fit.residual)
    context = replace(context, initial_excess=initial, residual=calibrated.fit.residual)
    final = calibrated
    if selection.effects:
        final = context.polish(selection.final, change)
    return context, replace(selection, calibrated=calibrated, final=final)
