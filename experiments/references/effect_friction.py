"""Ratio of the tensions on the two sides of an element, at rest and sliding (Numba).

Equations: `experiments.references.effects`; docs/theory.md, section 5.
"""

from __future__ import annotations

import math
from typing import Any

import numba

from experiments.references.effect_system import EffectChain, Friction


@numba.njit(cache=True)
def set_ratios(
    friction: Friction, aged: float, displacement: float, speed: float, element: Any
) -> None:
    """Set T_high/T_low of an element that has passed ``displacement`` [m] of tendon.

    ``aged`` is max(0, 1 + β t) [–], ``speed`` the sliding speed w [m/s]; ``element`` is a record.
    """
    scale = aged * max(0.0, 1.0 + friction.gradient * displacement)
    extra = 0.0
    if friction.stribeck_friction > 0.0:
        extra = friction.stribeck_friction * math.exp(-speed / friction.stribeck_velocity)
    to_input, to_output = scale * (1.0 + friction.asymmetry), scale * (1.0 - friction.asymmetry)
    static, dynamic, angle = element.static, element.dynamic, element.angle
    element.sliding_to_input = math.exp((dynamic * to_input + extra) * angle)
    element.sliding_to_output = math.exp((dynamic * to_output + extra) * angle)
    element.static_to_input = element.sliding_to_input
    element.static_to_output = element.sliding_to_output
    if static > dynamic:
        element.static_to_input = math.exp((static * to_input + extra) * angle)
        element.static_to_output = math.exp((static * to_output + extra) * angle)
    element.frictionless = (
        element.static_to_input == 1.0
        and element.static_to_output == 1.0
        and element.constant == 0.0
    )


@numba.njit(cache=True)
def set_initial_ratios(chain: EffectChain) -> None:
    """Set the ratios of all elements at time 0 and at rest."""
    for i in range(chain.elements.size):
        set_ratios(chain.friction, 1.0, 0.0, 0.0, chain.elements[i])


@numba.njit(cache=True)
def predict_ratios(chain: EffectChain, time: float, h: float) -> None:
    """Set the ratios for ``time`` [s], as if the step h [s] repeated the increments before it."""
    friction = chain.friction
    aged = max(0.0, 1.0 + friction.drift * time)
    fade = -math.expm1(-h / friction.memory)
    for i in range(chain.elements.size):
        node, element = chain.nodes[i], chain.elements[i]
        speed = element.sliding_speed
        speed += (abs(node.increment) / h - speed) * fade
        set_ratios(friction, aged, node.displacement + node.increment, speed, element)
