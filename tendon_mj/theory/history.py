"""Any history: a play (backlash) operator on the logarithm of the tension, solved exactly.

Of tension `output_tension` and `displacement`, of displacement `driven_tensions`; the turning
points of the input tension are the `TensionMemory` of both.

Equations: docs/theory.md, section 2.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.errors import InvalidValueError
from tendon_mj.theory import _check
from tendon_mj.theory._exponential import log_ratio, mean_excess, relative
from tendon_mj.typing import FloatArray


@dataclass(frozen=True)
class TensionMemory:
    """Exact tension profile after any history of input tension.

    At the friction angle s = μ × bend from the input, T(s) = x e^{−s} where the tendon last
    slid in a rise up to the turning point x, x e^{+s} where in a fall down to it, T_0 where it
    never slid. The turning points x_0, x_1, … are nested; piece x_i reaches from the depth
    of x_{i+1} to its own depth, |ln(x_0/T_0)| for the oldest and ½|ln(x_i/x_{i−1})| after it.
    The memory does not depend on the length of the sheath: it serves every |λ| at once.

    Args:
        pretension: T_0 [N], uniform before any motion, positive.
        turning_points: input tensions [N], oldest first, the present one last.

    Source: Kaneko et al. 1991, eq. (5), for any history.
    """

    pretension: float
    turning_points: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        _check.positive("pretension", self.pretension)
        _check.positive("turning_points", self.turning_points)

    def after(self, input_tension: float) -> TensionMemory:
        """Return the memory when the input tension has gone to ``input_tension`` [N], monotonely.

        A turning point is wiped out when the input passes it or closes the loop it opened.
        """
        points = list(self.turning_points)
        while points:
            # the first motion closes at its mirror image in ln T
            older = points[-2] if len(points) > 1 else self.pretension**2 / points[0]
            if min(older, points[-1]) < input_tension < max(older, points[-1]):
                break
            points.pop()
        return TensionMemory(self.pretension, (*points, float(input_tension)))

    @property
    def sliding_depth(self) -> float:
        """Friction angle [–] from the input over which the last motion slid; 0 if none has."""
        return float(self._depths[0]) if self.turning_points else 0.0

    def tension(self, angle: ArrayLike) -> FloatArray:
        """Return T [N] at the friction angle |λ(x)| [–] from the input, in the angle's shape."""
        s = _check.non_negative("angle", angle)
        piece = np.searchsorted(self._depths, s, side="right")
        points = np.append(self._points, self.pretension)
        return (points[piece] * np.exp(np.append(self._signs, 0.0)[piece] * s))[()]

    def mean_excess(self, angle: ArrayLike) -> FloatArray:
        """Return the mean of T − T_0 [N] over 0 … |λ| = ``angle``, in the angle's shape.

        The elongation of a sheath of uniform curvature is L/EA times it. At 0: T_in − T_0.
        """
        s = _check.non_negative("angle", angle)[..., np.newaxis]
        points, signs, initial = self._points, self._signs, np.asarray(self.pretension)
        begin = np.concatenate(([0.0], self._depths))[:-1]
        span = np.minimum(s, self._depths) - begin
        span = np.where(span > 0, span, 0.0)
        first = points * np.exp(signs * begin)
        mean = mean_excess(first, initial, signs * span)
        share = span / np.where(s == 0, 1.0, s)
        present = self.turning_points[-1] if self.turning_points else self.pretension
        total = np.sum(share * mean, axis=-1)
        return np.where(s[..., 0] == 0, present - self.pretension, total)[()]

    @cached_property
    def _points(self) -> FloatArray:
        """Turning points, newest first: in the order of depth."""
        return np.array(self.turning_points[::-1], dtype=np.float64)

    @cached_property
    def _before(self) -> FloatArray:
        """Tension from which each turning point was reached, T_0 for the oldest."""
        return np.append(self._points, self.pretension)[1:]

    @cached_property
    def _depths(self) -> FloatArray:
        share = np.full(len(self.turning_points), 0.5)
        share[-1:] = 1.0
        return share * np.abs(log_ratio(self._points, self._before))

    @cached_property
    def _signs(self) -> FloatArray:
        return -np.sign(self._points - self._before)


class _Sheath:
    """Displacement of the input end, ξ_in = (T_out − T_0)/k_se + (L/EA) mean(T − T_0)."""

    def __init__(
        self, lam: float, pretension: float, axial: float, length: float, spring: float
    ) -> None:
        self.size = abs(lam)
        self.pretension = pretension
        self.tendon = length / axial  # compliance, m/N
        self.spring = 1.0 / spring  # compliance, m/N
        # where the last tension is gone; also the zero of both lines of full sliding
        self.slack = -pretension * (self.tendon + self.spring)

    def displacement(self, memory: TensionMemory) -> float:
        """ξ_in [m] with the tension profile of ``memory``."""
        out = self.spring * (memory.tension(self.size) - self.pretension)
        return float(out + self.tendon * memory.mean_excess(self.size))

    def slope(self, depth: float, way: float) -> float:
        """dξ_in/dT_in [m/N] while the tendon slides down to ``depth``, pulling for way = 1."""
        depth = min(depth, self.size)
        share = depth / self.size if self.size else 1.0
        slope = self.tendon * share * float(relative(np.asarray(-way * depth)))
        if depth == self.size:
            slope += self.spring * float(np.exp(-way * depth))
        return slope


def each_sheath(
    series: FloatArray,
    lam: ArrayLike,
    pretension: ArrayLike,
    axial_stiffness: ArrayLike,
    length: ArrayLike,
    output_stiffness: ArrayLike,
) -> tuple[FloatArray, Iterator[tuple[tuple[int, ...], _Sheath]]]:
    """Broadcast a history (time on axis 0) with sheaths: the history, and index with sheath."""
    values = [
        _check.finite("lam", lam),
        _check.positive("pretension", pretension),
        _check.positive("axial_stiffness", axial_stiffness),
        _check.positive("length", length),
        _check.stiffness("output_stiffness", output_stiffness),
    ]
    shape = np.broadcast_shapes(series.shape[1:], *(value.shape for value in values))
    padded = series.reshape(len(series), *(1,) * (len(shape) - series.ndim + 1), *series.shape[1:])
    values = [np.broadcast_to(value, shape) for value in values]
    sheaths = (
        (index, _Sheath(*(float(value[index]) for value in values))) for index in np.ndindex(shape)
    )
    return np.broadcast_to(padded, (len(series), *shape)), sheaths


def output_tension(input_tension: ArrayLike, lam: ArrayLike, pretension: ArrayLike) -> FloatArray:
    """Output tension for any history of input tension, from a uniform T_0 before it.

    ln T_out = Play_{|λ|}[ln T_in]: T_out ← clip(T_out, T_in e^{−|λ|}, T_in e^{+|λ|}), with λ up to
    the point of interest.

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
            memory, before = _reached(sheath, memory, before, target), target
            near[(step, *index)] = memory.tension(0.0)
            far[(step, *index)] = memory.tension(sheath.size)
    return near, far


def _reached(sheath: _Sheath, memory: TensionMemory, before: float, target: float) -> TensionMemory:
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
