"""A rig that is linear in its parameters, so that every excess χ² is known beforehand.

Waveforms are harmonics of 1 Hz with a mean square of 1 in every block of a second. The noise is
another harmonic: exactly orthogonal to all of them, and of a reduced χ² of exactly 1.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from tendon_mj.lab.diagnosis import (
    Candidate,
    Effect,
    Problem,
    Selection,
    SelectionContext,
    SystemDescription,
    Term,
    all_samples,
)
from tendon_mj.lab.diagnosis.effects.effect import Bound, EffectKind
from tendon_mj.lab.diagnosis.selection import CONVERGED, select_effects
from tendon_mj.lab.recordings import Recording
from tendon_mj.typing import FloatArray
from tests.lab.diagnosis.toy import Added
from tests.lab.recorded import recorded

Shape = Mapping[str, float]  # waveform → amplitude

COLUMN = "tension_N"
BLOCKS = 10  # in each of two recordings
_RATE = 100  # samples per block
WAVES = "abcdw"  # in the order of their frequency
_NOISE = 40  # Hz


def wave(frequency: int, time: FloatArray) -> FloatArray:
    """Harmonic with a mean square of 1 in every second."""
    return np.sqrt(2.0) * np.sin(2.0 * np.pi * frequency * time)


class LinearRig(Added):
    """Simulator of a rig that adds the shapes of its parameters."""

    def __init__(self, recordings: Sequence[Recording], shapes: Mapping[str, Shape]) -> None:
        super().__init__(recordings, dict.fromkeys(shapes, 0.0))
        self.shapes = shapes

    def waveform(self, parameter: str, column: str, recording: Recording) -> FloatArray:
        waves = (
            a * wave(1 + WAVES.index(w), recording.time) for w, a in self.shapes[parameter].items()
        )
        return sum(waves, np.zeros(recording.time.size))


def effect(
    name: str,
    kind: EffectKind = "missing",
    *,
    where: str = "sheath",
    most: float = 50.0,
    shape: str | None = None,
) -> Candidate:
    """Candidate that adds its parameter's shape; with ``shape`` a second parameter beside it."""
    terms = [Term((name,), "-", 0.0, -most, most, 0.1)]
    if shape is not None:
        terms.append(Term((shape,), "-", 0.0, 1e-3, 1.0, 1.0, starts=(0.05,)))
    return Candidate(named(name, kind), where, tuple(terms))


def named(name: str, kind: EffectKind = "missing", *, non_smooth: bool = False) -> Effect:
    """An effect that is bound by hand."""
    return Effect(name, name, "", "", "", nowhere, kind=kind, non_smooth=non_smooth)


def nowhere(_: SystemDescription) -> Bound:
    """No place on any model."""
    return []


def context(
    shapes: Mapping[str, Shape],
    truth: Shape,
    candidates: Iterable[Candidate],
    present: Sequence[float] = (1.0,) * (2 * BLOCKS),
) -> SelectionContext:
    """Selection on a rig that measures ``truth``, times ``present`` in every block, and noise."""
    made = []
    for k in range(2):
        time = (np.arange(BLOCKS * _RATE) + 0.5) / _RATE
        blocks = np.repeat(present[k * BLOCKS : (k + 1) * BLOCKS], _RATE)
        series = sum(a * wave(1 + WAVES.index(w), time) for w, a in truth.items())
        made.append(
            recorded(
                time,
                {},
                {COLUMN: ("tension", 1.0, blocks * series + wave(_NOISE, time))},
                name=f"r{k}",
            )
        )
    problem = Problem(tuple(made), LinearRig(made, shapes), all_samples(made))
    return SelectionContext(problem, {}, (), tuple(candidates), 0.0, 0.0, lambda *_: None)


def select(selection_context: SelectionContext) -> Selection:
    """Select effects as a diagnosis does, nothing being uncertain."""
    calibrated = selection_context.fit_model((), (), evaluations=CONVERGED)
    return select_effects(replace(selection_context, initial_excess=calibrated.excess), calibrated)


def selected(*args: object, **kwargs: object) -> set[str]:
    """Identifiers of the effects selected in a `context` of these arguments."""
    selection = select(context(*args, **kwargs))  # type: ignore[arg-type]
    return {e.candidate.identifier for e in selection.effects}
