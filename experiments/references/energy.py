"""Energy of a chain through a run: supplied, stored and lost.

Equations: docs/theory.md, section 5.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tendon_mj.typing import FloatArray


@dataclass(frozen=True, eq=False)
class EnergyBalance:
    """Energies and works of a run, each of the shape of its ``time``.

    Args:
        elastic: ½ Σ T_j²/k_j of tendon, environment and sensor [J].
        kinetic: ½ Σ m_i ξ̇_i² [J].
        input_work: ∫ T_in dξ_in so far [J].
        friction_work: lost to friction so far, never falling [J].
        damping_work: ∫ Σ c_i ξ̇_i² dt so far, never falling [J].
    """

    elastic: FloatArray
    kinetic: FloatArray
    input_work: FloatArray
    friction_work: FloatArray
    damping_work: FloatArray

    @property
    def stored(self) -> FloatArray:
        """Elastic and kinetic energy gained since the start [J]."""
        total = self.elastic + self.kinetic
        gained: FloatArray = total - total[0]
        return gained

    @property
    def dissipated(self) -> FloatArray:
        """Work of friction and damping so far [J]."""
        return self.friction_work + self.damping_work

    @property
    def error(self) -> float:
        """Largest |input work − stored − dissipated| over the largest of the three [–]."""
        size = max(float(np.abs(e).max()) for e in (self.input_work, self.stored, self.dissipated))
        gap = float(np.abs(self.input_work - self.stored - self.dissipated).max())
        return gap / size if size > 0.0 else gap
