"""Signatures: numbers that differ where what a sheath was bound to, or configured by, differs.

A signature is made of h = Σ_k (w_k ⊕ w_k/2³²) c^k mod 2⁶⁴ over the words w_k of each text, of which
52 bits become a whole number from 2⁵² to 2⁵³. Within words and between texts bits are mixed: two
changes of the highest bits, such as those of signs, would cancel otherwise, as would one at the end
of a text and one at the beginning of the next.
"""

from __future__ import annotations

from tendon_mj.native import LocalDoubles, apart, compiled
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.abi.memory import address_of, coordinates, letters, plus, times, word
from tendon_mj.plugin.sheath_plugin.input_force import has_spring
from tendon_mj.typing import FloatArray

_FACTOR = -7046029254386353131  # 2⁶⁴ divided by the golden ratio, as an int64
_FACTOR_2, _FACTOR_3, _FACTOR_4 = (  # its powers, as int64s
    (_FACTOR**k + 2**63) % 2**64 - 2**63 for k in (2, 3, 4)
)
_GOLDEN = 0.6180339887498949  # multiples of which are spread evenly mod 1
_MIXER = -4417276706812531889
_BITS = (1 << 52) - 1
_HALF = (1 << 32) - 1
_time = LocalDoubles(1)
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
        total = plus(total, times(letters(text)[k], power))
    return total


@compiled
def as_number(h: int) -> float:
    """The whole number that stands for h."""
    h = mixed(mixed(h, 0), 0)
    return float((_folded(h) & _BITS) + _LEAST)


@compiled
def is_signature(number: float) -> bool:
    """Return whether a number can be a signature."""
    return _LEAST <= number <= _LEAST + _BITS


@compiled
def _configured(m: Model, instance: int) -> int:
    """h of the attributes of an instance."""
    start, end = m.plugin_attradr[instance], m.npluginattr
    if instance + 1 < m.nplugin:
        end = m.plugin_attradr[instance + 1]
    return hashed(address_of(m.plugin_attr) + start, end - start)


@compiled
def config_signature(m: Model, instance: int) -> float:
    """Signature of the attributes of an instance, numbers and names as they are written."""
    return as_number(_configured(m, instance))


@compiled
def pair_signature(m: Model, instance: int, other: int) -> float:
    """Signature of the attributes of an instance and of another that it depends on, −1 for none."""
    h = _configured(m, instance)
    return as_number(mixed(h, _configured(m, other) if other >= 0 else 0))


@apart
def model_signature(m: Model) -> float:
    """Signature of what decides, in a model, on what its sheaths, sensors and servos act.

    That is its configurations and names, as another model may take its place in memory, and the
    numbers of it that programs may write while it is simulated: which site or geom a tendon runs
    over, what acts on it, what is shown.
    """
    names = address_of(m.names)
    first = m.name_tendonadr[0]
    h = mixed(address_of(m), hashed(names + first, m.nnames - first))
    if m.njnt > 0:
        first = m.name_jntadr[0]
        last = m.name_jntadr[m.njnt - 1]
        h = mixed(h, hashed(names + first, last - first + 1))
    for start, count in (
        (address_of(m.plugin_attr), m.npluginattr),
        (address_of(m.wrap_objid), 4 * m.nwrap),
        (address_of(m.tendon_limited), m.ntendon),
        (address_of(m.eq_obj1id), 4 * m.neq),
        (address_of(m.eq_obj2id), 4 * m.neq),
        (address_of(m.actuator_trntype), 4 * m.nactuator),
        (address_of(m.actuator_trnid), 8 * m.nactuator),
        (address_of(m.sensor_objid), 4 * m.nsensor),
    ):
        h = mixed(h, hashed(start, count))
    for tendon in range(m.ntendon):
        h = mixed(h, int(has_spring(m, tendon)))
    return as_number(h)


@compiled
def _weighted_sum(numbers: FloatArray, count: int, fraction: float) -> float:
    """Sum of numbers, each with another weight between 1 and 2."""
    total = 0.0
    for k in range(count):
        fraction += _GOLDEN
        if fraction >= 1.0:
            fraction -= 1.0
        total += (1.0 + fraction) * numbers[k]
    return total


@compiled
def pose_sum(m: Model, d: Data) -> float:
    """Weighted sum of positions and velocities, by which a state can tell that one was written."""
    positions = _weighted_sum(d.qpos, m.nq, 0.0)
    return positions + _weighted_sum(d.qvel, m.nv, 0.5)


@compiled
def pose_signature(m: Model, d: Data) -> float:
    """Signature of time, positions and velocities."""
    time = _time()
    coordinates(time)[0] = d.time
    h = mixed(hashed(time, 8), hashed(address_of(d.qpos), 8 * m.nq))
    return as_number(mixed(h, hashed(address_of(d.qvel), 8 * m.nv)))
