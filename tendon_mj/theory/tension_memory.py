"""Memory of a tendon in its sheath: the turning points of the input tension.

Equations: docs/theory.md, section 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.theory import _check
from tendon_mj.theory._exponential import log_ratio, mean_excess
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

    Raises:
        InvalidValueError: a tension that is not positive and finite.

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
