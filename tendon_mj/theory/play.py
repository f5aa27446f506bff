"""Any history: a play (backlash) operator on the logarithm of the tension, solved exactly."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.errors import InvalidValueError
from tendon_mj.theory import _check
from tendon_mj.theory._check import FloatArray
from tendon_mj.theory._exponential import relative
from tendon_mj.theory.memory import TensionMemory


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
    floor = _check.positive("pretension", pretension)
    size = np.abs(_check.finite("lam", lam))
    shape = np.broadcast_shapes(series.shape[1:], size.shape, floor.shape)
    result = np.empty((len(series), *shape))
    with np.errstate(over="ignore"):  # no upper bound, then
        fall, rise = np.exp(-size), np.exp(size)
        now = np.broadcast_to(floor, shape)
        for row, tension in zip(result, series, strict=True):
            now = np.clip(now, tension * fall, tension * rise)
            row[...] = now
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
    series, sheaths = _sheaths(series, lam, pretension, axial_stiffness, length, output_stiffness)
    result = np.empty(series.shape)
    for index in np.ndindex(series.shape[1:]):
        sheath = _Sheath(*(float(value[index]) for value in sheaths))
        memory = TensionMemory(sheath.pretension)
        for step in range(len(series)):
            memory = memory.after(float(series[(step, *index)]))
            result[(step, *index)] = sheath.displacement(memory)
    return result


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
    series, sheaths = _sheaths(series, lam, pretension, axial_stiffness, length, output_stiffness)
    near, far = np.empty(series.shape), np.empty(series.shape)
    for index in np.ndindex(series.shape[1:]):
        sheath = _Sheath(*(float(value[index]) for value in sheaths))
        memory, before = TensionMemory(sheath.pretension), 0.0
        for step in range(len(series)):
            target = float(series[(step, *index)])
            memory, before = sheath.driven(memory, before, target), target
            near[(step, *index)] = memory.tension(0.0)
            far[(step, *index)] = memory.tension(sheath.size)
    return near, far


class _Sheath:
    """One sheath of uniform curvature with a spring at its output end."""

    def __init__(
        self, lam: float, pretension: float, axial: float, length: float, spring: float
    ) -> None:
        self.size = abs(lam)
        self.pretension = pretension
        self.tendon = length / axial  # compliance, m/N
        self.spring = 1.0 / spring  # compliance, m/N

    def displacement(self, memory: TensionMemory) -> float:
        out = self.spring * (memory.tension(self.size) - self.pretension)
        return float(out + self.tendon * memory.mean_excess(self.size))

    def driven(self, memory: TensionMemory, before: float, target: float) -> TensionMemory:
        """Solve for the memory in which the displacement has gone from ``before`` to ``target``.

        Displacement over T_in is convex while pulling, concave while loosening, and bounded by
        the line on which all of the tendon slides. Newton from that line is monotone.
        """
        slack = -self.pretension * (self.tendon + self.spring)
        if target <= slack:
            raise InvalidValueError(
                f"displacement must be > {slack!r} (the tendon is slack there), got {target!r}"
            )
        if target == before:
            return memory
        way = 1.0 if target > before else -1.0
        held = memory.turning_points[-1] if memory.turning_points else self.pretension
        tension = (target - slack) / self._slope(self.size, way)
        for _ in range(200):  # 5 to 10 suffice
            # rounding must not carry the tension back over where the motion began
            tension = way * max(way * tension, way * held)
            moved = memory.after(tension)
            excess = self.displacement(moved) - target
            if way * excess <= 0:
                break
            new = tension - excess / self._slope(moved.sliding_depth, way)
            if new == tension:
                break
            tension = new
        return moved

    def _slope(self, depth: float, way: float) -> float:
        """Derivative of displacement by T_in when the tendon slides down to ``depth``."""
        depth = min(depth, self.size)
        share = depth / self.size if self.size else 1.0
        slope = self.tendon * share * float(relative(np.asarray(-way * depth)))
        if depth == self.size:
            slope += self.spring * float(np.exp(-way * depth))
        return slope


def _sheaths(
    series: FloatArray,
    lam: ArrayLike,
    pretension: ArrayLike,
    axial_stiffness: ArrayLike,
    length: ArrayLike,
    output_stiffness: ArrayLike,
) -> tuple[FloatArray, list[FloatArray]]:
    values = [
        _check.finite("lam", lam),
        _check.positive("pretension", pretension),
        _check.positive("axial_stiffness", axial_stiffness),
        _check.positive("length", length),
        _check.stiffness("output_stiffness", output_stiffness),
    ]
    shape = np.broadcast_shapes(series.shape[1:], *(value.shape for value in values))
    padded = series.reshape(len(series), *(1,) * (len(shape) - series.ndim + 1), *series.shape[1:])
    sheaths = [np.broadcast_to(value, shape) for value in values]
    return np.broadcast_to(padded, (len(series), *shape)), sheaths
