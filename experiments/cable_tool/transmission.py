"""Load of a driven tendon from the input side alone: capstan and constant friction, with sliding.

With τ = T_in + k (θ − θ_mid), the input torque less the drive's elastic torque, the output slides

    closing (the load is lifted):      τ = x e^{+λ} + b_c   ⇒  x = (τ − b_c) e^{−λ}
    opening (the load drives back):    τ = x e^{−λ} + b_o   ⇒  x = (τ − b_o) e^{+λ}

where e^{±λ} is the capstan's ratio of a tendon in its sheath (docs/theory.md), b_c − b_o twice the
friction that does not grow with the load, and (b_c + b_o)/2 the zero of the torque cells. Between
the two lines the output holds: x ← clip(x, closing, opening) is the play operator of
docs/theory.md, section 2, with a constant beside λ.

Play alone lets the output move only if the input torque pushes it. A cable that is being drawn
on slides whichever way its torque changes, so that x also comes onto the line of the direction of
motion with the travel s since the last reversal: the distance to it is multiplied by
e^{−(s₂² − s₁²)/w²} from s₁ to s₂, little just after a reversal, where the cable still sticks, and
all of it after a travel of a few w. Nothing depends on the rate.
"""

from __future__ import annotations

import math

from numba import njit

from experiments.cable_tool.recording import ToolRecording
from tendon_mj.typing import FloatArray


def predict_load(
    recording: ToolRecording,
    friction_exponent: float,
    closing_offset: float,
    opening_offset: float,
    stiffness: float,
    take_up: float,
) -> FloatArray:
    """Load at the output [N m], from angle and torque of the input.

    The state before the recording is that at its end, as the recording covers whole periods.

    Args:
        recording: whose input side is read.
        friction_exponent: λ [-].
        closing_offset, opening_offset: b_c, b_o [N m].
        stiffness: k [N m/rad].
        take_up: w [rad], positive.
    """
    strokes = recording.strokes
    drive = recording.input_torque + stiffness * strokes.excursion
    load: FloatArray = _slide(
        (drive - closing_offset) * math.exp(-friction_exponent),
        (drive - opening_offset) * math.exp(friction_exponent),
        strokes.direction,
        (strokes.travel / take_up) ** 2,
    )
    return load


@njit(cache=True)
def _slide(
    closing: FloatArray, opening: FloatArray, direction: FloatArray, taken_up: FloatArray
) -> FloatArray:
    """Load between the lines ``closing`` and ``opening``; ``taken_up`` is (travel/w)²."""
    load = closing.copy()
    now = closing[-1] if direction[-1] < 0.0 else opening[-1]
    for _ in range(2):  # the first time for the state before the recording
        for i in range(closing.size):
            now = min(max(now, closing[i]), opening[i])
            if i > 0:
                before = taken_up[i - 1] if direction[i] == direction[i - 1] else 0.0
                line = closing[i] if direction[i] < 0.0 else opening[i]
                now = line + (now - line) * math.exp(-max(taken_up[i] - before, 0.0))
            load[i] = now
    return load
