"""Any history of displacement: the tensions that the play answers with.

Equations: docs/theory.md, section 2.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.errors import InvalidValueError
from tendon_mj.theory import _check
from tendon_mj.theory._sheath import Sheath, each_sheath
from tendon_mj.theory.tension_memory import TensionMemory
from tendon_mj.typing import FloatArray


def driven_tensions(
    displacement: ArrayLike,
    lam: ArrayLike,
    pretension: ArrayLike,
    axial_stiffness: ArrayLike,
    length: ArrayLike,
    output_stiffness: ArrayLike = np.inf,
) -> tuple[FloatArray, FloatArray]:
    """Input and output tension for any history of input displacement.

    Inverse of ``displacement``, the output end on a spring, T_out − T_0 = k_se ξ_out: at each
    sample the one T_in is found whose displacement is ξ_in. Before it, ξ_in = 0 and T = T_0.

    Args:
        displacement: ξ_in [m], time on axis 0; monotone between samples.
        lam: λ [–]; its sign is ignored.
        pretension: T_0 [N].
        axial_stiffness: EA [N].
        length: L [m].
        output_stiffness: k_se [N/m]; ``inf`` holds the output.

    Returns:
        T_in [N] and T_out [N], each of shape (time, broadcast of the rest).

    Raises:
        InvalidValueError: an argument out of its range, or so much paid out that the tendon
            is slack, ξ_in ≤ −T_0 (1/K_w + 1/k_se).

    Source: Kaneko et al. 1991, eqs. (6), (14) and (15), for any history.
    """
    series = _check.history("displacement", _check.finite("displacement", displacement))
    series, sheaths = each_sheath(
        series, lam, pretension, axial_stiffness, length, output_stiffness
    )
    near, far = np.empty(series.shape), np.empty(series.shape)
    for index, sheath in sheaths:
        memory, before = TensionMemory(sheath.pretension), 0.0
        for step in range(len(series)):
            target = float(series[(step, *index)])
            memory, before = _moved(sheath, memory, before, target), target
            near[(step, *index)] = memory.tension(0.0)
            far[(step, *index)] = memory.tension(sheath.size)
    return near, far


def _moved(sheath: Sheath, memory: TensionMemory, before: float, target: float) -> TensionMemory:
    """Solve for the memory in which the displacement has gone from ``before`` to ``target``.

    Displacement over T_in is convex while pulling, concave while loosening, and bounded by
    the line on which all of the tendon slides. Newton from that line is monotone.
    """
    if target <= sheath.slack:
        raise InvalidValueError(
            f"displacement must be > {sheath.slack!r} (the tendon is slack there), got {target!r}"
        )
    if target == before:
        return memory
    way = 1.0 if target > before else -1.0
    held = memory.turning_points[-1] if memory.turning_points else memory.pretension
    tension = (target - sheath.slack) / sheath.slope(sheath.size, way)
    for _ in range(200):  # never more than 20 seen
        # rounding must not carry the tension back over where the motion began
        tension = way * max(way * tension, way * held)
        moved = memory.after(tension)
        excess = sheath.displacement(moved) - target
        if way * excess <= 0:
            break
        new = tension - excess / sheath.slope(moved.sliding_depth, way)
        if new == tension:
            break
        tension = new
    return moved
