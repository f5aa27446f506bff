"""What tension a group of guides can hold behind it, by the capstan law:

    (T_in − c)/e^{λ} ≤ T_out ≤ T_in e^{λ} + c

with λ the exponents μφ of its guides, and c their constant friction.
"""

from __future__ import annotations

import math

from tendon_mj.native import compiled
from tendon_mj.plugin.sheath_plugin.gear_losses import friction_of_cables
from tendon_mj.plugin.sheath_plugin.groups import Group
from tendon_mj.sheath import Guide, Guides


@compiled
def towards_output(guide: Guide, unit: float, slides: bool) -> tuple[float, float]:
    """Ratio and offset of the largest tension behind a guide."""
    ratio = guide.dynamic_ratio_back if slides else guide.static_ratio_back
    return ratio, unit * guide.constant_friction


@compiled
def towards_input(guide: Guide, unit: float, slides: bool) -> tuple[float, float]:
    """Ratio and offset of the largest tension in front of a guide."""
    return guide.dynamic_ratio if slides else guide.static_ratio, unit * guide.constant_friction


@compiled
def set_bounds(group: Group, guides: Guides) -> None:
    """Combine the bounds of a group's guides; at rest, those of static friction."""
    upper, more, lower, less = 1.0, 0.0, 1.0, 0.0
    static, slides = False, group.slides
    both = group.pretension >= 0.0 and slides != 0.0  # one of two cables slides either way
    for i in range(int(group.begin), int(group.end)):
        guide = guides[i]
        ratio, offset = towards_output(guide, group.divisor, both or slides > 0.0)
        upper, more = upper * ratio, more * ratio + offset
        ratio, offset = towards_input(guide, group.divisor, both or slides < 0.0)
        lower, less = lower * ratio, less + offset * lower
        static |= guide.static_ratio != guide.dynamic_ratio
    group.upper_ratio, group.upper_offset = upper, more
    group.lower_ratio, group.lower_offset = lower, less
    group.fall, group.fall_offset = 1.0 / lower - 1.0, less / lower
    group.is_static, group.is_set_for = static, group.slides
    group.is_rough = upper > 1.0 or more > 0.0 or lower > 1.0
    if group.pretension >= 0.0:
        group.is_rough += group.forward != 1.0 or group.back != 1.0 or group.servo >= 0.0
        of_both = min(less, group.pretension)  # nor does the other lose more than its tension
        group.least = more + of_both + group.pretension * (math.log(upper) + math.log(lower))


@compiled
def tensions_behind(group: Group, tension: float) -> tuple[float, float]:
    """Least and largest tension behind a group under one in front of it [N]."""
    if group.pretension >= 0.0:
        low, high = friction_of_cables(group, tension, 0.0)
        return tension + low, tension + high
    low = max(0.0, (tension - group.lower_offset) / group.lower_ratio)
    return low, group.upper_ratio * tension + group.upper_offset
