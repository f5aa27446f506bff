"""Location of a misfit: the share of excess χ² that lies in each regime."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendon_mj.lab.diagnosis.data.problem import Problem
from tendon_mj.lab.diagnosis.data.regimes import regimes
from tendon_mj.lab.replay import column_name
from tendon_mj.typing import FloatArray

_CONCENTRATED = 1.5  # share of the excess over share of the samples, to be reported


@dataclass(frozen=True)
class Bin:
    """One bin of one regime.

    Attributes:
        regime, label: coordinate and range.
        excess: share of the excess χ² in the bin; all bins of a regime add up to 1.
        time: share of the samples in the bin.
        rms: of the residual in the bin [noise].
    """

    regime: str
    label: str
    excess: float
    time: float
    rms: float


@dataclass(frozen=True)
class Located:
    """Location of a residual.

    Attributes:
        bins: of every regime, those that were visited.
        sentence: summary in words.
        frequency: frequency below which half of the excess lies [Hz]; 0 where there is no excess,
            or where rows are rests.
    """

    bins: tuple[Bin, ...]
    sentence: str
    frequency: float


def locate(problem: Problem, residual: FloatArray, mask: NDArray[np.bool_]) -> Located:
    """Distribute the excess χ² of a residual over the regimes.

    Args:
        problem: data.
        residual: (m,) in units of noise.
        mask: (m,) samples to use.
    """
    per_recording = regimes(problem.recordings)
    ends = np.cumsum([size for _, _, size in problem.layout()])[:-1]
    kept = np.split(mask, ends)
    parts = [part[used] for part, used in zip(np.split(residual, ends), kept, strict=True)]
    residual = residual[mask]
    total = float((residual**2).sum()) - residual.size
    bins = []
    for index, first in enumerate(per_recording[0]):
        powers: dict[str, list[FloatArray]] = {}
        for b in range(len(first.labels)):
            for (k, _, _), part, used in zip(problem.layout(), parts, kept, strict=True):
                regime = per_recording[k][index]
                inside = part[regime.bins[used] == b]
                if inside.size:
                    powers.setdefault(regime.labels[b], []).append(inside**2)
        bins += [_bin(first.name, label, found, residual) for label, found in powers.items()]
    columns: dict[str, list[FloatArray]] = {}
    for (_, column, _), part in zip(problem.layout(), parts, strict=True):
        columns.setdefault(column, []).append(part**2)
    bins += [_bin("signal", column, found, residual) for column, found in columns.items()]
    rests = any(recording.quasi_static for recording in problem.recordings)
    frequency = _half_frequency(problem, parts) if total > 0.0 and not rests else 0.0
    return Located(tuple(bins), _describe(bins, residual, frequency), frequency)


def _bin(regime: str, label: str, powers: Sequence[FloatArray], residual: FloatArray) -> Bin:
    inside = np.concatenate(powers)
    total = float((residual**2).sum()) - residual.size
    share = (float(inside.sum()) - inside.size) / total if total > 0.0 else 0.0
    return Bin(regime, label, share, inside.size / residual.size, float(np.sqrt(inside.mean())))


def _half_frequency(problem: Problem, parts: Sequence[FloatArray]) -> float:
    """Frequency below which half of the excess power lies [Hz]."""
    frequencies, powers = [], []
    for (k, _, _), part in zip(problem.layout(), parts, strict=True):
        step, size = float(np.median(np.diff(problem.recordings[k].time))), part.size
        power = np.abs(np.fft.rfft(part)) ** 2 / size - 1.0  # white noise of power 1 leaves 1
        frequencies.append(np.fft.rfftfreq(size, step))
        powers.append(power)
    frequency, power = np.concatenate(frequencies), np.concatenate(powers)
    order = np.argsort(frequency)
    added = np.cumsum(power[order])
    reached = np.flatnonzero(added >= 0.5 * added[-1])
    return float(frequency[order][reached[0]]) if added[-1] > 0.0 and reached.size else 0.0


def _describe(bins: Sequence[Bin], residual: FloatArray, frequency: float) -> str:
    rms = float(np.sqrt(np.mean(residual**2)))
    if rms < 1.05:
        return f"The misfit is {rms:.2f} times the noise: nothing stands out."
    dense = sorted(
        (b for b in bins if b.excess > 0.2 and b.excess > _CONCENTRATED * b.time),
        key=lambda b: b.time - b.excess,
    )
    text = f"The misfit is {rms:.1f} times the noise"
    if frequency > 0.0:
        text += f", half of its excess slower than {frequency:.2g} Hz"
    reported: list[str] = []
    for found in dense:
        if found.regime not in reported:
            reported.append(found.regime)
            share = min(found.excess, 1.0)  # more, where another bin is below the noise
            of_signal = f"those of the signal {column_name(found.label)}"
            place = f"where {found.regime} is {found.label}"
            text += f"; {share:.0%} of the excess lies in {found.time:.0%} of the samples, "
            text += of_signal if found.regime == "signal" else place
        if len(reported) == 3:
            break
    return text + ("." if reported else ", spread over all regimes.")
