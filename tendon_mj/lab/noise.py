"""Noise of a measured series, and the marks of a converter: its steps, range ends, held values."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.lab.recordings import Recording
from tendon_mj.typing import BoolArray, FloatArray

_GAUSS = 0.6744897501960817  # median |x| of a standard normal variable
_SAME = 1e-9  # of its range, by which values of one level differ
_OFF_GRID = 0.1  # of a step, rms: a uniform distribution has 0.29
_PARTS = 4  # steps between the two levels that are nearest to each other, at most
_WHITE = 0.5  # estimate by fourth over that by third differences: 1 of white noise, ~0 of motion
_PILE = 5  # samples at an end of the range, and times the fullest level near it
_NEAR = 3.0  # noises, that are near an end
_LONGEST = 20  # samples for which a sensor that is polled too often repeats a value
_FEWEST, _SHARE = 10, 0.1  # repeats, and of the samples
_CLEAR = 3.0  # steps of the column, by which values change that are repeated
_REGULAR = 0.9  # of the runs, which have one of two lengths
_AS_STATED = 1.05  # rounding over the stated noise, up to which that is taken to include it
_LEVELS = 100  # steps in the range: a command may have fewer levels, and be exact
_UNEVEN = 0.1  # share of the samples in motion
_MOST_LEVELS = 100_000  # of an encoder: a step of more is nothing beside other errors
_REPEATS = 0.01  # of its range: a driven column this near to another row's repeats it


def resolution(series: ArrayLike) -> float:
    """Step of a quantised series [its unit]; 0 where its values are not quantised.

    All levels are multiples of the step, to a tenth of it: values of a coarse converter may be
    rounded once more in the file. A ramp whose samples are evenly spaced is not quantised.
    """
    values = np.asarray(series, float)
    levels = np.unique(values)
    same = _SAME * float(np.ptp(values)) if values.size else 0.0
    gaps = np.diff(levels)
    levels, gaps = levels[np.append(True, gaps > same)], gaps[gaps > same]
    if not gaps.size:
        return 0.0
    multiples = np.unique(np.rint(np.abs(np.diff(values)) / gaps.min()))
    if np.count_nonzero(multiples) <= (0.0 not in multiples):
        return 0.0
    for part in range(1, _PARTS + 1):  # no two levels may be next to each other
        step = float(gaps.min()) / part
        for _ in range(3):
            places = np.concatenate([[0.0], np.cumsum(np.rint(gaps / step))])
            centred = places - places.mean()
            step = float(centred @ levels / (centred @ centred))
        off = levels - levels.mean() - step * centred
        if float(np.sqrt(np.mean(off**2))) < _OFF_GRID * step:
            return step
    return 0.0


def encoder_step(series: ArrayLike) -> float:
    """Step of a series as an encoder reads it, or as it was rounded; 0 of any other.

    Nor of one in few levels, or in very many. Exact ramps have steps too, and move on evenly, where
    what is read goes a mark more or less from sample to sample.
    """
    values, step = np.asarray(series, float), resolution(series)
    if not _LEVELS * step <= float(np.ptp(values)) < _MOST_LEVELS * step:
        return 0.0
    marks = np.rint(np.diff(values) / step)
    moves = (marks[1:] != 0.0) | (marks[:-1] != 0.0)
    uneven = np.abs(np.diff(marks)) == 1.0
    return step if np.count_nonzero(uneven) > _UNEVEN * np.count_nonzero(moves) else 0.0


def least_motion(series: FloatArray) -> FloatArray:
    """A series as an encoder reads it, with the least motion that is within half a step of it.

    Between two marks nothing tells where it was: it is linear from one to the next. The flicker of
    the last bit is no motion, but friction would act against it. It is removed by the mean of a
    play operator of the step's width forward in time, which lags behind, and backward. A series in
    few levels, or in very many, is returned as it is.
    """
    step = encoder_step(series)
    if not step > 0.0:
        return series
    half, steady = 0.5 * step, series
    changes = np.rint(np.diff(series) / step)
    changes = changes[changes != 0.0]
    if np.any((changes[1:] == -changes[:-1]) & (np.abs(changes[1:]) == 1.0)):
        half = (0.5 + _OFF_GRID) * step

        def play(values: Iterable[float], last: float) -> list[float]:
            return [last := min(max(last, value - half), value + half) for value in values]

        values = series.tolist()
        backward = play(reversed(values), play(values, values[0])[-1])
        ahead, behind = np.array(play(values, backward[-1])), np.array(backward[::-1])
        steady = 0.5 * (ahead + behind)
        # both stay short of where a motion turns: a value that stands still says where that is
        turns = np.flatnonzero(np.diff(ahead == behind, prepend=False, append=False))
        for span in map(slice, turns[::2].tolist(), turns[1::2].tolist()):
            if np.ptp(series[span]) == 0.0:
                steady[span] = series[span]
    return np.clip(_between_marks(steady), series - half, series + half)


def _between_marks(series: FloatArray) -> FloatArray:
    """A series in steps, linear from one step to the next; a value that stays for long is reached.

    As fast as before a step it goes on behind it, and as fast as behind the next it begins before.
    """
    steps = np.flatnonzero(np.diff(series))
    times, values = steps + 0.5, 0.5 * (series[steps] + series[steps + 1])
    begins, ends = np.append(0.0, times), np.append(times, series.size - 1.0)
    lasts = ends - begins
    before, after = np.append(0.0, lasts[:-1]), np.append(lasts[1:], 0.0)
    reached = begins + 0.5 * np.minimum(before, lasts)
    left = ends - 0.5 * np.minimum(after, lasts)
    held = lasts > 1.0
    level = series[np.append(steps, series.size - 1)][held]
    x = np.concatenate([times, reached[held], left[held]])
    y = np.concatenate([values, level, level])
    order = np.argsort(x, kind="stable")
    linear: FloatArray = np.interp(np.arange(series.size), x[order], y[order])
    return linear


def white_noise(series: FloatArray, among: BoolArray | None = None, order: int = 3) -> float:
    """Standard deviation of white noise on a smooth series, by its differences of an order.

    Differences with a sample that is not ``among`` those that count, (n,), are left out. 0 of
    less than 2 ``order`` + 2 samples.
    """
    if series.size < 2 * order + 2:
        return 0.0
    differences = np.abs(np.diff(series, order))
    if among is not None:
        inside = np.lib.stride_tricks.sliding_window_view(among, order + 1).all(axis=1)
        differences = differences[inside]
    if differences.size <= order:
        return 0.0
    return float(np.median(differences)) / _GAUSS / math.sqrt(math.comb(2 * order, order))


def is_noisy(series: FloatArray, among: BoolArray | None = None) -> bool:
    """Return whether a series has noise that is white, and more than its steps."""
    third, fourth = (white_noise(series, among, order) for order in (3, 4))
    return fourth > _WHITE * third and third > resolution(series)


def range_ends(series: FloatArray, noise: float | None = None) -> tuple[float, float]:
    """Ends of a range that a noisy series is cut off at; -inf and inf if it is not.

    Readings pile up at an end: noise makes any other level about as frequent as its neighbours.
    ``noise``: its standard deviation, if known [the unit of the series].
    """
    series = series[~held_values(series, noise)]
    inner = (series > series.min()) & (series < series.max())
    level = white_noise(series, inner)
    stated = noise is not None and noise > _CLEAR * resolution(series)
    if not (is_noisy(series, inner) or (stated and level > 0.0)):
        return -math.inf, math.inf
    ends = []
    for sign in (-1.0, 1.0):
        values = sign * series
        top = float(values.max())
        _, counts = np.unique(
            values[(values >= top - _NEAR * level) & (values < top)], return_counts=True
        )
        at_end = int(np.sum(values == top))
        piled = at_end >= _PILE * max(1, int(counts.max(initial=1)))
        ends.append(sign * top if piled else sign * math.inf)
    return ends[0], ends[1]


def held_values(
    series: FloatArray, noise: float | None = None, longest: int = _LONGEST
) -> BoolArray:
    """(n,) samples that repeat the one before, of a sensor that is read faster than it converts.

    All False if equal neighbours are what noise, steps or rests make: repeats count where values
    change by several steps of the column, for as long each time or in a column that has ``noise``
    [the unit of the series]. A run of equal values longer than ``longest`` samples is a rest.
    """
    none = np.zeros(series.size, bool)
    changes = np.append(np.inf, np.abs(np.diff(series)))
    starts = np.flatnonzero(changes > 0.0)
    lengths = np.diff(np.append(starts, series.size))
    short = (lengths <= longest) & (series[starts] > series.min()) & (series[starts] < series.max())
    short[[0, -1]] = False  # cut off by the recording
    repeated = short & (lengths > 1)
    count = int((lengths[repeated] - 1).sum())
    if count < _FEWEST or count < _SHARE * int(lengths[short].sum()):
        return none
    step = resolution(series)
    by_chance = 0.5 * float(np.sum((changes > 0.0) & (changes < 1.5 * step)))
    before = changes[starts[repeated]]
    if float(np.median(before)) < _CLEAR * step or count < _CLEAR * by_chance:
        return none
    mean = float(lengths[short].mean())
    regular = float(np.mean(np.abs(lengths[short] - mean) < 1.0)) > _REGULAR
    noisy = noise is not None and noise > 2.0 * step
    if not (regular or noisy or is_noisy(series[starts])):
        return none
    mask: BoolArray = changes == 0.0
    mask[np.repeat(lengths > longest, lengths)] = False
    return mask


def estimate_noise(series: ArrayLike) -> float:
    """Standard deviation σ of white noise on a smooth series at even times [its unit].

    The third difference of white noise has a variance of 20 σ², that of a smooth series nearly
    none; the median is robust to the few samples at kinks. Samples at the end of a range, where
    there is no noise, do not count. At least the quantisation noise q/√12 of the series' own
    resolution q, so > 0 unless the series is constant.
    """
    values = np.asarray(series, float)
    inner = ~np.isin(values, range_ends(values))
    return max(white_noise(values, inner), resolution(values) / math.sqrt(12.0))


def noise_of_repeats(recording: Recording, column: str) -> tuple[float, int]:
    """Standard deviation of rests that repeat each other, and how many more there are than one.

    A rest repeats another where the drive is the same, and was so at the rest before. Of groups of
    n_g such rows, σ² = Σ_g Σ_k (y_gk - ȳ_g)²/Σ_g (n_g - 1) [the column's unit], 0 if none
    repeats another. The second number is Σ_g (n_g - 1).
    """
    driven = [recording.columns[name] for name in recording.drive]
    places = [np.rint(d / (_REPEATS * (float(np.ptp(d)) or 1.0))) for d in driven]
    moves = np.column_stack([part for place in places for part in (place[1:], place[:-1])])
    _, group = np.unique(moves, axis=0, return_inverse=True)
    values, group = recording.columns[column][1:], group.ravel()
    counts = np.bincount(group)
    means = np.bincount(group, values) / counts
    repeats = int(np.sum(counts - 1))
    return math.sqrt(float(np.sum((values - means[group]) ** 2)) / max(repeats, 1)), repeats


def noise_levels(recording: Recording) -> dict[str, float]:
    """Measured column → its noise [the column's unit]: as stated, else as estimated.

    To a stated noise that is finer than the column's steps q, their q/√12 is added. A column that
    never changes has no noise to compare with; it gets 1e-3 of its magnitude.
    """
    levels = {}
    for column, measured in recording.measured.items():
        values = recording.columns[column]
        if measured.noise is not None:
            rounding = resolution(values) / math.sqrt(12.0)
            fine = rounding <= _AS_STATED * measured.noise
            level = measured.noise if fine else math.hypot(measured.noise, rounding)
        elif recording.quasi_static:
            level = noise_of_repeats(recording, column)[0]
        else:
            level = estimate_noise(values)
        levels[column] = level or 1e-3 * float(np.abs(values).max()) or 1e-9
    return levels
