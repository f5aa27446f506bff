"""Each threshold holds at its edge: a fault just beyond it is warned of, one just within is not."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from tendon_mj.lab.data_check import DataWarning, columns, mistaken_columns, timing_warnings
from tendon_mj.lab.data_check.column import Column, stands, usual_range
from tendon_mj.lab.data_check.jumps import jump_warnings
from tests.lab.recorded import recorded

NOISE = np.random.default_rng(1).normal(0.0, 0.02, 800)
ROWS = np.arange(800)
WAVE = 10.0 + 5.0 * np.sin(0.01 * ROWS)  # [N]


def column(
    read: np.ndarray,
    model: np.ndarray = WAVE,
    name: str = "in_N",
    noise: float | None = None,
    **more,
) -> Column:
    """A measured column beside what the model would read."""
    drive = {"reel_m": ("reel", 1e-3 * np.sin(0.01 * ROWS[: read.size]))}
    time = more.pop("time", 0.01 * ROWS[: read.size])
    made = recorded(time, drive, {name: ("input_tension", noise, read)}, name="made", **more)
    return Column(made, name, replace(made, columns={**made.columns, name: model[: read.size]}))


BESIDE = slice(391, 396)


def put(series: np.ndarray, rows: slice | Sequence[int], values: object) -> np.ndarray:
    series = series.copy()
    series[rows] = values
    return series


def spikes(column: Column) -> list[DataWarning]:
    return list(columns.spike_warnings([column]))


def jumps(column: Column) -> list[DataWarning]:
    return jump_warnings([column], lambda recording: None)


def hum(times: float, rows: int = 200, moves: float = 0.0, settles: int = 0) -> DataWarning | None:
    """A reading of a drive that rests at first, whose slow noise there is so many times stated."""
    later = np.sin(0.01 * np.maximum(0, ROWS - rows + 1))
    reel = 1e-3 * later + np.where(rows // 2 == ROWS, 2e-3 * moves, 0.0)
    slow = 0.02 * times * math.sqrt(2.0) * np.sin(0.7 * ROWS)
    made = column(10.0 + 5.0 * later + slow, 10.0 + 5.0 * later + (settles > ROWS), noise=0.02)
    changed = {**made.recording.columns, "reel_m": reel}
    return columns.scatter_at_rest(
        replace(made, recording=replace(made.recording, columns=changed))
    )


def hang(rows: int, noise: float = 1.0, model: np.ndarray = WAVE) -> DataWarning | None:
    read = put(model + noise * NOISE[: model.size], slice(10, 10 + rows), 12.0)
    return columns._frozen(column(read, model))


def level(samples: int, spread: float) -> DataWarning | None:
    """A reading that ends where the model goes on, for some samples, with some noises there."""
    end = np.sort(WAVE)[-samples - 1]
    beyond = end < WAVE
    noise = 0.02 * np.where(beyond, spread, 1.0) * (-1.0) ** (ROWS // 2)
    model = np.where(beyond, end + 0.5 + 3.0 * (ROWS % 2), WAVE)
    return columns.range_end(column(np.minimum(WAVE, end) + noise, model, noise=0.02))


def dropout(steps: float) -> list[DataWarning]:
    """A triangle that falls by so many of its steps from a peak, ten times."""
    wave = np.abs(np.mod(ROWS, 40) - 20.0)
    return spikes(column(put(wave, ROWS[80::80], 19.0 - steps)))


def late(noise: float) -> list[DataWarning]:
    """Stamps that are late by up to half an interval, of a smooth column with noise."""
    stamps = 0.01 * (ROWS + np.random.default_rng(2).uniform(0.0, 0.5, 800))
    made = recorded(stamps, {"reel_m": ("reel", WAVE + noise * NOISE)}, {}, name="made")
    return [w for w in timing_warnings(made) if "evenly from row to row" in w.value]


def in_degrees(span: float) -> list[DataWarning]:
    """A drive of so many rad at which the model is far off, and at as many degrees is not."""
    angle = 0.5 * span * np.sin(0.01 * ROWS)
    drive = {"reel_rad": ("reel", angle)}
    made = recorded(0.01 * ROWS, drive, {"in_N": ("input_tension", None, WAVE)}, name="made")
    far = replace(made, columns={**made.columns, "in_N": 9.0 * WAVE})
    return mistaken_columns.degree_warnings(made, far, lambda recording: made)


def exchanged(away: float, noise: float = 0.0) -> list[DataWarning]:
    """Two columns of a model so far apart, of their range, recorded in each other's place."""
    models = WAVE, 20.0 + WAVE + away * np.ptp(WAVE) * np.sin(0.05 * ROWS)
    read = [model + noise * np.ptp(WAVE) * (-1.0) ** ROWS for model in models]
    drive = {"reel_m": ("reel", 1e-3 * np.sin(0.01 * ROWS))}
    measured = {
        "in_N": ("input_tension", None, read[1]),
        "out_N": ("output_tension", None, read[0]),
    }
    made = recorded(0.01 * ROWS, drive, measured, name="made")
    shown = dict(zip(measured, models, strict=True))
    simulated = replace(made, columns={**made.columns, **shown})
    return list(mistaken_columns.exchange_warnings(made, simulated, lambda recording: None))


