"""Friction of a driven tendon for engines that run no plugins."""

import math
from typing import Any


def frictionloss(tension: Any, bend: Any, friction: Any, velocity: Any) -> Any:
    """MuJoCo's `frictionloss` that stands for a driven tendon's friction at one instant.

    T_in (1 − e^{−μφ}) while the tendon is drawn in or rests, T_in (e^{μφ} − 1) while it is pulled
    out. A pure function of numbers or arrays of NumPy, Torch, JAX and others, which broadcast.

    Written before every step, with a constraint as stiff as MuJoCo takes, it moves one joint as a
    sheath does to 0.03 % rms of its travel. With several joints on a tendon it leaves 52 to 91 % of
    the error of a model without friction, and an elastic cable loses twice the motion
    (docs/performance.md, "Rewritten in every step").

    Args:
        tension: T_in ≥ 0 at the input end [N]; a tendon that is pushed has no friction.
        bend: φ, the angle that the whole path turns through [rad].
        friction: μ [-].
        velocity: of the tendon's length, `ten_velocity` [m/s]; only its sign counts.

    Returns:
        The value for `tendon_frictionloss` [N].
    """
    exponent = friction * bend
    pulled = tension * (tension > 0)
    pulled_out = pulled * (velocity > 0)
    drawn_in = pulled - pulled_out
    return pulled_out * (math.e**exponent - 1.0) + drawn_in * (1.0 - math.e**-exponent)
