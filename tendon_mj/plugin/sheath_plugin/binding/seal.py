"""Seals: the short proof that a state still belongs to its model.

The signatures of each state are proof enough, but to compute them for each takes a fifth of what a
sheath costs in a step. The first sheath of a model therefore computes, whenever it is evaluated,
one signature of all that those of sheaths and sensors are made of. The others, evaluated after it,
compare with that. A state is sealed with this number, that of its instance, and the words that bind
it, so that a word which is not as it was breaks the seal. Then the long proof decides. What is used
as an index is compared with the model's sizes each time, whatever the seal.
"""

from __future__ import annotations

import mujoco

from tendon_mj.compilation import apart, compiled
from tendon_mj.plugin.abi.layout import Layout
from tendon_mj.plugin.abi.memory import integer, pointer, size
from tendon_mj.plugin.sheath_plugin.attributes import is_sensor
from tendon_mj.plugin.sheath_plugin.binding.signature import (
    NONE,
    as_number,
    hashed,
    hashed_name,
    is_signature,
    mixed,
)
from tendon_mj.plugin.sheath_plugin.input_force import has_spring
from tendon_mj.plugin.sheath_plugin.state import (
    BOUND_BEGIN,
    BOUND_SIZE,
    fits,
    state_at,
    state_of,
    state_size_of,
)

_JOINT = mujoco.mjtObj.mjOBJ_JOINT.value


@apart
def model_signature(layout: Layout, m: int) -> float:
    """Signature of all that the signatures of a model's sheaths and sensors are made of."""
    tendons, joints = size(m + layout.m_ntendon), size(m + layout.m_njnt)
    actuators, sensors = size(m + layout.m_nactuator), size(m + layout.m_nsensor)
    equalities = size(m + layout.m_neq)
    instances, elements = size(m + layout.m_nplugin), size(m + layout.m_nwrap)
    h = joints
    for start, count in (
        (m + layout.m_plugin, 4 * instances),
        (m + layout.m_plugin_statenum, 4 * instances),
        (m + layout.m_plugin_stateadr, 4 * instances),
        (m + layout.m_plugin_attradr, 4 * instances),
        (m + layout.m_plugin_attr, size(m + layout.m_npluginattr)),
        (m + layout.m_tendon_adr, 4 * tendons),
        (m + layout.m_tendon_num, 4 * tendons),
        (m + layout.m_wrap_type, 4 * elements),
        (m + layout.m_wrap_objid, 4 * elements),
        (m + layout.m_tendon_limited, tendons),
        (m + layout.m_eq_type, 4 * equalities),
        (m + layout.m_eq_obj1id, 4 * equalities),
        (m + layout.m_eq_obj2id, 4 * equalities),
        (m + layout.m_actuator_trntype, 4 * actuators),
        (m + layout.m_actuator_trnid, 8 * actuators),
        (m + layout.m_actuator_plugin, 4 * actuators),
        (m + layout.m_sensor_plugin, 4 * sensors),
        (m + layout.m_sensor_objtype, 4 * sensors),
        (m + layout.m_sensor_objid, 4 * sensors),
        (m + layout.m_sensor_dim, 4 * sensors),
    ):
        h = mixed(h, hashed(pointer(start), count))
    names = pointer(m + layout.m_names)
    first = integer(pointer(m + layout.m_name_tendonadr), 0)
    h = mixed(h, hashed(names + first, size(m + layout.m_nnames) - first))
    if joints > 0:  # but for the last their names lie in a row
        starts = pointer(m + layout.m_name_jntadr)
        first, last = integer(starts, 0), integer(starts, joints - 1)
        h = mixed(h, hashed(names + first, last - first))
        h = mixed(h, hashed_name(m, _JOINT, joints - 1))
    for tendon in range(tendons):
        h = mixed(h, int(has_spring(layout, m, tendon)))
    return as_number(h)


@compiled
def is_sheath(layout: Layout, m: int, other: int, instance: int) -> bool:
    """Whether an instance is a sheath, as ``instance`` is one or shows one."""
    slots = pointer(m + layout.m_plugin)
    return integer(slots, other) == integer(slots, instance) and not is_sensor(layout, m, other)


@compiled
def signature_by(layout: Layout, m: int, d: int, first: float, instance: int) -> float:
    """Signature that the first sheath has computed for ``instance``, `NONE` if it is not that."""
    if not 0.0 <= first < size(m + layout.m_nplugin):
        return NONE
    if not is_sheath(layout, m, int(first), instance):
        return NONE
    state = state_at(state_of(layout, m, d, int(first)))
    return state.model_signature if state.first_sheath == first else NONE


@compiled
def _sheath_seal(layout: Layout, m: int, d: int, instance: int) -> float:
    """The seal of a sheath's state as it now is, `NONE` where it cannot have one."""
    address = state_of(layout, m, d, instance)
    first = state_at(address).first_sheath
    signature = signature_by(layout, m, d, first, instance)
    if first > instance or not is_signature(signature):
        return NONE
    h = mixed(hashed(address + BOUND_BEGIN, BOUND_SIZE), int(signature))
    return as_number(mixed(h, instance))


@compiled
def _is_index(number: float, count: int) -> bool:
    """Whether a number is −1 or an index below ``count``."""
    return -1.0 <= number < count


@compiled
def _has_indices(layout: Layout, m: int, address: int) -> bool:
    """Whether what a sheath's state has as indices are some of this model."""
    state = state_at(address)
    joints, actuators = size(m + layout.m_njnt), size(m + layout.m_nactuator)
    return (
        0.0 <= state.tendon < size(m + layout.m_ntendon)
        and _is_index(state.reel_joint, joints)
        and _is_index(state.output_joint, joints)
        and _is_index(state.reel_actuator, actuators)
        and _is_index(state.first_actuator, actuators)
        and _is_index(state.last_actuator, actuators)
    )


@compiled
def is_sealed(layout: Layout, m: int, d: int, instance: int) -> bool:
    """Whether the seal of a sheath is whole."""
    address = state_of(layout, m, d, instance)
    seal = _sheath_seal(layout, m, d, instance)
    if seal == NONE or seal != state_at(address).seal:
        return False
    return fits(address, state_size_of(layout, m, instance)) and _has_indices(layout, m, address)


@compiled
def renew_signature(layout: Layout, m: int, d: int, instance: int) -> None:
    """Compute the model's signature anew, if the sheath is its first."""
    state = state_at(state_of(layout, m, d, instance))
    if state.first_sheath == instance:
        state.model_signature = model_signature(layout, m)


@apart
def seal_sheath(layout: Layout, m: int, d: int, instance: int) -> None:
    """Seal the state of a sheath that is proven to be bound."""
    state = state_at(state_of(layout, m, d, instance))
    first = 0
    while not is_sheath(layout, m, first, instance):
        first += 1
    state.first_sheath = first
    renew_signature(layout, m, d, instance)
    state.seal = _sheath_seal(layout, m, d, instance)
