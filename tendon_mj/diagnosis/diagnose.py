"""The workflow: calibrate, locate, name, abstain, prove.

Verdicts:

* "nothing missing": calibrated, the model leaves no more than noise and numerics.
* "parameter": what is left goes away when a number that nobody called uncertain is corrected.
* "named": effects that the model lacks make it go away, on data that chose nothing too.
* "unknown": structure remains that nothing in the catalogue explains.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from tendon_mj.diagnosis.admit import admit, admit_simulation
from tendon_mj.diagnosis.conclude import conclude
from tendon_mj.diagnosis.contest import POLISH, SMALLEST_GAP, Setting
from tendon_mj.diagnosis.effects.catalogue import CATALOGUE, Effects, by_identifier, candidates
from tendon_mj.diagnosis.effects.effect import SystemDescription, Term
from tendon_mj.diagnosis.name import Naming, name_effects
from tendon_mj.diagnosis.numerics import in_steps, searching_steps, step_error
from tendon_mj.diagnosis.problem import Make, Problem, for_choices, whole
from tendon_mj.diagnosis.verdict import Diagnosis, Verdict
from tendon_mj.errors import UnknownNameError
from tendon_mj.progress import Progress, silent
from tendon_mj.recordings.recording import Recording
from tendon_mj.replay.simulator import Simulator

_SHORTEST = 0.5  # times the model's own step
_NEARLY = 2.0  # times what is not worth a name, or what halving steps does: it may be the steps'


def diagnose(
    train: Sequence[Recording],
    held_out: Sequence[Recording] = (),
    simulator: Make = Simulator,
    *,
    catalogue: Effects = CATALOGUE,
    exclude: Collection[str] = (),
    progress: Progress = silent,
) -> Diagnosis:
    """Find what a model lacks against recordings, or which of its numbers is wrong.

    Args:
        train: recordings of one model, for all choices and fits.
        held_out: recordings for the proof alone; without any, the last quarter of each of
            ``train`` is kept for it.
        simulator: makes what simulates recordings; see `tendon_mj.replay.simulates`.
        catalogue: effects that can be named, in place of the package's own or beside them:
            ``[*CATALOGUE.values(), mine]``.
        exclude: identifiers of effects that are not to be considered.
        progress: called with a label, how much is done, and of how much.

    Raises:
        RecordingError: no recording, recordings of different models or of other known or uncertain
            numbers, nothing measured, nothing that moves back and forth, the same data twice or
            for choice and proof, or data under which the model as described becomes unstable.
        UnknownNameError: ``exclude`` names no effect of the catalogue, or a recording calls a
            parameter uncertain that the simulator does not know.
        InvalidValueError: two effects of the catalogue have the same identifier.
    """
    began = time.perf_counter()
    exclude = {exclude} if isinstance(exclude, str) else exclude
    effects = by_identifier(catalogue)
    admit(train, held_out)
    own = Problem(tuple(train), simulator(train), for_choices(train, held_out))
    base = {name: p.value for name, p in own.simulate.parameters.items()}
    for name in train[0].uncertain:
        if name not in base:
            raise UnknownNameError("parameter", name, base)
    admit_simulation(own)
    steps = searching_steps(own)
    problem = in_steps(own, steps)
    bound = tuple(candidates(look_at(problem), exclude, effects))
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
    progress("calibrate", 0, 1)
    setting = Setting(problem, base, calibrated, (), 0.0, progress)
    start = setting.enter((), [term.inert for term in calibrated], trials=POLISH)
    progress("calibrate", 1, 1)
    floor = step_error(start.fit.refined[problem.chosen])
    setting = replace(setting, candidates=bound, floor=floor)
    naming = name_effects(setting, start)
    proof = Problem(tuple(held_out), simulator(held_out), whole(held_out)) if held_out else own
    found = conclude(setting, naming, own, proof, steps, effects, exclude, began)
    while steps and steps > _SHORTEST and _steps_matter(setting, naming, found.verdict):
        steps *= 0.5
        progress("once more in shorter steps", 0, 1)
        setting = replace(setting, problem=in_steps(own, steps))
        before = setting.polish(naming.calibrated)
        after = setting.settle_again(naming.final, before.gap)
        naming = replace(naming, calibrated=before, final=after)
        found = conclude(setting, naming, own, proof, steps, effects, exclude, began)
        progress("once more in shorter steps", 1, 1)
    return found


def _steps_matter(setting: Setting, naming: Naming, verdict: Verdict) -> bool:
    """Whether shorter steps may change the verdict on what was named, or its numbers."""
    if not naming.named:
        return False
    error = step_error(naming.final.fit.refined[setting.problem.chosen])
    if verdict == "unknown":
        return naming.final.gap < _NEARLY * max(setting.least, error)
    return error > SMALLEST_GAP


def look_at(problem: Problem) -> SystemDescription:
    """What the catalogue may know of the model and the recordings."""
    spans: dict[str, float] = {}
    for recording in problem.recordings:
        for column, measured in recording.measured.items():
            span = float(np.ptp(recording.columns[column]))
            spans[measured.sensor] = max(spans.get(measured.sensor, 0.0), span) or 1.0
    first, parameters = problem.recordings[0], problem.simulate.parameters
    joints = sorted({n.rsplit(".", 1)[0] for n, p in parameters.items() if p.kind == "joint"})
    driven = [j for j, is_driven in problem.simulate.joints.items() if is_driven]
    return SystemDescription(
        values={name: parameter.value for name, parameter in parameters.items()},
        known=frozenset(first.known),
        uncertain=frozenset(first.uncertain),
        spans=spans,
        inputs=tuple(first.drive.values()),
        free_joints=tuple(joint for joint in joints if joint not in driven),
    )
