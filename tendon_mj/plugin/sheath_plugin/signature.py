"""Signatures and seals: numbers that show that a state belongs to the model that it is used with.

`mjData.plugin_state` outlives its model: `MjSpec.recompile` hands an instance's numbers on to the
instance of the same name and size, `mj_setState` to whatever is at the same address. A state keeps
the two signatures that it was written with. Where that of the *configuration* differs, its
parameters are no longer the model's; where that of the *binding* differs, its indices are no longer
those of its tendon, joints, actuator and sensors, and must not be used.

A signature is made of h = Σ_k (w_k ⊕ w_k/2³²) c^k mod 2⁶⁴ over the words w_k of each text, of which
52 bits become a whole number from 2⁵² to 2⁵³. Within words and between texts bits are mixed: two
changes of the highest bits, such as those of signs, would cancel otherwise, as would one at the end
of a text and one at the beginning of the next. It depends on a model's content, not on its place in
memory.

To compute both for each state takes a fifth of a sheath's cost in a step. The first sheath of a
model therefore computes, whenever it is evaluated, one signature of all that those of sheaths and
sensors are made of. The others, evaluated after it, compare with that: a state is *sealed* with
this number, that of its instance, and the words that bind it. Where the seal is broken, the two
signatures decide. Indices are compared with the model's sizes each time, whatever the seal.
"""

from __future__ import annotations

import mujoco

from tendon_mj.native import apart, compiled
from tendon_mj.plugin.abi.layout import LAYOUT
from tendon_mj.plugin.abi.library import mj_id2name
from tendon_mj.plugin.abi.memory import byte, integer, plus, pointer, size, times, word
from tendon_mj.plugin.sheath_plugin.attributes import is_sheath
from tendon_mj.plugin.sheath_plugin.input_force import has_spring, is_constrained
from tendon_mj.plugin.sheath_plugin.state import (
    BOUND_BEGIN,
    BOUND_SIZE,
    State,
    fits,
    path_counts,
    state_at,
    state_of,
    state_size_of,
)

_OBJ = mujoco.mjtObj
_JOINT, _TENDON = _OBJ.mjOBJ_JOINT.value, _OBJ.mjOBJ_TENDON.value
_PLUGIN = _OBJ.mjOBJ_PLUGIN.value
_FACTOR = -7046029254386353131  # 2⁶⁴ divided by the golden ratio, as an int64
_FACTOR_2, _FACTOR_3, _FACTOR_4 = (  # its powers, as int64s
    (_FACTOR**k + 2**63) % 2**64 - 2**63 for k in (2, 3, 4)
)
_MIXER = -4417276706812531889
_BITS = (1 << 52) - 1
_HALF = (1 << 32) - 1
_LEAST = 1 << 52  # from which every double, up to twice that, is a whole number
NONE = 0.0  # of a state that does not belong to the model


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
def hashed_name(m: int, kind: int, index: int) -> int:
    """h of an element's name, 0 without one."""
    name = mj_id2name(m, kind, index)
    if name == 0:
        return 0
    count = 0
    while byte(name, count) != 0:
        count += 1
    return hashed(name, count)


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
def _sizes(m: int, instance: int) -> int:
    """h of an instance's number and of the sizes that bound indices."""
    h = mixed(instance, size(m + LAYOUT.m_nplugin))
    h = mixed(h, size(m + LAYOUT.m_ntendon))
    h = mixed(h, size(m + LAYOUT.m_njnt))
    h = mixed(h, size(m + LAYOUT.m_nactuator))
    return mixed(h, size(m + LAYOUT.m_nsensor))


@compiled
def _owns(owners: int, index: float, count: int, instance: int) -> bool:
    """Whether an index is −1 or that of an element that belongs to an instance."""
    if index == -1.0:
        return True
    return 0.0 <= index < count and integer(owners, int(index)) == instance


