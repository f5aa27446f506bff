"""The data of a diagnosis as one vector of residuals in units of noise."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tendon_mj.diagnosis.noise import noise_levels
from tendon_mj.recordings.recording import Recording
from tendon_mj.replay.simulates import Simulates

FloatArray = NDArray[np.float64]

_SEGMENT = 1.0  # typical length of a segment [s]; several in each recording, and not too many
_FEWEST, _MOST = 4, 12
_TAIL = 0.25  # of every recording, kept for the proof where no other recording is given


@dataclass(frozen=True, eq=False)
class Problem:
    """Recordings, what simulates them, and how their residuals are laid out.

    A residual is (simulated − measured)/noise. They are stacked by recording, then column, then
    sample. ``segments`` numbers stretches of time, all columns of a stretch sharing a number: they
    are what is held out in turn when effects are compared.

    Attributes:
        recordings: what was measured.
        simulate: parameter sets → a series for every set, recording and measured column.
        choice: recording → (samples,) mask of what may be used in choices; the rest is for proof.
        finer: ``simulate`` in steps half as long, see `refine`; None where it has no steps.
    """

    recordings: tuple[Recording, ...]
    simulate: Simulates
    choice: tuple[NDArray[np.bool_], ...]
    finer: Simulates | None = None

    @cached_property
    def noise(self) -> tuple[dict[str, float], ...]:
        """Noise of every measured column of every recording [the column's unit]."""
        return tuple(noise_levels(recording) for recording in self.recordings)

    @cached_property
    def chosen(self) -> NDArray[np.bool_]:
        """(m,) which residuals may be used in choices."""
        return np.concatenate([self.choice[k] for k, _, _ in self.blocks()])

    def blocks(self) -> list[tuple[int, str, int]]:
        """(recording, column, samples) in the order of the residuals."""
        return [
            (k, column, recording.time.size)
            for k, recording in enumerate(self.recordings)
            for column in recording.measured
        ]

    @cached_property
    def segments(self) -> NDArray[np.int64]:
        """(m,) number of the stretch of time that each residual belongs to, over all recordings."""
        numbers, first = [], 0
        for recording in self.recordings:
            time = recording.time - recording.time[0]
            count = int(np.clip(round(time[-1] / _SEGMENT), _FEWEST, _MOST))
            own = np.minimum((time / time[-1] * count).astype(np.int64), count - 1) + first
            numbers += [own] * len(recording.measured)
            first += count
        return np.concatenate(numbers)

    def residuals(self, parameter_sets: Sequence[Mapping[str, float]]) -> FloatArray:
        """(sets, m) residuals; a simulation that failed has infinite ones."""
        return self._residuals(self.simulate, parameter_sets)

    def refine(self, parameters: Mapping[str, float], residual: FloatArray) -> FloatArray:
        """(m,) a residual without what the length of the steps does to it.

        A simulation in steps of h errs by C h, to first order; so 2 r_{h/2} − r_h does not
        (Richardson's extrapolation).
        """
        if self.finer is None:
            return residual
        finer = self._residuals(self.finer, [parameters])[0]
        with np.errstate(invalid="ignore"):
            refined: FloatArray = 2.0 * finer - residual
        return np.where(np.isfinite(refined), refined, np.inf)

    def _residuals(
        self, simulate: Simulates, parameter_sets: Sequence[Mapping[str, float]]
    ) -> FloatArray:
        rows = []
        for answers in simulate(parameter_sets):
            parts = []
            for recording, noise, series in zip(self.recordings, self.noise, answers, strict=True):
                for column, level in noise.items():
                    parts.append((series[column] - recording.columns[column]) / level)
            row = np.concatenate(parts)
            rows.append(row if np.isfinite(row).all() else np.full(row.shape, np.inf))
        return np.array(rows)


def whole(recordings: Sequence[Recording]) -> tuple[NDArray[np.bool_], ...]:
    """Every sample may be used."""
    return tuple(np.ones(recording.time.size, bool) for recording in recordings)


def for_choices(
    train: Sequence[Recording], held_out: Sequence[Recording]
) -> tuple[NDArray[np.bool_], ...]:
    """What of ``train`` may be used: all where ``held_out`` proves it, else all but the tails."""
    if held_out:
        return whole(train)
    kept = []
    for recording in train:
        time = recording.time
        kept.append(time <= time[0] + (1.0 - _TAIL) * (time[-1] - time[0]))
    return tuple(kept)


Make = Callable[[Sequence[Recording]], Simulates]
