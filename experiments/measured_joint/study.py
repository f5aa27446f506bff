"""The whole study: diagnoses, and all candidates on the same splits; draws nothing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from experiments.measured_joint.candidates import CANDIDATES, Candidate
from experiments.measured_joint.prediction import Error, error
from experiments.measured_joint.splits import BEYOND, Split, make_splits
from experiments.measured_joint.wound_in import WoundIn
from tendon_mj import Diagnosis, diagnose
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.recordings import Recording


@dataclass(frozen=True)
class Shown:
    """A held-out recording beside its simulations by the model before and after a diagnosis."""

    measured: Recording
    before: Recording
    after: Recording

    @property
    def errors(self) -> tuple[Error, Error]:
        """Errors before and after."""
        return error(self.measured, self.before.columns), error(self.measured, self.after.columns)


@dataclass(frozen=True)
class Diagnosed:
    """A diagnosis of the frictionless model, and its held-out recordings."""

    found: Diagnosis
    shown: tuple[Shown, ...]


@dataclass(frozen=True)
class Study:
    """Findings.

    Attributes:
        recordings: on which they rest.
        diagnoses: split → diagnoses, one for every bend that is left out.
        errors: candidate → split → held-out errors.
    """

    recordings: tuple[Recording, ...]
    diagnoses: Mapping[str, Sequence[Diagnosed]]
    errors: Mapping[str, Mapping[str, list[Error]]]

    def diagnosed_errors(self, split: str, *, after: bool = True) -> list[Error]:
        """Held-out errors of the model after a diagnosis, or before."""
        return [one.errors[after] for each in self.diagnoses[split] for one in each.shown]


def run_study(
    recordings: Sequence[Recording],
    seeds: int = 3,
    progress: Progress = silent,
    candidates: Sequence[Candidate] = CANDIDATES,
) -> Study:
    """Run every part.

    Args:
        recordings: of the rig, with the bends that are given and others.
        seeds: fits of every candidate in which something is random, for bends beyond the given.
        progress: called with the stage, the number done and the total.
        candidates: to compare.
    """
    splits = make_splits(recordings)
    diagnoses = {
        name: [_diagnose(split, progress) for split in parts] for name, parts in splits.items()
    }
    errors = {
        candidate.name: {
            name: _predict(candidate, parts, seeds if name == BEYOND else 1, progress)
            for name, parts in splits.items()
        }
        for candidate in candidates
    }
    return Study(tuple(recordings), diagnoses, errors)


def _diagnose(split: Split, progress: Progress) -> Diagnosed:
    diagnosis = diagnose(split.train, split.held_out, WoundIn, progress=progress)
    return Diagnosed(diagnosis, tuple(Shown(*one) for one in diagnosis.simulate()))


def _predict(
    candidate: Candidate, splits: Sequence[Split], seeds: int, progress: Progress
) -> list[Error]:
    runs = [(s, seed) for s in splits for seed in range(seeds if candidate.random else 1)]
    errors = []
    for done, (split, seed) in enumerate(runs):
        progress(candidate.name, done, len(runs))
        predict = candidate.fit(split.train, seed)
        errors += [error(recording, predict(recording), seed) for recording in split.held_out]
    progress(candidate.name, len(runs), len(runs))
    return errors