@compiled
def _attached(m: int, instance: int, state: State) -> float:
    """Signature of a sheath's tendon, joints, reel and sensors, `NONE` for an index of none."""
    tendon, sensors = state.tendon, (state.first_sensor, state.last_sensor)
    if not 0.0 <= tendon < size(m + LAYOUT.m_ntendon):
        return NONE
    actuators, shown = pointer(m + LAYOUT.m_actuator_plugin), pointer(m + LAYOUT.m_sensor_plugin)
    if not _owns(actuators, state.reel_actuator, size(m + LAYOUT.m_nactuator), instance):
        return NONE
    if sensors[1] != -1.0:
        total = size(m + LAYOUT.m_nsensor)
        for sensor in sensors:
            if not _owns(shown, sensor, total, instance) or sensor == -1.0:
                return NONE
    h = mixed(_sizes(m, instance), hashed_name(m, _TENDON, int(tendon)))
    h = mixed(h, integer(pointer(m + LAYOUT.m_tendon_num), int(tendon)))
    for joint in (state.reel_joint, state.output_joint):
        named = 0
        if joint != -1.0:
            if not 0.0 <= joint < size(m + LAYOUT.m_njnt):
                return NONE
            named = hashed_name(m, _JOINT, int(joint))
        h = mixed(h, named)
    return as_number(h)


@compiled
def _with_index(h: int, index: float, count: int) -> int:
    """h with an index that is −1 or below ``count``; where it is neither, with none."""
    return mixed(h, int(index) + 1 if -1.0 <= index < count else count + 1)


@apart
def binding_signature(m: int, instance: int, address: int) -> float:
    """Signature of all that the state of a sheath is bound to, whatever it holds, or `NONE`.

    That is the elements it is attached to, the counts on its path, and the forces on tendons.
    """
    state, actuators = state_at(address), size(m + LAYOUT.m_nactuator)
    number, state_size = _attached(m, instance, state), state_size_of(m, instance)
    if number == NONE or not fits(address, state_size):
        return NONE
    h, tendon = int(number), int(state.tendon)
    for count in path_counts(state):
        h = _with_index(h, count, state_size)
    for flag in (state.driven, state.leads, state.own_spring, state.constrained):
        h = _with_index(h, flag, state_size)
    first = integer(pointer(m + LAYOUT.m_tendon_adr), tendon)
    path = 4 * integer(pointer(m + LAYOUT.m_tendon_num), tendon)
    h = mixed(h, hashed(pointer(m + LAYOUT.m_wrap_type) + 4 * first, path))
    if state.pulleys > 0.0:  # which branch feeds which follows from the sites
        h = mixed(h, hashed(pointer(m + LAYOUT.m_wrap_objid) + 4 * first, path))
    if state.reel_joint == -1.0 and state.output_joint == -1.0 and state.reel_actuator == -1.0:
        ends = state.first_actuator, state.last_actuator
        for end in ends:
            if not -1.0 <= end < actuators:
                return NONE
            h = _with_index(h, end, actuators)
        h = mixed(h, hashed(pointer(m + LAYOUT.m_actuator_trntype), 4 * actuators))
        h = mixed(h, hashed(pointer(m + LAYOUT.m_actuator_trnid), 8 * actuators))
        if ends[0] == -1.0:
            h = mixed(h, int(has_spring(m, tendon)))
        h = mixed(h, int(is_constrained(m, tendon)))
    return as_number(h)


@compiled
def pair_signature(m: int, instance: int, other: int) -> float:
    """Signature of the attributes of an instance and of another that it depends on, −1 for none."""
    h = _configured(m, instance)
    return as_number(mixed(h, _configured(m, other) if other >= 0 else 0))


@compiled
def servo_signature(m: int, instance: int, sheath: int, actuator: float) -> float:
    """Signature of a servo's sheath, −1 for none, and actuator, or `NONE`."""
    actuators = pointer(m + LAYOUT.m_actuator_plugin)
    if not _owns(actuators, actuator, size(m + LAYOUT.m_nactuator), instance):
        return NONE
    h = mixed(_sizes(m, instance), sheath)
    if sheath >= 0:
        h = mixed(h, hashed_name(m, _PLUGIN, sheath))
    return as_number(h)


