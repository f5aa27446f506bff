"""The functions of `mjpPlugin` that MuJoCo calls while it runs; no Python among them.

An instance is either a sheath, which acts on its tendon, or a view: one with a `sensor` attribute,
which shows something of the sheath on the same tendon. A view's state names that sheath.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numba import types

from tendon_mj.compilation import callback, compiled
from tendon_mj.engine.abi.layout import Layout
from tendon_mj.engine.abi.library import mj_name2id
from tendon_mj.engine.abi.memory import doubles, integer, pointer, size
from tendon_mj.engine.sheath_plugin import attributes as at
from tendon_mj.engine.sheath_plugin import state as st
from tendon_mj.engine.sheath_plugin import subtrees
from tendon_mj.engine.sheath_plugin.measure import measure, measure_ends
from tendon_mj.engine.sheath_plugin.step import commit, evaluate

_ACTUATOR, _SENSOR, _PASSIVE = 1, 2, 4  # mjtPluginCapabilityBit
_JOINT, _TENDON = 3, 18  # mjtObj
VIEW_SIZE = 4
_VIEWED, _KIND, _FIRST, _LAST = range(VIEW_SIZE)


@compiled
def state_of(layout: Layout, m: int, d: int, instance: int) -> int:
    """Address of an instance's state."""
    start = integer(pointer(m + layout.m_plugin_stateadr), instance)
    return pointer(d + layout.d_plugin_state) + 8 * start


@compiled
def _is_view(layout: Layout, m: int, instance: int) -> bool:
    return integer(pointer(m + layout.m_plugin_statenum), instance) == VIEW_SIZE


@compiled
def _find_sheath(layout: Layout, m: int, view: int) -> int:
    """The sheath on the tendon that a view names, −1 if there is none."""
    slots = pointer(m + layout.m_plugin)
    tendon = at.text(layout, m, view, at.TENDON)
    for other in range(size(m + layout.m_nplugin)):
        if (
            integer(slots, other) == integer(slots, view)
            and at.sensor_kind(at.text(layout, m, other, at.SENSOR)) < 0
            and at.same(tendon, at.text(layout, m, other, at.TENDON))
        ):
            return other
    return -1


@compiled
def range_of(owners: int, count: int, instance: int) -> tuple[int, int]:
    """First and last element that belongs to an instance, (0, −1) if none does."""
    first, last = 0, -1
    for k in range(count):
        if integer(owners, k) == instance:
            first = k if last < 0 else first
            last = k
    return first, last


@compiled
def _reset(layout: Layout, m: int, address: int, instance: int) -> None:
    """Configured parameters into the state; the tendon is laid at the first evaluation."""
    sensors = pointer(m + layout.m_sensor_plugin)
    first, last = range_of(sensors, size(m + layout.m_nsensor), instance)
    kind = at.sensor_kind(at.text(layout, m, instance, at.SENSOR))
    if kind >= 0:
        view = doubles(address, VIEW_SIZE)
        view[_VIEWED] = _find_sheath(layout, m, instance)
        view[_KIND] = kind
        view[_FIRST], view[_LAST] = first, last
        return
    state = doubles(address, integer(pointer(m + layout.m_plugin_statenum), instance))
    state[:] = 0.0
    for parameter in range(len(st.PARAMETERS)):
        state[parameter] = at.number(at.text(layout, m, instance, parameter))
    tendon = mj_name2id(m, _TENDON, at.text(layout, m, instance, at.TENDON))
    state[st.TENDON] = tendon
    state[st.GUIDES] = integer(pointer(m + layout.m_tendon_num), tendon) - 2
    state[st.REEL_JOINT] = mj_name2id(m, _JOINT, at.text(layout, m, instance, at.REEL_JOINT))
    state[st.OUTPUT_JOINT] = mj_name2id(m, _JOINT, at.text(layout, m, instance, at.OUTPUT_JOINT))
    state[st.FIRST_SENSOR], state[st.LAST_SENSOR] = first, last
    reels = pointer(m + layout.m_actuator_plugin)
    state[st.REEL_ACTUATOR] = range_of(reels, size(m + layout.m_nactuator), instance)[1]


@compiled
def _show(layout: Layout, m: int, d: int, instance: int) -> None:
    view = doubles(state_of(layout, m, d, instance), VIEW_SIZE)
    if view[_VIEWED] < 0.0:
        return
    sheath = state_of(layout, m, d, int(view[_VIEWED]))
    owners = pointer(m + layout.m_sensor_plugin)
    for sensor in range(int(view[_FIRST]), int(view[_LAST]) + 1):
        if integer(owners, sensor) != instance:
            continue
        adr = integer(pointer(m + layout.m_sensor_adr), sensor)
        measure(sheath, int(view[_KIND]), pointer(d + layout.d_sensordata) + 8 * adr)


@compiled
def _show_ends(layout: Layout, m: int, d: int, instance: int) -> None:
    """For sensors on the sheath's own instance."""
    sheath = state_of(layout, m, d, instance)
    scalars = doubles(sheath, st.SCALARS)
    owners = pointer(m + layout.m_sensor_plugin)
    for sensor in range(int(scalars[st.FIRST_SENSOR]), int(scalars[st.LAST_SENSOR]) + 1):
        if integer(owners, sensor) == instance:
            adr = integer(pointer(m + layout.m_sensor_adr), sensor)
            measure_ends(sheath, pointer(d + layout.d_sensordata) + 8 * adr)


@compiled
def _compute(layout: Layout, readers: Any, m: int, d: int, instance: int, capability: int) -> None:
    view = _is_view(layout, m, instance)
    if capability == _PASSIVE and not view:
        evaluate(layout, m, d, state_of(layout, m, d, instance))
        subtrees.spare(layout, readers, m, d, instance)
    elif capability == _SENSOR and view:
        _show(layout, m, d, instance)
    elif capability == _SENSOR:
        _show_ends(layout, m, d, instance)
    elif capability == _ACTUATOR and not view:
        # a reel acts through the tendon's length, not through a force of its own
        reel = int(doubles(state_of(layout, m, d, instance), st.SCALARS)[st.REEL_ACTUATOR])
        if reel >= 0:
            adr = integer(pointer(m + layout.m_actuator_outadr), reel)
            doubles(pointer(d + layout.d_actuator_force) + 8 * adr, 1)[0] = 0.0


@compiled
def _advance(layout: Layout, m: int, d: int, instance: int) -> None:
    if not _is_view(layout, m, instance):
        commit(state_of(layout, m, d, instance))


class Callbacks(NamedTuple):
    """Compiled functions with C addresses, in the order and shape of `mjpPlugin`."""

    reset: Any
    compute: Any
    advance: Any


def make_callbacks(layout: Layout) -> Callbacks:
    """Bind the functions to the offsets of the running MuJoCo.

    The offsets are closed over, so the compiler sees constants and keeps one compilation on disk
    for each set of them.
    """
    readers = subtrees.READERS
    void, ptr, i32 = types.void, types.intp, types.int32

    @callback(void(ptr, ptr, ptr, i32))
    def reset(m: int, state: int, unused: int, instance: int) -> None:
        _reset(layout, m, state, instance)

    @callback(void(ptr, ptr, i32, i32))
    def compute(m: int, d: int, instance: int, capability: int) -> None:
        _compute(layout, readers, m, d, instance, capability)

    @callback(void(ptr, ptr, i32))
    def advance(m: int, d: int, instance: int) -> None:
        _advance(layout, m, d, instance)

    return Callbacks(reset, compute, advance)
