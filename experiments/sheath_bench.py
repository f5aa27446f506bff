"""A sheath alone on a bench, without MuJoCo: driven at the input, a spring at the output.

The path is a sheath of uniform bend with ``guides`` guides, the end segments half as long as the
others. Its output end sits on a spring k_se: T_out = T_0 + k_se ξ_out. Every sample is one quasi-
static step of the flow solver, so the result depends on the samples but not on time. Effects of a
law that know no time are here too: asymmetry, extra bend, the mount's compliance, and the backlash
of a drive that prescribes displacement.
"""

from __future__ import annotations

import ctypes
from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.errors import InvalidValueError
from tendon_mj.native import load
from tendon_mj.sheath import LAW, Guides, Law, Segments, friction_work, new_guides, new_segments
from tendon_mj.typing import FloatArray

# Parameters of the law that this bench implements; the others need time, or a state between steps.
# Damping is of no effect in quasi-static steps, nor are scales of effects that are refused.
_IMPLEMENTED = {
    "axial_stiffness",
    "axial_damping",
    "friction",
    "static_friction",
    "constant_friction",
    "pretension",
    "stribeck_velocity",
    "direction_asymmetry",
    "backlash",
    "creep_time",
    "sheath_compliance",
    "extra_bend",
}


class Response(NamedTuple):
    """Response of the sheath, a value per sample.

    Attributes:
        input_tension, output_tension: (samples,) [N].
        input_displacement, output_displacement: (samples,) positive towards the input [m].
        friction_work: (samples,) since the start [J].
        unsolved: samples whose flow was not solved.
    """

    input_tension: FloatArray
    output_tension: FloatArray
    input_displacement: FloatArray
    output_displacement: FloatArray
    friction_work: FloatArray
    unsolved: int


def _initial_tendon(
    law: Law, length: float, bend: float, guides: int, output_stiffness: float
) -> tuple[Segments, Guides]:
    """Segments and guides of the sheath at rest under its pretension."""
    for name in (n for n in LAW if n not in _IMPLEMENTED):
        if getattr(law, name) != 0.0:
            raise InvalidValueError(
                f"{name} = {getattr(law, name):g} has no effect on this bench; use the plugin"
            )
    segments, table = new_segments(guides + 1), new_guides(guides)
    strain = law.pretension / law.axial_stiffness
    segments["length"] = length / guides
    segments["length"][[0, -1]] /= 2.0
    segments["stored"] = segments["length"] / (1.0 + strain)
    segments["tension"] = strain
    segments["strain_slope"] = 1.0
    segments["length"][-1] += law.pretension / output_stiffness  # compensates the yield under T_0
    segments["support_compliance"][-1] = law.axial_stiffness / output_stiffness
    segments["length"][0] += law.sheath_compliance * law.pretension
    segments["support_compliance"][0] = law.sheath_compliance * law.axial_stiffness
    turned = max(0.0, abs(bend) + law.extra_bend)
    there, back = 1.0 + law.direction_asymmetry, 1.0 - law.direction_asymmetry
    table["static_ratio"] = np.exp(law.mu_s * there * turned / guides)
    table["dynamic_ratio"] = np.exp(law.friction * there * turned / guides)
    table["static_ratio_back"] = np.exp(law.mu_s * back * turned / guides)
    table["dynamic_ratio_back"] = np.exp(law.friction * back * turned / guides)
    table["constant_friction"] = law.constant_friction / (guides * law.axial_stiffness)
    return segments, table


_PLACES, _BOOL = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64], ctypes.c_bool
_solve = ctypes.CFUNCTYPE(_BOOL, *_PLACES, _BOOL, _BOOL)(load().address("tendon_mj_solve_flow"))
_friction_work = numba.njit(friction_work)


@numba.njit
def _solve_wound(segments: Any, guides: Any, drawn: float) -> Any:
    """Solve with ``drawn`` more tendon wound in than is stored, leaving the state as it was."""
    stored = segments[0].stored
    segments[0].stored = stored - drawn
    solved = _solve(segments.ctypes.data, guides.ctypes.data, len(guides), False, False)
    segments[0].stored = stored
    return solved


