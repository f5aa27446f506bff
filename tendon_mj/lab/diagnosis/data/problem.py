"""The data of a diagnosis as one vector of residuals in units of noise."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tendon_mj.lab.diagnosis.data.answers import check_answers
from tendon_mj.lab.recordings import Recording, noise_levels, range_ends
from tendon_mj.lab.replay import Simulates, values_in
from tendon_mj.typing import FloatArray

MakeSimulator = Callable[[Sequence[Recording]], Simulates]

_BLOCK = 1.0  # typical length of a block [s]; several in each recording, and not too many
_ROWS = 2  # likewise, of rows that are rests
_FEWEST_BLOCKS, _MOST_BLOCKS = 4, 12
_FEWEST_RECORDINGS = 3
_TAIL = 0.25  # of every recording, held out where no other recording is given


@dataclass(frozen=True, eq=False)
class Problem:
    """Recordings, the simulator of them, and the layout of their residuals.

    A residual is (simulated − measured)/noise; a simulated reading is cut off where its column
    is. Residuals are stacked by recording, then column, then sample.

    Attributes:
        recordings: measured data.
        simulate: parameter sets → a series for every set, recording and measured column.
        train: for every recording (samples,) mask of the training data; the rest is held out.
        half_step: ``simulate`` with half the step, see `extrapolate`; None where it has no steps.
        fixed: parameters that every simulation has, below those of its own.
    """

    recordings: tuple[Recording, ...]
    simulate: Simulates
    train: tuple[NDArray[np.bool_], ...]
    half_step: Simulates | None = None
    fixed: Mapping[str, float] = field(default_factory=dict)

    @cached_property
    def noise(self) -> tuple[dict[str, float], ...]:
        """Noise of every measured column of every recording [the column's unit]."""
        return tuple(noise_levels(recording) for recording in self.recordings)

    @cached_property
    def ends(self) -> tuple[dict[str, tuple[float, float]], ...]:
        """Ends of the range that each measured column is cut off at, ±inf where it is not."""
        return tuple(
            {c: range_ends(r.columns[c], m.noise) for c, m in r.measured.items()}
            for r in self.recordings
        )

    @cached_property
    def in_train(self) -> NDArray[np.bool_]:
        """(m,) which residuals are training data."""
        return np.concatenate([self.train[k] for k, _, _ in self.layout()])

    def layout(self) -> list[tuple[int, str, int]]:
        """(recording, column, samples) in the order of the residuals."""
        return [
            (k, column, recording.time.size)
            for k, recording in enumerate(self.recordings)
            for column in recording.measured
        ]

    @cached_property
    def blocks(self) -> NDArray[np.int64]:
        """(m,) block of time of each residual, counted over all recordings.

        All columns share the blocks of their recording. Cross-validation leaves out one at a time.
        """
        labels, first = [], 0
        for recording in self.recordings:
            time = _clock(recording)
            block = _ROWS if recording.quasi_static else _BLOCK
            count = int(np.clip(round(time[-1] / block), _FEWEST_BLOCKS, _MOST_BLOCKS))
            own = np.minimum((time / time[-1] * count).astype(np.int64), count - 1) + first
            labels += [own] * len(recording.measured)
            first += count
        return np.concatenate(labels)

    @cached_property
    def recording_of(self) -> NDArray[np.int64]:
        """(m,) recording of each residual."""
        return np.concatenate([np.full(size, k) for k, _, size in self.layout()])

    @cached_property
    def parts(self) -> NDArray[np.int64]:
        """(m,) part of the data of each residual, which selection leaves out one at a time.

        Recordings where there are enough of different states, else blocks.
        """
        return self.recording_of if by_recording(self.recordings) else self.blocks

    def residuals(self, parameter_sets: Sequence[Mapping[str, float]]) -> FloatArray:
        """(sets, m) residuals; a simulation that failed has infinite ones."""
        return self._residuals(self.simulate, parameter_sets)

    def extrapolate(self, parameters: Mapping[str, float], residual: FloatArray) -> FloatArray:
        """(m,) residual without the first-order error of the simulation's step.

        A simulation with step h errs by C h to first order, and 2 r_{h/2} − r_h does not
        (Richardson extrapolation). Where rows are rests its error has no order, and the finer
        simulation is taken as it is.
        """
        if self.half_step is None:
            return residual
        finer = self._residuals(self.half_step, [parameters])[0]
        at_rest = any(recording.quasi_static for recording in self.recordings)
        with np.errstate(invalid="ignore"):
            extrapolated: FloatArray = finer if at_rest else 2.0 * finer - residual
        return np.where(np.isfinite(extrapolated), extrapolated, np.inf)

    def _residuals(
        self, simulate: Simulates, parameter_sets: Sequence[Mapping[str, float]]
    ) -> FloatArray:
        rows = []
        names = {recording.name for recording in self.recordings}
        sets = [
            values_in(names, {**self.fixed, **values}, simulate.parameters)
            for values in parameter_sets
        ]
        answered = simulate(sets)
        check_answers(answered, len(parameter_sets), self.recordings, simulate)
        for answers in answered:
            parts = []
            for recording, noise, ends, series in zip(
                self.recordings, self.noise, self.ends, answers, strict=True
            ):
                for column, level in noise.items():
                    shown = np.clip(series[column], *ends[column])
                    parts.append((shown - recording.columns[column]) / level)
            row = np.concatenate(parts)
            rows.append(row if np.isfinite(row).all() else np.full(row.shape, np.inf))
        return np.array(rows)


def by_recording(recordings: Sequence[Recording]) -> bool:
    """Whether whole recordings are left out: three or more, of different states of the rig.

    Their states differ where what is [known] differs, or where something was set anew for each.
    Where nothing does, recordings differ in what excites the rig, and one may be the only one that
    shows an effect.
    """
    first = recordings[0]
    differ = any(r.known != first.known or r.session for r in recordings)
    return differ and len(recordings) >= _FEWEST_RECORDINGS


def all_samples(recordings: Sequence[Recording]) -> tuple[NDArray[np.bool_], ...]:
    """For every recording (samples,) mask of all of it."""
    return tuple(np.ones(recording.time.size, bool) for recording in recordings)


def training_samples(
    train: Sequence[Recording], held_out: Sequence[Recording]
) -> tuple[NDArray[np.bool_], ...]:
    """For every recording (samples,) training mask, all but the tail if none is held out.

    Recordings of different states lose no tail: whole ones are left out for the proof.
    """
    if held_out or by_recording(train):
        return all_samples(train)
    return tuple(clock <= (1.0 - _TAIL) * clock[-1] for clock in map(_clock, train))


def _clock(recording: Recording) -> FloatArray:
    """(samples,) time from the first sample [s], or the number of the row where rows are rests."""
    if recording.quasi_static:
        return np.arange(recording.time.size, dtype=np.float64)
    since: FloatArray = recording.time - recording.time[0]
    return since