def with_correlation(correlation: float) -> Column:
    wave, other = (y - y.mean() for y in (WAVE, np.sin(0.03 * ROWS)))
    other -= wave * (other @ wave) / (wave @ wave)
    other *= np.linalg.norm(wave) / np.linalg.norm(other)
    return column(math.sqrt(1.0 - correlation**2) * other + correlation * wave)


def rounded(share: float) -> DataWarning | None:
    step = share * usual_range(WAVE)
    return columns.coarse(column(step * np.rint(WAVE / step)))


def in_counts(times: float, whole: bool = True, model: np.ndarray = WAVE) -> DataWarning | None:
    """An angle in the file's degrees, so many times the model's."""
    degrees = times * np.degrees(WAVE)
    read = np.radians(np.rint(degrees) if whole else degrees)
    return columns._unit(column(read, model, "arm_rad", in_file={"arm_rad": "arm_deg"}))


@pytest.mark.parametrize("bits", [12, 13, 14, 16])
def test_counts_of_an_encoder_named_degrees_are_told_with_what_one_is(bits: int) -> None:
    found = in_counts(2.0**bits / 360.0)
    assert found is not None
    assert found.identifier == "unit"
    assert "'arm_deg'" in found.place
    assert "whole counts" in found.value
    assert 'arm_deg = { column = "arm_deg", factor = … }, which is 0.087890625' in found.way_out


def test_degrees_in_whole_numbers_are_no_counts() -> None:
    """Nor are those of another shape, or broken ones, however much more they move."""
    assert in_counts(2.0) is None
    assert in_counts(12.0, model=WAVE[::-1] + np.cos(0.03 * ROWS)) is None
    assert in_counts(12.0, whole=False) is None


