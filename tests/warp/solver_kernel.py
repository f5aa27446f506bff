"""The flow solver on Warp alone, for tendons in arrays."""

import warp as wp

from tendon_mj.warp.solver import solve_flow
from tendon_mj.warp.tendons import Tendons, set_alone, set_guide, sheath_at

wp.set_module_options({"enable_backward": False})


@wp.kernel
def solve_all(
    t: Tendons,
    dynamic_ratio: wp.array2d[wp.float64],
    static_ratio: wp.array2d[wp.float64],
    solved: wp.array2d[wp.bool],
):
    """Solve every sheath of every world; threads (sheaths, worlds)."""
    k, w = wp.tid()
    for j in range(t.guides[k] + 1):
        set_alone(t, t.first_segment[k] + j, w)
    for i in range(t.guides[k]):
        row = t.first_guide[k] + i
        set_guide(t, row, w, dynamic_ratio[row, w], static_ratio[row, w], t.constant[row, w])
    solved[k, w] = solve_flow(t, sheath_at(t, k, w))
