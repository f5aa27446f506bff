"""Diagnosis of a case, before and after one more recording."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from typing import Any

import numpy as np

from experiments.next_experiment.case import Case, HiddenRig, make
from experiments.next_experiment.rig import Description, run
from tendon_mj.errors import TendonError
from tendon_mj.lab.diagnosis import Diagnosis, diagnose
from tendon_mj.lab.experiment import Experiment, ExperimentBounds, Family
from tendon_mj.lab.experiment_design import suggest_experiment
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Simulator

RANDOM_EXPERIMENTS = 2  # of each tie
_DRAWS = 50  # until one keeps the readings within limits

simulator = partial(Simulator, threads=1)


def draw_experiment(
    recordings: Sequence[Recording], bounds: ExperimentBounds, seed: int
) -> Experiment:
    """Draw an experiment within bounds at random, with which a suggested one can be compared."""
    family = Family(tuple(recordings), bounds)
    return family.at(np.random.default_rng(seed).random(family.dimensions), "drawn")


@dataclass(frozen=True, kw_only=True)
class After:
    """A diagnosis with one more recording.

    Attributes:
        experiment: in words; empty if none could be run.
        verdict, effects, ties: of the diagnosis.
        settled: whether it names the hidden effect first, and nothing ties with it.
    """

    experiment: str
    verdict: str
    effects: list[str]
    ties: list[list[str]]
    settled: bool


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """Result of a case.

    Attributes:
        case: it. ratio: of the residual that was hidden to the noise [-].
        verdict, effects, ties: of the first diagnosis.
        tie: whether it ties, the hidden effect being one of the tied.
        sentence: of the suggestion. differences: see `tendon_mj.lab.experiment_design.Difference`.
        seconds: that the search took.
        suggested: with the suggested experiment; None if none was suggested.
        random: with random ones of the same length from the same bounds.
    """

    case: Case
    ratio: float
    verdict: str
    effects: list[str]
    ties: list[list[str]]
    tie: bool
    sentence: str = ""
    differences: list[dict[str, Any]] = field(default_factory=list)
    seconds: float = 0.0
    suggested: After | None = None
    random: list[After] = field(default_factory=list)

    def result(self) -> dict[str, Any]:
        """Plain numbers and words."""
        return asdict(self)


def settle(case: Case) -> Outcome:
    """Diagnose a case; where it ties, run the suggested experiment and random ones."""
    rig = make(case)
    diagnosis = diagnose([rig.train], [rig.held_out], simulator)
    tie = any(case.hidden in group for group in diagnosis.indistinguishable)
    first = Outcome(
        case=case,
        ratio=rig.ratio,
        verdict=diagnosis.verdict,
        effects=diagnosis.effects,
        ties=diagnosis.indistinguishable,
        tie=tie,
    )
    return _follow_up(first, rig, diagnosis) if tie else first


def _follow_up(first: Outcome, rig: HiddenRig, diagnosis: Diagnosis) -> Outcome:
    described = Description(
        sensors=tuple(rig.train.measured), known=rig.train.known, uncertain=rig.train.uncertain
    )
    begun = time.perf_counter()
    suggestion = suggest_experiment(diagnosis, described.bounds, simulator)
    seconds = time.perf_counter() - begun
    random = first.case.random
    suggested = None
    if suggestion.experiment is not None:
        suggested = _after(first.case.hidden, rig, [suggestion.experiment], random)
    drawn = [
        [
            draw_experiment([rig.train], described.bounds, seed)
            for seed in random.integers(2**32, size=_DRAWS).tolist()
        ]
        for _ in range(RANDOM_EXPERIMENTS)
    ]
    return Outcome(
        **{
            **vars(first),
            "sentence": suggestion.sentence,
            "differences": [vars(d) for d in suggestion.differences],
            "seconds": seconds,
            "suggested": suggested,
            "random": [_after(first.case.hidden, rig, draws, random) for draws in drawn],
        }
    )


def _after(
    hidden: str,
    rig: HiddenRig,
    experiments: Sequence[Experiment],
    random: np.random.Generator,
) -> After:
    """Diagnose again with the first of the experiments that the rig can run."""
    for experiment in experiments:
        recorded = run(rig.truth, experiment.recording, random)
        if recorded is not None:
            return _diagnosed(hidden, rig, experiment, recorded)
    return After(experiment="", verdict="not run", effects=[], ties=[], settled=False)


def _diagnosed(hidden: str, rig: HiddenRig, experiment: Experiment, recorded: Recording) -> After:
    try:
        diagnosis = diagnose([rig.train, recorded], [rig.held_out], simulator)
    except TendonError as error:
        return After(
            experiment=experiment.words,
            verdict=f"failed: {error}",
            effects=[],
            ties=[],
            settled=False,
        )
    first = diagnosis.findings[0] if diagnosis.findings else None
    return After(
        experiment=experiment.words,
        verdict=diagnosis.verdict,
        effects=diagnosis.effects,
        ties=diagnosis.indistinguishable,
        settled=first is not None
        and first.identifier == hidden
        and not diagnosis.indistinguishable,
    )
