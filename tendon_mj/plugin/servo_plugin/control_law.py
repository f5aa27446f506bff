"""Control law of the servo: estimate of the output tension, feed-forward and limits."""

from __future__ import annotations

import math

from tendon_mj.compilation import compiled

_STRAIGHT = 1e-6  # friction exponents below this are none


@compiled
def play(estimate: float, input_tension: float, exponent: float) -> float:
    """T̂_out ← clip(T̂_out, T_in e^{−λ}, T_in e^{λ}), the sheath seen from its input end [N]."""
    low, high = input_tension * math.exp(-exponent), input_tension * math.exp(exponent)
    return min(max(estimate, low), high)


@compiled
def stiffness_ahead(exponent: float, sense: float, tendon: float, output: float) -> float:
    """K_t(±λ) [N/m] of a tendon that slides, 1/K_t = 1/k_se + 1/K_ap.

    Args:
        exponent: |λ|.
        sense: its sign, +1 pulling.
        tendon: K_w = EA/L [N/m].
        output: k_se [N/m]; 0: not known, taken as rigid.
    """
    lam = sense * exponent
    apparent = tendon
    if exponent > _STRAIGHT:
        apparent = tendon * lam / math.expm1(lam)
    return apparent if output == 0.0 else 1.0 / (1.0 / output + 1.0 / apparent)


@compiled
def backlash_ahead(
    exponent: float, sense: float, tendon: float, input_tension: float, output_tension: float
) -> float:
    """Travel of the input that is left until the output follows in direction ``sense`` [m].

    The tendon once slid the other way; over the friction angle d from the input it slides this
    way already, e^{2sd} = e^{sλ} (T_in/T_out). What is left is the integral of the difference to a
    tendon that slides all along:
    Δξ = s (T_out (e^{sλ} + e^{−s(λ−d)} − 2) − T_in (1 − e^{−sd}))/(K_w λ),
    from the whole reversal backlash for d = 0 to nothing for d = λ.

    Args:
        exponent: λ ≥ 0.
        sense: s, +1 pulling.
        tendon: K_w = EA/L [N/m].
        input_tension, output_tension: T_in and T_out [N].
    """
    if not (exponent > _STRAIGHT and input_tension > 0.0 and output_tension > 0.0):
        return 0.0
    slid = 0.5 * (exponent + sense * math.log(input_tension / output_tension))
    slid = min(max(slid, 0.0), exponent)
    stretched = output_tension * (
        math.expm1(sense * exponent) + math.expm1(-sense * (exponent - slid))
    )
    return sense * (stretched + input_tension * math.expm1(-sense * slid)) / (tendon * exponent)


@compiled
def limited(
    torque: float, load: float, speed: float, inertia: float, h: float, top: float
) -> float:
    """Torque that, with ``load``, will not carry the motor beyond ``top`` (0: none) in a step."""
    if top == 0.0:
        return torque
    low, high = inertia * (-top - speed) / h, inertia * (top - speed) / h
    return min(max(torque + load, low), high) - load