@numba.njit
def _find_drawn(segments: Segments, guides: Guides, target: float) -> float:
    """Length to wind in for the input's τ to become ``target``, which rises with it [m]."""
    low, high = 0.0, 0.0
    _solve_wound(segments, guides, 0.0)
    miss = segments[0].tension - target
    low_miss = high_miss = miss
    reach = abs(miss) * segments[0].length
    while miss != 0.0 and low_miss * high_miss > 0.0:
        if miss < 0.0:
            low, low_miss, high = high, high_miss, high + reach
            _solve_wound(segments, guides, high)
            high_miss = segments[0].tension - target
        else:
            high, high_miss, low = low, low_miss, low - reach
            _solve_wound(segments, guides, low)
            low_miss = segments[0].tension - target
        reach *= 2.0
    side = 0
    for _ in range(200):  # regula falsi, Illinois variant: bracketed, superlinear
        drawn = high - high_miss * (high - low) / (high_miss - low_miss) if high > low else high
        _solve_wound(segments, guides, drawn)
        miss = segments[0].tension - target
        if abs(miss) <= 1e-14 * target or high - low <= 1e-18:
            break
        if miss < 0.0:
            low, low_miss = drawn, miss
            high_miss *= 0.5 if side < 0 else 1.0
            side = -1
        else:
            high, high_miss = drawn, miss
            low_miss *= 0.5 if side > 0 else 1.0
            side = 1
    return drawn


@numba.njit
def _follow(
    segments: Segments, guides: Guides, history: FloatArray, by_tension: bool
) -> tuple[FloatArray, int]:
    """Four rows of a response to each sample of τ, or of ξ_in, and the number not solved."""
    out = np.empty((4, len(history)))
    unsolved, wound, work = 0, 0.0, 0.0
    for k in range(len(history)):
        drawn = _find_drawn(segments, guides, history[k]) if by_tension else history[k] - wound
        if not _solve_wound(segments, guides, drawn):
            unsolved += 1
        segments[0].stored -= drawn
        for i in range(len(guides)):
            flow = guides[i].flow
            segments[i].stored += flow
            segments[i + 1].stored -= flow
            guides[i].previous_slip = guides[i].slip if flow != 0.0 else 0.0
            work += _friction_work(segments[i].tension, segments[i + 1].tension, flow)
        wound = wound + drawn if by_tension else history[k]
        out[0, k], out[1, k] = segments[0].tension, segments[len(guides)].tension
        out[2, k], out[3, k] = wound, work
    return out, unsolved


def drive_sheath(
    history: ArrayLike,
    law: Law,
    *,
    length: float,
    bend: float,
    guides: int = 16,
    output_stiffness: float = np.inf,
    by_tension: bool = False,
) -> Response:
    """Move the input end through a history.

    Args:
        history: (samples,) ξ_in, tendon wound in under T_0 [m], or T_in > 0 [N].
        law: of the tendon and its sheath, pretension > 0.
        length: of the sheath [m].
        bend: its total angle [rad].
        guides: that stand for it.
        output_stiffness: k_se of what holds the output end [N/m]; inf: held.
        by_tension: the history is one of T_in.

    Raises:
        InvalidValueError: an effect of the law that is not here.
    """
    given = np.ascontiguousarray(history, float)
    stretch = 1.0 + law.pretension / law.axial_stiffness  # of tendon that is wound in
    segments, table = _initial_tendon(law, length, bend, guides, output_stiffness)
    if not by_tension:
        out, unsolved = _follow(segments, table, _play(given, law.backlash) / stretch, False)
        out[2] = given
    elif law.backlash > 0.0:
        raise InvalidValueError(
            f"backlash = {law.backlash:g} [m]: a tension says nothing about the drive behind it"
        )
    else:
        out, unsolved = _follow(segments, table, given / law.axial_stiffness, True)
        out[2] *= stretch
    near, far, work = law.axial_stiffness * out[[0, 1, 3]]
    return Response(near, far, out[2], (far - law.pretension) / output_stiffness, work, unsolved)


def _play(drive: FloatArray, backlash: float) -> FloatArray:
    """Length on a drum whose drive has to cross the backlash first [m]."""
    if backlash == 0.0:
        return drive
    drum, wound = np.empty_like(drive), 0.0
    for k, at in enumerate(drive):
        wound = min(max(wound, at - 0.5 * backlash), at + 0.5 * backlash)
        drum[k] = wound
    return drum
