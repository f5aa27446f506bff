"""A rig without one of its recordings, to first order.

With A_k and b_k of `Observation` for what is fitted to all recordings, and m_j residuals of
recording j with mean square s_j, leaving out recording k changes the fitted values and what is left
of the others by

    δ = C_k⁻¹ b_k,   C_k = Σ_{j≠k} A_j,   Δs_j = (2 δᵀ b_j + δᵀ A_j δ) / m_j.
"""

from __future__ import annotations

import numpy as np

from tendon_mj.lab.fleet.observation import Observation, inverse
from tendon_mj.typing import FloatArray


def one_out(observation: Observation) -> tuple[FloatArray, FloatArray]:
    """(n, shared) values and (n,) misfits [noise] without each recording; none of a single one."""
    shared, count = slice(0, observation.shared), len(observation.square)
    normal, gradient = observation.normal[:, shared, shared], observation.gradient[:, shared]
    probes = np.array([number.probe for number in observation.numbers[shared]])
    total = normal.sum(axis=0)
    values, misfits = np.empty((0, observation.shared)), np.empty(0)
    for k in range(count if count > 1 else 0):
        step = inverse(total - normal[k]) @ gradient[k]
        less = 2.0 * gradient @ step + normal @ step @ step
        square = np.delete(observation.square + less / observation.samples, k)
        values = np.vstack([values, observation.values + probes * step])
        misfits = np.append(misfits, np.sqrt(np.maximum(square, 0.0).mean()))
    return values, misfits