@apart
def model_signature(m: int) -> float:
    """Signature of all that the binding signatures of a model's sheaths and sensors depend on."""
    tendons, joints = size(m + LAYOUT.m_ntendon), size(m + LAYOUT.m_njnt)
    actuators, sensors = size(m + LAYOUT.m_nactuator), size(m + LAYOUT.m_nsensor)
    equalities = size(m + LAYOUT.m_neq)
    instances, elements = size(m + LAYOUT.m_nplugin), size(m + LAYOUT.m_nwrap)
    h = joints
    for start, count in (
        (m + LAYOUT.m_plugin, 4 * instances),
        (m + LAYOUT.m_plugin_statenum, 4 * instances),
        (m + LAYOUT.m_plugin_stateadr, 4 * instances),
        (m + LAYOUT.m_plugin_attradr, 4 * instances),
        (m + LAYOUT.m_plugin_attr, size(m + LAYOUT.m_npluginattr)),
        (m + LAYOUT.m_tendon_adr, 4 * tendons),
        (m + LAYOUT.m_tendon_num, 4 * tendons),
        (m + LAYOUT.m_wrap_type, 4 * elements),
        (m + LAYOUT.m_wrap_objid, 4 * elements),
        (m + LAYOUT.m_tendon_limited, tendons),
        (m + LAYOUT.m_eq_type, 4 * equalities),
        (m + LAYOUT.m_eq_obj1id, 4 * equalities),
        (m + LAYOUT.m_eq_obj2id, 4 * equalities),
        (m + LAYOUT.m_actuator_trntype, 4 * actuators),
        (m + LAYOUT.m_actuator_trnid, 8 * actuators),
        (m + LAYOUT.m_actuator_plugin, 4 * actuators),
        (m + LAYOUT.m_sensor_plugin, 4 * sensors),
        (m + LAYOUT.m_sensor_objtype, 4 * sensors),
        (m + LAYOUT.m_sensor_objid, 4 * sensors),
        (m + LAYOUT.m_sensor_dim, 4 * sensors),
    ):
        h = mixed(h, hashed(pointer(start), count))
    names = pointer(m + LAYOUT.m_names)
    first = integer(pointer(m + LAYOUT.m_name_tendonadr), 0)
    h = mixed(h, hashed(names + first, size(m + LAYOUT.m_nnames) - first))
    if joints > 0:  # but for the last their names lie in a row
        starts = pointer(m + LAYOUT.m_name_jntadr)
        first, last = integer(starts, 0), integer(starts, joints - 1)
        h = mixed(h, hashed(names + first, last - first))
        h = mixed(h, hashed_name(m, _JOINT, joints - 1))
    for tendon in range(tendons):
        h = mixed(h, int(has_spring(m, tendon)))
    return as_number(h)


@compiled
def signature_by(m: int, d: int, first: float, instance: int) -> float:
    """Model signature that the first sheath keeps, `NONE` where ``first`` is not that."""
    if not (0.0 <= first < size(m + LAYOUT.m_nplugin) and is_sheath(m, int(first), instance)):
        return NONE
    state = state_at(state_of(m, d, int(first)))
    return state.model_signature if state.first_sheath == first else NONE


@compiled
def _sheath_seal(m: int, d: int, instance: int) -> float:
    """Seal of a sheath's state as it is now, `NONE` where it cannot have one."""
    address = state_of(m, d, instance)
    first = state_at(address).first_sheath
    signature = signature_by(m, d, first, instance)
    if first > instance or not is_signature(signature):
        return NONE
    h = mixed(hashed(address + BOUND_BEGIN, BOUND_SIZE), int(signature))
    return as_number(mixed(h, instance))


@compiled
def _is_index(number: float, count: int) -> bool:
    """Whether a number is −1 or an index below ``count``."""
    return -1.0 <= number < count


@compiled
def _has_indices(m: int, address: int) -> bool:
    """Whether the indices in a sheath's state are in range."""
    state = state_at(address)
    joints, actuators = size(m + LAYOUT.m_njnt), size(m + LAYOUT.m_nactuator)
    return (
        0.0 <= state.tendon < size(m + LAYOUT.m_ntendon)
        and _is_index(state.reel_joint, joints)
        and _is_index(state.output_joint, joints)
        and _is_index(state.reel_actuator, actuators)
        and _is_index(state.first_actuator, actuators)
        and _is_index(state.last_actuator, actuators)
    )


@compiled
def is_sealed(m: int, d: int, instance: int) -> bool:
    """Whether the seal of a sheath is unbroken and its indices are in range."""
    address = state_of(m, d, instance)
    seal = _sheath_seal(m, d, instance)
    if seal == NONE or seal != state_at(address).seal:
        return False
    return fits(address, state_size_of(m, instance)) and _has_indices(m, address)


@compiled
def renew_signature(m: int, d: int, instance: int) -> None:
    """Compute the model's signature again, if the sheath is its first."""
    state = state_at(state_of(m, d, instance))
    if state.first_sheath == instance:
        state.model_signature = model_signature(m)


@apart
def seal_sheath(m: int, d: int, instance: int) -> None:
    """Seal the state of a sheath that is proven to be bound."""
    state = state_at(state_of(m, d, instance))
    first = 0
    while not is_sheath(m, first, instance):
        first += 1
    state.first_sheath = first
    renew_signature(m, d, instance)
    state.seal = _sheath_seal(m, d, instance)
