"""Kernels: the yield of the guides beside the segments of driven elastic tendons.

The same as the plugin's `evaluate` and `drive`: a step resolves the stretches between guides, all
of them together, in the pose at hand. Equations: docs/theory.md, section 8, stiffness and step.
"""

import warp as wp

from tendon_mj.warp.groups import Groups
from tendon_mj.warp.motion import Dynamics, span_jacobian
from tendon_mj.warp.response import respond, step_of
from tendon_mj.warp.tendons import ZERO, Tendons

wp.set_module_options({"enable_backward": False})

_STIFF, _SOFTEST = wp.constant(wp.float64(1e6)), wp.constant(wp.float64(1e2))  # see `drive`


@wp.kernel
def respond_to_spans(b: Dynamics, t: Tendons, y: Groups) -> None:
    """J = ∂ℓ/∂q and M̂⁻¹ Jᵀ of each segment that moves; threads (elastic segments, worlds)."""
    n, w = wp.tid()
    row = y.span_row[n]
    if row < 0:
        return
    for dof in range(b.nv):
        slope = span_jacobian(b, t, y.span_segment[n], w, dof)
        y.span[row + dof, w] = slope
        y.span_solved[row + dof, w] = slope
    respond(b, y, y.span_solved, row, 0, b.nv, w)


@wp.kernel
def let_guides_yield(b: Dynamics, t: Tendons, y: Groups) -> None:
    """Yield g of the guides beside each segment; threads (elastic segments, worlds)."""
    n, w = wp.tid()
    segment, row = y.span_segment[n], y.span_row[n]
    mobility = wp.float64(0.0)
    for other in range(y.span_row.shape[0]):
        solved, along = y.span_row[other], wp.float64(0.0)
        if row >= 0 and solved >= 0:
            for dof in range(b.nv):
                slope = wp.float64(y.span[row + dof, w])
                along += slope * wp.float64(y.span_solved[solved + dof, w])
        mobility += wp.abs(along)
    h, length = step_of(b, w), t.length[segment, w]
    ea = wp.float64(t.axial_stiffness[w, t.sheath[segment]])
    yields = wp.max(ea * h * h * mobility, ea / _STIFF * length)
    t.give[segment, w] = wp.max(ZERO, wp.min(yields, ea / _SOFTEST * length) - length)
