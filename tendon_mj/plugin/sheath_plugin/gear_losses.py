"""Friction of cables that pull either way, and of the gear and the servo in front of them."""

from __future__ import annotations

import math

from tendon_mj.native import compiled
from tendon_mj.plugin.sheath_plugin.groups import Group


@compiled
def set_gear(group: Group, friction: float, friction_back: float) -> None:
    """Set the efficiencies of a gear by its friction over the load behind it."""
    group.forward = 1.0 / (1.0 + friction)
    passed = 1.0 - (friction_back if friction_back > 0.0 else friction)
    group.back = 1.0 / passed if passed != 0.0 else math.inf


@compiled
def _behind(group: Group, gear: float, side: float, tension: float, eases: float) -> float:
    """Friction of servo, gear of one ratio and cables, at its bound above (``side`` 1) or below."""
    bound, servo = -math.inf, max(0.0, group.servo)
    tension += side * (1.0 - eases) * servo
    for k in range(3):
        ratio, offset = 1.0, group.least
        if k == 1:
            ratio, offset = group.upper_ratio, group.upper_offset
        elif k == 2:
            ratio, offset = 1.0 + group.fall, group.fall_offset
        slope = gear * ratio - 1.0
        friction = (slope * tension + side * offset) / max(1e-3, 1.0 + eases * slope)
        bound = max(bound, side * friction)
    return side * (bound + servo)


@compiled
def friction_of_cables(group: Group, tension: float, eases: float) -> tuple[float, float]:
    """Least and largest friction of cables that pull either way, and of their gear and servo.

    A gear that locks itself holds all that would drive it, and a load that `jams` it.
    """
    low = _behind(group, group.forward, -1.0, tension, eases)
    high = _behind(group, group.forward, 1.0, tension, eases)
    if group.back == group.forward:  # no gear
        return low, high
    if 0.0 < group.back < math.inf:
        low = min(low, _behind(group, group.back, -1.0, tension, eases))
        return low, max(high, _behind(group, group.back, 1.0, tension, eases))
    if tension == 0.0:
        return -math.inf, math.inf
    side = 1.0 if tension > 0.0 else -1.0
    if group.jams != 0.0:
        jam = _behind(group, group.back, side, tension, eases)
        return (-math.inf, jam) if side > 0.0 else (jam, math.inf)
    return (low, math.inf) if side > 0.0 else (-math.inf, high)


@compiled
def jams(group: Group, tension: float, still: float, stopping: float) -> bool:
    """Return whether a gear that locks itself holds a load that the motor turns to release.

    ``still`` is the friction with which nothing would be accelerated, ``stopping`` that which ends
    the motion at hand: one that the motor brakes does not jam the gear.
    """
    if not group.back < 0.0 or tension == 0.0:
        return False
    side = 1.0 if tension > 0.0 else -1.0
    jam = _behind(group, group.back, side, tension, 0.0)
    releases = side * (tension + still) <= 0.0
    return releases and side * still <= side * jam and side * stopping <= side * jam
