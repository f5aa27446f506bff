"""The relation between a segment's tension and the unstretched length that it holds.

    s(τ) = (ℓ − g τ) / (1 + τ)

as in `tendon_mj.sheath.segment_law`, for a purely elastic tendon.
"""

import warp as wp

from tendon_mj.warp.tendons import Sheath, Tendons

wp.set_module_options({"enable_backward": False})


@wp.func
def held(t: Tendons, s: Sheath, j: int, tau: wp.float64) -> wp.float64:
    """Unstretched length s_j(τ) [m]."""
    row, w = s.segment + j, s.world
    return (t.length[row, w] - t.give[row, w] * tau) / (wp.float64(1.0) + tau)


@wp.func
def slope_of(t: Tendons, s: Sheath, j: int, tau: wp.float64, holds: wp.float64) -> wp.float64:
    """Slope ds/dτ < 0 of s_j where it is ``holds``."""
    return -(t.give[s.segment + j, s.world] + holds) / (wp.float64(1.0) + tau)


@wp.func
def tension_of(t: Tendons, s: Sheath, j: int) -> wp.float64:
    """τ of a segment that keeps what it has; 0 when slack, inf where nothing can yield."""
    row, w = s.segment + j, s.world
    softness = t.kept[row, w] + t.give[row, w]
    if softness <= wp.float64(0.0):
        return wp.float64(wp.inf)
    return wp.max(wp.float64(0.0), (t.length[row, w] - t.kept[row, w]) / softness)


@wp.func
def highest(t: Tendons, s: Sheath, i: int, right: wp.float64) -> wp.float64:
    """Largest τ that guide i holds on its input side against ``right``."""
    row, w = s.guide + i, s.world
    return t.input_ratio[row, w] * right + t.constant[row, w]


@wp.func
def lowest(t: Tendons, s: Sheath, i: int, right: wp.float64) -> wp.float64:
    """Smallest τ that guide i holds on its input side against ``right``."""
    row, w = s.guide + i, s.world
    constant = t.constant[row, w]
    # the rounding of a difference must not make a slack segment taut
    if right > constant * wp.float64(1.0 + 1e-12):
        return (right - constant) / t.output_ratio[row, w]
    return wp.float64(0.0)