DEGREES = math.degrees(1.0)
# fault → what finds it in data of a size, and sizes within and beyond its threshold
EDGES: dict[str, tuple[Callable[[float], object], float, float]] = {
    "a jump by a turn": (
        lambda turns: columns.turn(column(turns * math.tau * (ROWS > 400), name="arm_rad")),
        0.88,
        0.92,
    ),
    "outliers of a range": (
        lambda share: usual_range(np.where(800 * share > ROWS, 100.0, WAVE)) > 50.0,
        0.007,
        0.013,
    ),
    "motion": (lambda size: not stands(20.0 + 20e-6 * size * (ROWS % 2)), 0.7, 1.3),
    "a spike in noise": (
        lambda noises: spikes(column(10.0 + put(NOISE, [400], 0.02 * noises), 0.0 * WAVE)),
        5.0,
        9.5,
    ),
    "a spike of a share of the range": (
        lambda share: spikes(column(put(WAVE, [400], WAVE[400] + 10.0 * share))),
        0.45,
        0.55,
    ),
    "a spike for samples": (
        lambda samples: spikes(column(put(WAVE, slice(400, 400 + samples), 90.0 + ROWS[:samples]))),
        3,
        2,
    ),
    "a spike beside changes of a share of it": (
        lambda share: spikes(
            column(put(put(WAVE, [400], WAVE[400] + 6.0), BESIDE, WAVE[BESIDE] + 6.0 * share))
        ),
        1.1,
        0.9,
    ),
    "a spike samples after one of the model": (
        lambda samples: spikes(column(put(WAVE, [400 + samples], 90.0), put(WAVE, [400], 90.0))),
        7,
        10,
    ),
    "a dropout by steps": (dropout, 2.6, 3.9),
    "coarse steps": (rounded, 0.002, 0.003),
    "a noise stated too large": (
        lambda times: columns.overstated_noise(column(WAVE + NOISE, noise=0.02 * times)),
        8.0,
        12.0,
    ),
    "scatter at rest": (hum, 1.25, 1.75),
    "scatter in rows at rest": (lambda rows: hum(3.0, rows), 38, 42),
    "scatter behind rows in which the model settles": (
        lambda rows: hum(3.0, 70, settles=rows),
        18,
        12,
    ),
    "scatter beside a drive at rest": (lambda moves: hum(3.0, 70, moves), 1.2e-4, 0.8e-4),
    "equal samples": (hang, 8, 12),
    "equal samples of an exact reading": (
        lambda share: hang(round(100 * share), 0.0, 0.1 * ROWS[:101]),
        0.25,
        0.35,
    ),
    "equal rests": (
        lambda rests: columns._frozen(
            column(put(WAVE[::40], slice(5, 5 + rests), 12.0), WAVE[::40], settling_time=0.001)
        ),
        3,
        5,
    ),
    "a level end for samples": (lambda samples: level(samples, 1.0), 17, 24),
    "a level end with noise": (lambda noises: level(80, noises), 1.5, 1.15),
    "held values that miss noises": (
        lambda noises: columns.held(column(WAVE[ROWS // 4 * 4], noise=0.0655 / noises)).blocks,
        0.4,
        0.55,
    ),
    "a motion that no unit makes so small": (
        lambda times: columns._still(column(WAVE / times)),
        2500.0,
        3500.0,
    ),
    "a motion that no unit makes so large": (
        lambda times: columns._still(column(WAVE * times)),
        2500.0,
        3500.0,
    ),
    "thousandths": (lambda times: columns._unit(column(times * WAVE)), 90.0, 110.0),
    "degrees": (lambda times: columns._unit(column(times * WAVE)), DEGREES / 1.6, DEGREES / 1.4),
    "a drive in degrees": (in_degrees, 2.5, 3.5),
    "whole counts": (in_counts, 4.5, 5.5),
    "a reversed sign": (lambda against: columns._sign(with_correlation(-against)), 0.6, 0.8),
    "another motion": (lambda shared: columns._unlike(with_correlation(shared)), 0.8, 0.6),
    "another motion beyond noises": (
        lambda noises: columns._unlike(column(WAVE[::-1], noise=np.ptp(WAVE) / noises)),
        7.0,
        9.0,
    ),
    "exchanged columns": (exchanged, 0.13, 0.2),
    "exchanged columns that are far from the model": (
        lambda noise: exchanged(3.0, noise),
        0.5,
        0.3,
    ),
    "exchanged columns that come little nearer": (
        lambda noise: exchanged(0.4, noise),
        0.15,
        0.08,
    ),
    "another start": (lambda share: columns._start(column(WAVE + share * 10.0)), 0.12, 0.18),
    "another start beyond noises": (
        lambda noises: columns._start(column(WAVE + 2.0 * noises, noise=2.0)),
        2.5,
        3.5,
    ),
    "another start for samples": (
        lambda samples: columns._start(column(put(WAVE, slice(0, samples), 90.0))),
        2,
        3,
    ),
    "a zero that stays away": (
        lambda samples: jumps(
            column(
                WAVE
                + NOISE
                + np.interp(ROWS, [299, 300, 300 + samples, 320 + samples], [0, 3, 3, 0])
            )
        ),
        70,
        120,
    ),
    "steps of a zero": (
        lambda steps: jumps(column(WAVE + NOISE + 3.0 * np.minimum(steps, ROWS // 150))),
        3,
        2,
    ),
    "late stamps": (late, 0.2, 0.12),
}


@pytest.mark.parametrize("fault", EDGES)
def test_a_fault_is_warned_of_from_a_threshold_on(fault: str) -> None:
    found, within, beyond = EDGES[fault]
    assert not found(within)
    assert found(beyond)
