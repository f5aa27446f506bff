"""Inner loop of the continuum (Numba): play at every grid point, Newton on the displacement.

Equations: docs/theory.md, section 2.
"""

from __future__ import annotations

import numba

from tendon_mj.typing import FloatArray


@numba.njit(cache=True)
def displacement(
    tension: float,
    pretension: float,
    decay: FloatArray,
    compliance: FloatArray,
    profile: FloatArray,
) -> tuple[float, float]:
    """Return ξ_in that ``tension`` at the input brings about, and dξ_in/dT_in."""
    total, slope = 0.0, 0.0
    for j in range(profile.size):
        low, high = tension * decay[j], tension / decay[j]
        if profile[j] < low or (j == 0):
            total += compliance[j] * (low - pretension)
            slope += compliance[j] * decay[j]
        elif profile[j] > high:
            total += compliance[j] * (high - pretension)
            slope += compliance[j] / decay[j]
        else:
            total += compliance[j] * (profile[j] - pretension)
    return total, slope


@numba.njit(cache=True)
def tension_for(
    wanted: float,
    pretension: float,
    decay: FloatArray,
    compliance: FloatArray,
    profile: FloatArray,
) -> float:
    """Return T_in ≥ 0 for which ξ_in is ``wanted``.

    Away from the last T_in the function is piecewise linear and convex in the change, rising, so
    that Newton's steps from the last T_in overshoot at most once and then meet the root from one
    side, in at most as many steps as there are fronts.
    """
    slack, _slope = displacement(0.0, pretension, decay, compliance, profile)
    if wanted <= slack:
        return 0.0
    tension = float(profile[0])
    for _ in range(4 * profile.size):
        reached, slope = displacement(tension, pretension, decay, compliance, profile)
        change = max(-tension, (wanted - reached) / slope)
        tension += change
        if abs(change) <= 1e-13 * tension:
            break
    return tension


@numba.njit(cache=True)
def march_play(
    history: FloatArray,
    tension_driven: bool,
    pretension: float,
    decay: FloatArray,
    compliance: FloatArray,
    profile: FloatArray,
    record: FloatArray,
) -> None:
    """Take ``profile`` through ``history``; rows of ``record``: T_in, T_out, ξ_in."""
    for sample in range(history.size):
        tension = history[sample]
        if not tension_driven:
            tension = tension_for(tension, pretension, decay, compliance, profile)
        for j in range(profile.size):
            profile[j] = min(max(profile[j], tension * decay[j]), tension / decay[j])
        record[0, sample] = tension
        record[1, sample] = profile[profile.size - 1]
        reached = 0.0
        for j in range(profile.size):
            reached += compliance[j] * (profile[j] - pretension)
        record[2, sample] = reached if tension_driven else history[sample]
