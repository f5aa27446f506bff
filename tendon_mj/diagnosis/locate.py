"""Says where a misfit sits: which share of what is beyond noise lies in which regime."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendon_mj.diagnosis.problem import Problem
from tendon_mj.diagnosis.regimes import regimes

FloatArray = NDArray[np.float64]

_CONCENTRATED = 1.5  # times as much of the excess as of the time, to be worth a word


@dataclass(frozen=True)
class Place:
    """One bin of one coordinate.

    Attributes:
        regime, label: coordinate and bin.
        excess: share of the power beyond noise that lies there; all bins of a regime add up to 1.
        time: share of the samples that lie there.
        rms: of the residual there, in units of noise.
    """

    regime: str
    label: str
    excess: float
    time: float
    rms: float


@dataclass(frozen=True)
class Located:
    """Where a residual sits.

    Attributes:
        places: every bin of every regime that was visited.
        sentence: the same in words.
        frequency: frequency below which half of the excess lies [Hz]; 0 where there is no excess.
    """

    places: tuple[Place, ...]
    sentence: str
    frequency: float


def locate(problem: Problem, residual: FloatArray, mask: NDArray[np.bool_]) -> Located:
    """Spread the excess of a residual (m,), in units of noise, over the regimes.

    Only of the samples of ``mask`` (m,).
    """
    per_recording = regimes(problem.recordings)
    ends = np.cumsum([size for _, _, size in problem.blocks()])[:-1]
    kept = np.split(mask, ends)
    parts = [part[used] for part, used in zip(np.split(residual, ends), kept, strict=True)]
    residual = residual[mask]
    total = float((residual**2).sum()) - residual.size
    places = []
    for number, first in enumerate(per_recording[0]):
        powers: dict[str, list[FloatArray]] = {}
        for b in range(len(first.labels)):
            for (k, _, _), part, used in zip(problem.blocks(), parts, kept, strict=True):
                regime = per_recording[k][number]
                inside = part[regime.number[used] == b]
                if inside.size:
                    powers.setdefault(regime.labels[b], []).append(inside**2)
        places += [_place(first.name, label, found, residual) for label, found in powers.items()]
    columns: dict[str, list[FloatArray]] = {}
    for (_, column, _), part in zip(problem.blocks(), parts, strict=True):
        columns.setdefault(column, []).append(part**2)
    places += [_place("signal", column, found, residual) for column, found in columns.items()]
    frequency = _half(problem, parts) if total > 0.0 else 0.0
    return Located(tuple(places), _say(places, residual, frequency), frequency)


def _place(regime: str, label: str, powers: Sequence[FloatArray], residual: FloatArray) -> Place:
    inside = np.concatenate(powers)
    total = float((residual**2).sum()) - residual.size
    share = (float(inside.sum()) - inside.size) / total if total > 0.0 else 0.0
    return Place(regime, label, share, inside.size / residual.size, float(np.sqrt(inside.mean())))


def _half(problem: Problem, parts: Sequence[FloatArray]) -> float:
    """Frequency below which half of the excess power lies [Hz]."""
    frequencies, powers = [], []
    for (k, _, _), part in zip(problem.blocks(), parts, strict=True):
        step, size = float(np.median(np.diff(problem.recordings[k].time))), part.size
        power = np.abs(np.fft.rfft(part)) ** 2 / size - 1.0  # white noise of power 1 leaves 1
        frequencies.append(np.fft.rfftfreq(size, step))
        powers.append(power)
    frequency, power = np.concatenate(frequencies), np.concatenate(powers)
    order = np.argsort(frequency)
    added = np.cumsum(power[order])
    reached = np.flatnonzero(added >= 0.5 * added[-1])
    return float(frequency[order][reached[0]]) if added[-1] > 0.0 and reached.size else 0.0


def _say(places: Sequence[Place], residual: FloatArray, frequency: float) -> str:
    rms = float(np.sqrt(np.mean(residual**2)))
    if rms < 1.05:
        return f"The misfit is {rms:.2f} times the noise: nothing stands out."
    dense = sorted(
        (p for p in places if p.excess > 0.2 and p.excess > _CONCENTRATED * p.time),
        key=lambda p: p.time - p.excess,
    )
    said = f"The misfit is {rms:.1f} times the noise"
    if frequency > 0.0:
        said += f", half of its excess slower than {frequency:.2g} Hz"
    told: list[str] = []
    for place in dense:
        if place.regime not in told:
            told.append(place.regime)
            share = min(place.excess, 1.0)  # more, where another bin is below the noise
            said += f"; {share:.0%} of the excess lies in {place.time:.0%} of the samples, "
            said += f"where {place.regime} is {place.label}"
        if len(told) == 3:
            break
    return said + ("." if told else ", spread over all regimes.")
