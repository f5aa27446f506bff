"""Reads the paper's numbers off a loop: slopes outside the backlash, backlash, ratio.

Equations: docs/theory.md, sections 1, 2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from experiments.kaneko1991.rig import Rig
from experiments.kaneko1991.routes import Array, Trace
from tendon_mj import theory

_SETTLE = 0.15  # of a branch that is left out: where the front has just reached the output


@dataclass(frozen=True)
class LoopNumbers:
    """What a closed loop shows, pulling and loosening.

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


def branches(rig: Rig, exact: Trace, skip: int) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Samples at which all of the tendon slides, pulling and loosening, by the closed form.

    Args:
        rig: with μ_d.
        exact: trace of the closed form.
        skip: samples at the beginning to leave out.
    """
    shift = rig.tension_offset
    ratio = np.log((exact.input_tension + shift) / (exact.output_tension + shift))
    found = []
    for sign in (1.0, -1.0):
        slides = np.abs(ratio - sign * rig.exponent) < 1e-9
        slides &= sign * np.gradient(exact.input_tension) > 0.0
        slides[:skip] = False
        starts = np.flatnonzero(np.diff(np.concatenate(([0], slides.astype(int)))) == 1)
        for start in starts:
            end = start + int(np.argmin(np.append(slides[start:], False)))
            slides[start : start + max(2, round(_SETTLE * (end - start)))] = False
        found.append(slides)
    return found[0], found[1]


def loop_numbers(rig: Rig, trace: Trace, exact: Trace, skip: int) -> LoopNumbers:
    """Slopes, ratios and the backlash of a loop, on the branches of the closed form."""
    shift = rig.tension_offset
    lines, ratios = [], []
    for branch in branches(rig, exact, skip):
        travel, tension = trace.input_displacement[branch], trace.output_tension[branch]
        lines.append(np.polyfit(travel - travel.mean(), tension, 1))
        lines[-1][1] -= lines[-1][0] * travel.mean()
        ratios.append(float(np.median((tension + shift) / (trace.input_tension[branch] + shift))))
    top = skip + int(np.argmax(exact.input_tension[skip:]))
    slope, offset = lines[1]
    backlash = trace.input_displacement[top] - (trace.output_tension[top] - offset) / slope
    return LoopNumbers(float(lines[0][0]), float(slope), ratios[0], ratios[1], float(backlash))


def theory_numbers(rig: Rig, top_tension: float) -> LoopNumbers:
    """The same by the closed form; ``top_tension`` is T_out at the upper reversal [N]."""
    lam = rig.exponent
    return LoopNumbers(
        rig.slope(1.0),
        rig.slope(-1.0),
        float(np.exp(-lam)),
        float(np.exp(lam)),
        float(
            theory.reversal_backlash(
                lam, top_tension + rig.tension_offset, rig.axial_stiffness, rig.length
            )
        ),
    )


def largest_difference(traces: dict[str, Trace], skip: int) -> float:
    """Largest difference of T_out between two of the routes over its range [-]."""
    outputs: Array = np.array([trace.output_tension[skip:] for trace in traces.values()])
    return float(np.ptp(outputs, axis=0).max() / np.ptp(outputs[0]))
