"""The workflow: check, calibrate, screen and select, prove.

Verdicts:

* "nothing missing": calibrated, the model leaves no more than noise and numerical error.
* "parameter": correcting a parameter that nobody called uncertain removes the error.
* "named": effects that the model lacks remove the error, on held-out data too.
* "partly": they remove much of it there, and nothing in the catalogue explains what remains.
* "unknown": an error remains that nothing in the catalogue explains.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from tendon_mj.errors import UnknownNameError
from tendon_mj.lab.data_check import DataWarning, check_recording
from tendon_mj.lab.diagnosis.check import check_recordings, check_simulation, make_simulator
from tendon_mj.lab.diagnosis.data.problem import (
    MakeSimulator,
    Problem,
    all_samples,
    training_samples,
)
from tendon_mj.lab.diagnosis.data.sessions import session_terms
from tendon_mj.lab.diagnosis.data.step_size import search_step, step_error, with_step
from tendon_mj.lab.diagnosis.data.uncertain import uncertain_terms
from tendon_mj.lab.diagnosis.effects.catalogue import (
    CATALOGUE,
    Effects,
    by_identifier,
    candidates,
    check_bindings,
)
from tendon_mj.lab.diagnosis.effects.effect import SystemDescription
from tendon_mj.lab.diagnosis.model_selection.comparison import FittedCandidate
from tendon_mj.lab.diagnosis.model_selection.context import CONVERGED, SelectionContext
from tendon_mj.lab.diagnosis.model_selection.select import Selection, select_effects
from tendon_mj.lab.diagnosis.model_selection.thresholds import SMALLEST_EXCESS, reducible_excess
from tendon_mj.lab.diagnosis.proof import prove
from tendon_mj.lab.diagnosis.result.diagnosis import Diagnosis, Verdict
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import (
    DRAWN_BEND,
    EXTRA_BEND,
    Kind,
    Parameter,
    Simulates,
    Simulator,
    expand,
    matching,
)

_NONE = Parameter(0.0, "", "joint")
_EXPLAINED = ("named", "parameter", "nothing missing")
_AT_NOISE = 1.2  # noises that an effect leaves at most, for it to be more than a fault of a column
_SHORTEST = 0.5  # times the model's own step
_RINGING = 0.1  # of the mean square residual, by which halving the step changes it
_NEARLY = 2.0  # times the detection limit or the step's error: the rest may be the step's


def diagnose(
    train: Sequence[Recording],
    held_out: Sequence[Recording] = (),
    simulator: MakeSimulator = Simulator,
    *,
    catalogue: Effects = CATALOGUE,
    exclude: Collection[str] = (),
    checks: Sequence[DataWarning] | None = None,
    progress: Progress = silent,
) -> Diagnosis:
    """Find what a model lacks against recordings, or which of its parameters is wrong.

    Args:
        train: recordings of one model, for selection and fits.
        held_out: recordings for the proof alone; without any, each of ``train`` is held out in turn
            where there are three or more of different states or sessions of the rig, else the last
            quarter of each.
        simulator: makes the simulator of recordings; see `tendon_mj.Simulates`.
        catalogue: effects that can be named, in place of the package's own or beside them:
            ``[*CATALOGUE.values(), mine]``.
        exclude: identifiers of effects that are not to be considered.
        checks: warnings of `check_recording` about all recordings; by default it is called here, if
            the simulator is the package's. Where a fit cannot see through one of them, only what is
            uncertain is fitted, and no effect is named.
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
    check_recordings(train, held_out)
    simulate = make_simulator(simulator, train)
    own = Problem(tuple(train), simulate, training_samples(train, held_out))
    system = describe_system(own)
    base = system.values
    for name in train[0].uncertain:
        for target in matching(name, base):
            if target not in base:
                raise UnknownNameError("parameter", target, base)
    check_bindings(system, exclude, effects)
    at_rest = all(recording.quasi_static for recording in train)
    bound = tuple(c for c in candidates(system, exclude, effects) if not (at_rest and c.in_motion))
    check_simulation(own)
    if checks is None:
        checks = _check((*train, *held_out), simulate)
    terms = (*uncertain_terms(own), *session_terms(train, own.simulate))
    context = SelectionContext(own, base, terms, (), 0.0, 0.0, progress)
    context, calibrated, step = _calibrate(context, search_step(own))
    problem = context.problem
    context = replace(
        context,
        candidates=bound,
        step_error=step_error(calibrated.fit.correction[problem.in_train]),
        initial_excess=reducible_excess(problem, calibrated.fit.residual),
    )

    def decided(context: SelectionContext, step: float | None) -> Diagnosis:
        selection = select_effects(context, calibrated)
        proof = own
        if held_out:
            judged = (*held_out, *_with_events(train, held_out, selection))
            proof = Problem(judged, simulator(judged), all_samples(judged))
        result = prove(context, selection, own, proof, step, effects, exclude, checks, began)
        while step and step > _SHORTEST and _step_matters(context, selection, result.verdict):
            step *= 0.5
            progress("repeat with a shorter step", 0, 1)
            context, selection = _fit_again(context, selection, with_step(own, step))
            result = prove(context, selection, own, proof, step, effects, exclude, checks, began)
            progress("repeat with a shorter step", 1, 1)
        return result

    result = decided(context, step)
    blocked = any(warning.blocks for warning in checks)
    if not blocked or (result.verdict in _EXPLAINED and result.train.after < _AT_NOISE):
        return result  # an effect that leaves no more than noise where the fault is said to be
    return decided(replace(context, candidates=()), step)


