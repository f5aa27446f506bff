"""Any history: a play (backlash) operator on the logarithm of the tension, solved exactly.

Equations: docs/theory.md, section 2.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.theory import _check
from tendon_mj.theory._sheath import each_sheath
from tendon_mj.theory.tension_memory import TensionMemory
from tendon_mj.typing import FloatArray


def output_tension(input_tension: ArrayLike, lam: ArrayLike, pretension: ArrayLike) -> FloatArray:
    """Output tension for any history of input tension, from a uniform T_0 before it.

    ln T_out = Play_{|λ|}[ln T_in]: T_out ← clip(T_out, T_in e^{−|λ|}, T_in e^{+|λ|}).

    Args:
        input_tension: T_in [N], time on axis 0; monotone between samples.
        lam: λ [–] up to the point of interest; its sign is ignored.
        pretension: T_0 [N].

    Returns:
        T_out [N], shape (time, broadcast of the rest).

    Raises:
        InvalidValueError: a tension that is not positive and finite, lam not finite, no time axis.

    Source: Kaneko et al. 1991, eq. (5), for any history.
    """
    series = _check.history("input_tension", _check.positive("input_tension", input_tension))
    initial = _check.positive("pretension", pretension)
    size = np.abs(_check.finite("lam", lam))
    shape = np.broadcast_shapes(series.shape[1:], size.shape, initial.shape)
    result = np.empty((len(series), *shape))
    with np.errstate(over="ignore"):  # no upper bound, then
        fall, rise = np.exp(-size), np.exp(size)
        now = np.broadcast_to(initial, shape)
        for step, tension in enumerate(series):
            now = np.clip(now, tension * fall, tension * rise)
            result[step] = now
    return result


def displacement(
    input_tension: ArrayLike,
    lam: ArrayLike,
    pretension: ArrayLike,
    axial_stiffness: ArrayLike,
    length: ArrayLike,
    output_stiffness: ArrayLike = np.inf,
) -> FloatArray:
    """Displacement of the input end for any history of input tension; no grid, no drift.

    ξ_in = ξ_out + ∫(T − T_0)/EA dx over a uniform curvature, ξ_out = (T_out − T_0)/k_se.
    With the output held (the default) it is the elongation of the tendon.

    Args:
        input_tension: T_in [N], time on axis 0; monotone between samples.
        lam: λ [–]; its sign is ignored.
        pretension: T_0 [N].
        axial_stiffness: EA [N].
        length: L [m].
        output_stiffness: k_se [N/m]; ``inf`` holds the output.

    Returns:
        ξ_in [m], shape (time, broadcast of the rest).

    Raises:
        InvalidValueError: as in ``output_tension``; a stiffness or length that is not positive.

    Source: Kaneko et al. 1991, eqs. (6), (14) and (15), for any history.
    """
    series = _check.history("input_tension", _check.positive("input_tension", input_tension))
    series, sheaths = each_sheath(
        series, lam, pretension, axial_stiffness, length, output_stiffness
    )
    result = np.empty(series.shape)
    for index, sheath in sheaths:
        memory = TensionMemory(sheath.pretension)
        for step in range(len(series)):
            memory = memory.after(float(series[(step, *index)]))
            result[(step, *index)] = sheath.displacement(memory)
    return result
