"""Sensors of the plugin: which sheaths they show, and of these which numbers.

An instance with `sensor` whose configuration names a tendon shows the sheath on that; of another
each sensor has the tendon as its object. The state holds only what is in the model and in the
states of the sheaths, so where its seal is broken it is computed again.
"""

from __future__ import annotations

import mujoco

from tendon_mj.native import apart, compiled
from tendon_mj.plugin.abi.layout import LAYOUT
from tendon_mj.plugin.abi.memory import doubles, integer, pointer, size
from tendon_mj.plugin.sheath_plugin import attributes as at
from tendon_mj.plugin.sheath_plugin.attributes import (
    BEND_ANGLE,
    INPUT_TENSION,
    OUTPUT_TENSION,
    REEL_DISPLACEMENT,
    SLIP,
    TENSION,
    UNSOLVED,
    numbers_of,
)
from tendon_mj.plugin.sheath_plugin.bind import is_bound, range_of
from tendon_mj.plugin.sheath_plugin.names import resolve
from tendon_mj.plugin.sheath_plugin.signature import (
    NONE,
    as_number,
    hashed,
    is_signature,
    mixed,
    signature_by,
)
from tendon_mj.plugin.sheath_plugin.state import (
    fits,
    sensor_state_at,
    shown_at,
    state_at,
    state_of,
    state_size_of,
    unpack,
)

_TENDON = mujoco.mjtObj.mjOBJ_TENDON.value


@compiled
def _measure(address: int, kind: int, out: int) -> None:
    """Write at ``out`` the quantity ``kind`` of the sheath at ``address``."""
    state = state_at(address)
    segments, guides, _ = unpack(address)
    ea, last = state.law.axial_stiffness, len(guides)
    shown = doubles(out, last + 1)
    if kind == INPUT_TENSION:
        shown[0] = ea * segments[0].tension
    elif kind == OUTPUT_TENSION:
        shown[0] = ea * segments[last].tension
    elif kind == TENSION:
        for j in range(last + 1):
            shown[j] = ea * segments[j].tension
    elif kind == REEL_DISPLACEMENT:
        shown[0] = state.trial_wound_in
    elif kind == UNSOLVED:
        shown[0] = state.unsolved
    else:
        for i in range(last):
            if kind == BEND_ANGLE:
                shown[i] = guides[i].angle
            elif kind == SLIP:
                shown[i] = guides[i].slip if guides[i].flow != 0.0 else 0.0
            else:
                shown[i] = guides[i].friction_work + guides[i].trial_friction_work


@apart
def reset_sensor(m: int, address: int, instance: int) -> None:
    """Reset what the sensors show: the states of the sheaths may not be there yet."""
    doubles(address, state_size_of(m, instance))[:] = 0.0


@compiled
def _seal(m: int, d: int, instance: int) -> float:
    """Seal of the state as it is now, `NONE` where it cannot have one."""
    address = state_of(m, d, instance)
    first = sensor_state_at(address).first_sheath
    signature = signature_by(m, d, first, instance)
    if not is_signature(signature):
        return NONE
    h = hashed(address + 8, 8 * (state_size_of(m, instance) - 1))
    return as_number(mixed(mixed(h, int(signature)), instance))


@apart
def _find_shown(m: int, d: int, instance: int) -> None:
    """Find the sheath that each sensor of the instance shows."""
    address = state_of(m, d, instance)
    state, shown = sensor_state_at(address), shown_at(address, state_size_of(m, instance))
    owners, objects = pointer(m + LAYOUT.m_sensor_plugin), pointer(m + LAYOUT.m_sensor_objid)
    types = pointer(m + LAYOUT.m_sensor_objtype)
    first, last = range_of(owners, size(m + LAYOUT.m_nsensor), instance)
    state.first_sensor, state.last_sensor = first, last
    state.kind = at.sensor_kind(m, instance)
    state.is_of_one = at.is_given(m, instance, at.TENDON)
    tendon = resolve(m, instance, at.TENDON, _TENDON)
    state.first_sheath = -1.0
    shown[:] = -1.0
    for other in range(size(m + LAYOUT.m_nplugin)):
        if not at.is_sheath(m, other, instance):
            continue
        if state.first_sheath < 0.0:
            state.first_sheath = other
        if not is_bound(m, d, other):
            continue
        runs = state_at(state_of(m, d, other)).tendon
        if state.is_of_one != 0.0:
            if runs == tendon:
                shown[0] = other
            continue
        for sensor in range(first, last + 1):
            mine = integer(owners, sensor) == instance and integer(types, sensor) == _TENDON
            if mine and integer(objects, sensor) == runs:
                shown[sensor] = other


@compiled
def _ensure_shown(m: int, d: int, instance: int) -> None:
    """Find what the sensors show, unless it is known."""
    state = sensor_state_at(state_of(m, d, instance))
    seal = _seal(m, d, instance)
    if seal == NONE or state.seal != seal:
        _find_shown(m, d, instance)
        state.seal = _seal(m, d, instance)


@compiled
def show(m: int, d: int, instance: int) -> None:
    """Fill the sensors of an instance with `sensor`."""
    _ensure_shown(m, d, instance)
    address = state_of(m, d, instance)
    state, shown = sensor_state_at(address), shown_at(address, state_size_of(m, instance))
    first, last, kind = state.first_sensor, state.last_sensor, int(state.kind)
    if not 0.0 <= first <= last < size(m + LAYOUT.m_nsensor):
        return
    owners, widths = pointer(m + LAYOUT.m_sensor_plugin), pointer(m + LAYOUT.m_sensor_dim)
    for sensor in range(int(first), int(last) + 1):
        if integer(owners, sensor) != instance:
            continue
        source = shown[0] if state.is_of_one != 0.0 else shown[sensor]
        if not 0.0 <= source < size(m + LAYOUT.m_nplugin):
            continue
        if not at.is_sheath(m, int(source), instance):
            continue
        sheath = state_of(m, d, int(source))
        known = fits(sheath, state_size_of(m, int(source)))
        count = numbers_of(kind, int(state_at(sheath).guides)) if known else 0
        if 0 < count <= integer(widths, sensor):
            adr = integer(pointer(m + LAYOUT.m_sensor_adr), sensor)
            _measure(sheath, kind, pointer(d + LAYOUT.d_sensordata) + 8 * adr)


@compiled
def show_ends(m: int, d: int, instance: int) -> None:
    """Fill the sensors on the sheath's own instance with T_in and T_out."""
    sheath = state_of(m, d, instance)
    state = state_at(sheath)
    first, last = state.first_sensor, state.last_sensor
    if not 0.0 <= first <= last < size(m + LAYOUT.m_nsensor):
        return
    if not fits(sheath, state_size_of(m, instance)):
        return
    segments, _, _ = unpack(sheath)
    ea = state.law.axial_stiffness
    owners = pointer(m + LAYOUT.m_sensor_plugin)
    for sensor in range(int(first), int(last) + 1):
        if integer(owners, sensor) == instance:
            adr = integer(pointer(m + LAYOUT.m_sensor_adr), sensor)
            shown = doubles(pointer(d + LAYOUT.d_sensordata) + 8 * adr, 2)
            shown[0] = ea * segments[0].tension
            shown[1] = ea * segments[len(segments) - 1].tension
