"""The flow solver on Warp alone, for tendons in arrays."""

import warp as wp

from tendon_mj.warp.solver import solve_flow
from tendon_mj.warp.tendons import Tendons, sheath_at

wp.set_module_options({"enable_backward": False})


@wp.kernel
def solve_all(t: Tendons, solved: wp.array2d[wp.bool]):
    """Solve every sheath of every world; threads (sheaths, worlds)."""
    k, w = wp.tid()
    solved[k, w] = solve_flow(t, sheath_at(t, k, w))
