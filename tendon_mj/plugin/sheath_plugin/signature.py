"""Signatures: numbers that differ where what a sheath was bound to, or configured by, differs.

A signature is made of h = Σ_k (w_k ⊕ w_k/2³²) c^k mod 2⁶⁴ over the words w_k of each text, of which
52 bits become a whole number from 2⁵² to 2⁵³. Within words and between texts bits are mixed: two
changes of the highest bits, such as those of signs, would cancel otherwise, as would one at the end
of a text and one at the beginning of the next.
"""

from __future__ import annotations

from tendon_mj.native import apart, compiled
from tendon_mj.plugin.abi.layout import LAYOUT
from tendon_mj.plugin.abi.memory import (
    address_of,
    byte,
    double,
    integer,
    plus,
    pointer,
    size,
    times,
    word,
)
from tendon_mj.plugin.sheath_plugin.input_force import has_spring

_FACTOR = -7046029254386353131  # 2⁶⁴ divided by the golden ratio, as an int64
_FACTOR_2, _FACTOR_3, _FACTOR_4 = (  # its powers, as int64s
    (_FACTOR**k + 2**63) % 2**64 - 2**63 for k in (2, 3, 4)
)
_GOLDEN = 0.6180339887498949  # multiples of which are spread evenly mod 1
_MIXER = -4417276706812531889
_BITS = (1 << 52) - 1
_HALF = (1 << 32) - 1
_LEAST = 1 << 52  # from which every double, up to twice that, is a whole number


@compiled
def _folded(w: int) -> int:
    """A word with its upper half in the lower one too."""
    return w ^ ((w >> 32) & _HALF)


@compiled
def mixed(h: int, more: int) -> int:
    """h of a text and, after it, of ``more``."""
    return plus(times(_folded(h), _MIXER), more)


@compiled
def _weighed(text: int, power: int, factor: int) -> int:
    """Share of the word at ``text`` in h."""
    return times(_folded(word(text)), times(power, factor))


@compiled
def hashed(text: int, count: int) -> int:
    """h of ``count`` bytes, by words that do not wait for each other."""
    total, power = times(count, _MIXER), 1
    start = 0
    while start + 32 <= count:
        one = plus(_weighed(text + start, power, _FACTOR), total)
        two = _weighed(text + start + 8, power, _FACTOR_2)
        three = _weighed(text + start + 16, power, _FACTOR_3)
        four = _weighed(text + start + 24, power, _FACTOR_4)
        total = plus(plus(one, two), plus(three, four))
        power = times(power, _FACTOR_4)
        start += 32
    while start + 8 <= count:
        total = plus(total, _weighed(text + start, power, _FACTOR))
        power = times(power, _FACTOR)
        start += 8
    if start < count and count >= 8:  # the last word overlaps the one before
        return plus(total, _weighed(text + count - 8, power, _FACTOR))
    for k in range(start, count):
        power = times(power, _FACTOR)
        total = plus(total, times(byte(text, k), power))
    return total


@compiled
def as_number(h: int) -> float:
    """The whole number that stands for h."""
    h = mixed(mixed(h, 0), 0)
    return float((_folded(h) & _BITS) + _LEAST)


@compiled
def is_signature(number: float) -> bool:
    """Whether a number can be a signature."""
    return _LEAST <= number <= _LEAST + _BITS


@compiled
def _configured(m: int, instance: int) -> int:
    """h of the attributes of an instance."""
    starts = pointer(m + LAYOUT.m_plugin_attradr)
    start = integer(starts, instance)
    end = size(m + LAYOUT.m_npluginattr)
    if instance + 1 < size(m + LAYOUT.m_nplugin):
        end = integer(starts, instance + 1)
    return hashed(pointer(m + LAYOUT.m_plugin_attr) + start, end - start)


@compiled
def config_signature(m: int, instance: int) -> float:
    """Signature of the attributes of an instance, numbers and names as they are written."""
    return as_number(_configured(m, instance))


@compiled
def pair_signature(m: int, instance: int, other: int) -> float:
    """Signature of the attributes of an instance and of another that it depends on, −1 for none."""
    h = _configured(m, instance)
    return as_number(mixed(h, _configured(m, other) if other >= 0 else 0))


@apart
def model_signature(m: int) -> float:
    """Signature of what decides, in a model, on what its sheaths, sensors and servos act.

    That is its configurations and names, as another model may take its place in memory, and the
    numbers of it that programs may write while it is simulated: which site or geom a tendon runs
    over, what acts on it, what is shown.
    """
    tendons, equalities = size(m + LAYOUT.m_ntendon), size(m + LAYOUT.m_neq)
    actuators = size(m + LAYOUT.m_nactuator)
    names = pointer(m + LAYOUT.m_names)
    first = integer(pointer(m + LAYOUT.m_name_tendonadr), 0)
    h = mixed(address_of(m), hashed(names + first, size(m + LAYOUT.m_nnames) - first))
    if size(m + LAYOUT.m_njnt) > 0:
        first = integer(pointer(m + LAYOUT.m_name_jntadr), 0)
        last = integer(pointer(m + LAYOUT.m_name_jntadr), size(m + LAYOUT.m_njnt) - 1)
        h = mixed(h, hashed(names + first, last - first + 1))
    for start, count in (
        (m + LAYOUT.m_plugin_attr, size(m + LAYOUT.m_npluginattr)),
        (m + LAYOUT.m_wrap_objid, 4 * size(m + LAYOUT.m_nwrap)),
        (m + LAYOUT.m_tendon_limited, tendons),
        (m + LAYOUT.m_eq_obj1id, 4 * equalities),
        (m + LAYOUT.m_eq_obj2id, 4 * equalities),
        (m + LAYOUT.m_actuator_trntype, 4 * actuators),
        (m + LAYOUT.m_actuator_trnid, 8 * actuators),
        (m + LAYOUT.m_sensor_objid, 4 * size(m + LAYOUT.m_nsensor)),
    ):
        h = mixed(h, hashed(pointer(start), count))
    for tendon in range(tendons):
        h = mixed(h, int(has_spring(m, tendon)))
    return as_number(h)


@compiled
def _weighted_sum(numbers: int, count: int, fraction: float) -> float:
    """Sum of numbers, each with another weight between 1 and 2."""
    total = 0.0
    for k in range(count):
        fraction += _GOLDEN
        if fraction >= 1.0:
            fraction -= 1.0
        total += (1.0 + fraction) * double(numbers, k)
    return total


@compiled
def pose_sum(m: int, d: int) -> float:
    """Weighted sum of positions and velocities, by which a state can tell that one was written."""
    positions = _weighted_sum(pointer(d + LAYOUT.d_qpos), size(m + LAYOUT.m_nq), 0.0)
    return positions + _weighted_sum(pointer(d + LAYOUT.d_qvel), size(m + LAYOUT.m_nv), 0.5)


@compiled
def pose_signature(m: int, d: int) -> float:
    """Signature of time, positions and velocities."""
    h = mixed(
        hashed(d + LAYOUT.d_time, 8), hashed(pointer(d + LAYOUT.d_qpos), 8 * size(m + LAYOUT.m_nq))
    )
    return as_number(mixed(h, hashed(pointer(d + LAYOUT.d_qvel), 8 * size(m + LAYOUT.m_nv))))
