"""Binding of an instance with `sensor` to the sheaths that its sensors show.

One whose configuration names a tendon shows the sheath on that; of another each sensor says by its
object on which tendon. The state holds only what is in the model and in the states of the sheaths,
so where its seal is broken it is found anew.
"""

from __future__ import annotations

import mujoco

from tendon_mj.compilation import apart, compiled
from tendon_mj.plugin.abi.layout import Layout
from tendon_mj.plugin.abi.memory import byte, doubles, integer, pointer, size
from tendon_mj.plugin.sheath_plugin import attributes as at
from tendon_mj.plugin.sheath_plugin.binding.bind import is_bound, range_of
from tendon_mj.plugin.sheath_plugin.binding.own_names import resolve
from tendon_mj.plugin.sheath_plugin.binding.seal import is_sheath, signature_by
from tendon_mj.plugin.sheath_plugin.binding.signature import (
    NONE,
    as_number,
    hashed,
    is_signature,
    mixed,
)
from tendon_mj.plugin.sheath_plugin.state import (
    sensor_state_at,
    shown_at,
    state_at,
    state_of,
    state_size_of,
)

_TENDON = mujoco.mjtObj.mjOBJ_TENDON.value


@apart
def reset_sensor(layout: Layout, m: int, address: int, instance: int) -> None:
    """Forget what the sensors show: the states of the sheaths may not be there yet."""
    doubles(address, state_size_of(layout, m, instance))[:] = 0.0


@compiled
def _seal(layout: Layout, m: int, d: int, instance: int) -> float:
    """The seal of the state as it now is, `NONE` where it cannot have one."""
    address = state_of(layout, m, d, instance)
    first = sensor_state_at(address).first_sheath
    signature = signature_by(layout, m, d, first, instance)
    if not is_signature(signature):
        return NONE
    h = hashed(address + 8, 8 * (state_size_of(layout, m, instance) - 1))
    return as_number(mixed(mixed(h, int(signature)), instance))


@apart
def _find_shown(layout: Layout, m: int, d: int, instance: int) -> None:
    """Find the sheath that each sensor of the instance shows."""
    address = state_of(layout, m, d, instance)
    state, shown = sensor_state_at(address), shown_at(address, state_size_of(layout, m, instance))
    owners, objects = pointer(m + layout.m_sensor_plugin), pointer(m + layout.m_sensor_objid)
    types = pointer(m + layout.m_sensor_objtype)
    first, last = range_of(owners, size(m + layout.m_nsensor), instance)
    state.first_sensor, state.last_sensor = first, last
    state.kind = at.sensor_kind_at(at.text_at(layout, m, instance, at.SENSOR))
    state.is_of_one = byte(at.text_at(layout, m, instance, at.TENDON), 0) != 0
    tendon = resolve(layout, m, instance, at.TENDON, _TENDON)
    state.first_sheath = -1.0
    shown[:] = -1.0
    for other in range(size(m + layout.m_nplugin)):
        if not is_sheath(layout, m, other, instance):
            continue
        if state.first_sheath < 0.0:
            state.first_sheath = other
        if not is_bound(layout, m, d, other):
            continue
        runs = state_at(state_of(layout, m, d, other)).tendon
        if state.is_of_one != 0.0:
            if runs == tendon:
                shown[0] = other
            continue
        for sensor in range(first, last + 1):
            mine = integer(owners, sensor) == instance and integer(types, sensor) == _TENDON
            if mine and integer(objects, sensor) == runs:
                shown[sensor] = other


@compiled
def ensure_shown(layout: Layout, m: int, d: int, instance: int) -> None:
    """Find what the sensors show, unless it is known."""
    state = sensor_state_at(state_of(layout, m, d, instance))
    seal = _seal(layout, m, d, instance)
    if seal == NONE or state.seal != seal:
        _find_shown(layout, m, d, instance)
        state.seal = _seal(layout, m, d, instance)