def _check(recordings: Sequence[Recording], simulate: Simulates) -> list[DataWarning]:
    """Warnings about recordings, which a search would take for properties of the rig."""
    if not isinstance(simulate, Simulator):
        return []
    model = simulate.model
    return [w for r in recordings for w in check_recording(r, model, described=True).warnings]


def _with_events(
    train: Sequence[Recording], held_out: Sequence[Recording], selection: Selection
) -> list[Recording]:
    """Training recordings in which an event was found, which no held-out one can show."""
    names = {s.candidate.recording for s in selection.effects} - {r.name for r in held_out}
    return [recording for recording in train if recording.name in names]


def _calibrate(
    context: SelectionContext, step: float | None
) -> tuple[SelectionContext, FittedCandidate, float | None]:
    """Fit what is uncertain, in shorter steps where the model rings in longer ones."""
    own, start = context.problem, [term.inert for term in context.calibrated]
    while True:
        context.progress("calibrate", 0, 1)
        context = replace(context, problem=with_step(own, step))
        calibrated = context.fit_model((), start, evaluations=CONVERGED)
        context.progress("calibrate", 1, 1)
        if step is None or step <= _SHORTEST or not _rings(context.problem, calibrated):
            return context, calibrated, step
        step *= 0.5


def _rings(problem: Problem, model: FittedCandidate) -> bool:
    """Whether halving the step changes a model by much of what it leaves."""
    used = problem.in_train
    left = float(np.mean(model.fit.residual[used] ** 2))
    return not step_error(model.fit.correction[used]) <= max(1.0, _RINGING * left)


def _step_matters(context: SelectionContext, selection: Selection, verdict: Verdict) -> bool:
    """Whether a shorter step may change the verdict on the selected effects, or their values."""
    if not selection.effects:
        return False
    error = step_error(selection.final.fit.correction[context.problem.in_train])
    if verdict in ("unknown", "partly"):
        return selection.final.excess < _NEARLY * max(context.detection_limit, error)
    return error > SMALLEST_EXCESS


def _fit_again(
    context: SelectionContext, selection: Selection, problem: Problem
) -> tuple[SelectionContext, Selection]:
    """Fit the selected models to the same data with another step."""
    context = replace(context, problem=problem)
    calibrated = context.polish(selection.calibrated)
    initial = reducible_excess(problem, calibrated.fit.residual)
    context = replace(context, initial_excess=initial)
    final = context.optimise_nearby(selection.final)
    return context, replace(selection, calibrated=calibrated, final=final)


def describe_system(problem: Problem) -> SystemDescription:
    """Describe the model and the recordings to the catalogue."""
    spans: dict[str, float] = {}
    for recording in problem.recordings:
        for column, measured in recording.measured.items():
            span = float(np.ptp(recording.columns[column]))
            spans[measured.sensor] = max(spans.get(measured.sensor, 0.0), span) or 1.0
    first, parameters = problem.recordings[0], problem.simulate.parameters
    fitted = [
        n for r in problem.recordings for n in expand({**r.uncertain, **r.session}, parameters)
    ]
    joints, motors = (sorted(_elements(parameters, kind)) for kind in ("joint", "motor"))
    driven = [j for j, is_driven in problem.simulate.joints.items() if is_driven]
    inputs = tuple(name for _, name in first.driven)
    return SystemDescription(
        values={name: parameter.value for name, parameter in parameters.items()},
        known=_known(problem),
        uncertain=frozenset({*fitted, *_drawn_bends(fitted)}),
        spans=spans,
        inputs=inputs,
        free_joints=tuple(joint for joint in joints if joint not in driven),
        motors=tuple(name for name in inputs if name in motors),
        slides=frozenset(j for j in joints if parameters.get(f"{j}.armature", _NONE).unit == "kg"),
        joints={name: p.joints for name, p in parameters.items() if p.joints},
        reference={name: p.reference for name, p in parameters.items() if p.reference},
        columns=tuple(names for names in first.drive.values() if not isinstance(names, str)),
    )


def _known(problem: Problem) -> frozenset[str]:
    """Parameters that a recording calls known.

    Who knows an `extra_bend`, the same in all recordings, knows the bend: the drawn one too.
    """
    told = [expand(r.known, problem.simulate.parameters) for r in problem.recordings]
    alike = [name for name, value in told[0].items() if all(t.get(name) == value for t in told)]
    return frozenset({*_drawn_bends(alike)}.union(*told))


def _drawn_bends(names: Iterable[str]) -> list[str]:
    """The drawn bends of sheaths whose extra bend is among the names."""
    parts = [name.rpartition(".") for name in names]
    return [f"{sheath}.{DRAWN_BEND}" for sheath, _, parameter in parts if parameter == EXTRA_BEND]


def _elements(parameters: Mapping[str, Parameter], kind: Kind) -> set[str]:
    """Elements of a kind that have parameters."""
    return {name.rsplit(".", 1)[0] for name, p in parameters.items() if p.kind == kind}
