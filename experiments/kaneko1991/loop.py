"""Measures of a loop as the paper gives them: slopes outside the backlash, ratios, backlash.

Equations: docs/theory.md, sections 1, 2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from experiments.kaneko1991.paper_tendon import PaperTendon
from experiments.kaneko1991.routes import Trace
from tendon_mj import theory
from tendon_mj.typing import FloatArray

_TRANSIENT = 0.15  # share of a branch left out: the front has just reached the output there
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


@dataclass(frozen=True)
class LoopMeasures:
    """Slopes, tension ratios and backlash of a closed loop, pulling and loosening.

    Args:
        slope_pulling, slope_loosening: dT_out/dξ_in outside the backlash [N/m].
        ratio_pulling, ratio_loosening: (T_out + F_c/λ)/(T_in + F_c/λ) there, median [-].
        backlash: travel of ξ_in from the upper reversal until T_out follows [m].
    """

    slope_pulling: float
    slope_loosening: float
    ratio_pulling: float
    ratio_loosening: float
    backlash: float


def sliding_branches(
    tendon: PaperTendon, exact: Trace, skip: int
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Masks of the samples at which all of the tendon slides, pulling and loosening.

    Args:
        tendon: with μ_d.
        exact: trace of the closed form.
        skip: samples at the beginning that are left out.
    """
    shift = tendon.tension_offset
    ratio = np.log((exact.input_tension + shift) / (exact.output_tension + shift))
    results = []
    for sign in (1.0, -1.0):
        slides = np.abs(ratio - sign * tendon.exponent) < 1e-9
        slides &= sign * np.gradient(exact.input_tension) > 0.0
        slides[:skip] = False
        starts = np.flatnonzero(np.diff(np.concatenate(([0], slides.astype(int)))) == 1)
        for start in starts:
            end = start + int(np.argmin(np.append(slides[start:], False)))
            slides[start : start + max(2, round(_TRANSIENT * (end - start)))] = False
        results.append(slides)
    return results[0], results[1]


def measure_loop(tendon: PaperTendon, trace: Trace, exact: Trace, skip: int) -> LoopMeasures:
    """Measure a loop by straight lines through its samples on the branches of the closed form."""
    shift = tendon.tension_offset
    lines, ratios = [], []
    for branch in sliding_branches(tendon, exact, skip):
        travel, tension = trace.input_displacement[branch], trace.output_tension[branch]
        lines.append(np.polyfit(travel - travel.mean(), tension, 1))
        lines[-1][1] -= lines[-1][0] * travel.mean()
        ratios.append(float(np.median((tension + shift) / (trace.input_tension[branch] + shift))))
    top = skip + int(np.argmax(exact.input_tension[skip:]))
    slope, offset = lines[1]
    backlash = trace.input_displacement[top] - (trace.output_tension[top] - offset) / slope
    return LoopMeasures(float(lines[0][0]), float(slope), ratios[0], ratios[1], float(backlash))


def predict_loop(tendon: PaperTendon, top_tension: float) -> LoopMeasures:
    """Measures by formula; ``top_tension`` is T_out at the upper reversal [N]."""
    lam = tendon.exponent
    return LoopMeasures(
        tendon.transmission_stiffness(1.0),
        tendon.transmission_stiffness(-1.0),
        float(np.exp(-lam)),
        float(np.exp(lam)),
        float(
            theory.reversal_backlash(
                lam, top_tension + tendon.tension_offset, tendon.axial_stiffness, tendon.length
            )
        ),
    )


def largest_difference(traces: dict[str, Trace], skip: int) -> float:
    """Largest difference of T_out between two of the routes over its range [-]."""
    outputs: FloatArray = np.array([trace.output_tension[skip:] for trace in traces.values()])
    return float(np.ptp(outputs, axis=0).max() / np.ptp(outputs[0]))


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
