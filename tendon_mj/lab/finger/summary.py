"""Largest force and tension ratios of a motion of the finger."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tendon_mj.lab.recordings import Recording

_LEAST = 1e-3  # output tension that a ratio divides by at least [N]


@dataclass(frozen=True)
class Summary:
    """Extremes over a motion.

    Attributes:
        tip_force_max: largest force on the distal phalanx [N].
        flexor_ratio_max, flexor_ratio_min: of the flexor's T_in/T_out [-].
    """

    tip_force_max: float
    flexor_ratio_max: float
    flexor_ratio_min: float

    def result(self) -> dict[str, float]:
        """Plain numbers for `result.json`."""
        return {
            "tip_force_max_N": self.tip_force_max,
            "flexor_input_over_output_max": self.flexor_ratio_max,
            "flexor_input_over_output_min": self.flexor_ratio_min,
        }


def summarise(answer: Recording) -> Summary:
    """Summary of a motion.

    Args:
        answer: as `simulate_finger` returns it.
    """
    columns = answer.columns
    output = np.maximum(columns["flexor_output_tension_N"], _LEAST)
    ratio = columns["flexor_input_tension_N"] / output
    return Summary(float(columns["tip_force_N"].max()), float(ratio.max()), float(ratio.min()))
