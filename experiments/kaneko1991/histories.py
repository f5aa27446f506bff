"""Histories of the input: the paper's sine of T_in, and ξ_in through turning points."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tendon_mj.typing import FloatArray

LEG_TIME = 2.0  # from one turning point to the next [s]
LEG_SAMPLES = 60
LOW, HIGH = -1.2e-3, 2.4e-3  # of ξ_in, well beyond the backlash in both directions [m]
# kind of history -> turning points of ξ_in [m]
TURNING_POINTS: dict[str, tuple[float, ...]] = {
    "first motion, pulling": (HIGH,),
    "first motion, loosening": (LOW,),
    "outer loop": (HIGH, LOW, HIGH),
    "minor loops": (HIGH, LOW, 1.2e-3, 0.3e-3, 0.9e-3, -0.4e-3, HIGH),
}


def tension_sine(
    frequency: float, amplitude: float, pretension: float, periods: float, samples: int
) -> tuple[FloatArray, FloatArray]:
    """Time [s] and T_in = T_0 + T_m sin ωt [N], eq. (26); ``samples`` is per period."""
    time = np.arange(round(periods * samples) + 1) / (samples * frequency)
    return time, pretension + amplitude * np.sin(2.0 * np.pi * frequency * time)


def displacement_history(turning_points: Sequence[float]) -> tuple[FloatArray, FloatArray]:
    """Time [s] and ξ_in [m] from 0 through the turning points, half a cosine between each two."""
    phase = np.arange(len(turning_points) * LEG_SAMPLES + 1) / LEG_SAMPLES
    leg = np.minimum(phase.astype(int), len(turning_points) - 1)
    points = np.array((0.0, *turning_points))
    share = 0.5 - 0.5 * np.cos(np.pi * (phase - leg))
    return LEG_TIME * phase, points[leg] + (points[leg + 1] - points[leg]) * share


def random_turning_points(count: int, seed: int = 1991) -> list[tuple[float, ...]]:
    """Turning points [m] of ``count`` random histories of four legs.

    The first leg goes most of the way to one end or the other, so that T_out has a range to
    compare with; the other turning points are drawn uniformly.
    """
    rng = np.random.default_rng(seed)
    histories = []
    for _ in range(count):
        first = float(rng.choice((LOW, HIGH)) * rng.uniform(0.8, 1.0))
        histories.append((first, *rng.uniform(LOW, HIGH, 3).tolist()))
    return histories
