"""The functions of `mjpPlugin` that MuJoCo calls while it runs; no Python among them.

An instance is either a sheath, which acts on its tendon, or one with a `sensor` attribute, which
shows something of the sheath on the same tendon and keeps in its state which sheath that is.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numba import types

from tendon_mj.compilation import callback, compiled
from tendon_mj.engine.abi.layout import Layout
from tendon_mj.engine.abi.library import mj_name2id
from tendon_mj.engine.abi.memory import doubles, integer, pointer, size
from tendon_mj.engine.sheath_plugin import attributes as at
from tendon_mj.engine.sheath_plugin.evaluate import evaluate
from tendon_mj.engine.sheath_plugin.sensors import measure, measure_ends
from tendon_mj.engine.sheath_plugin.state import (
    SENSOR_SIZE,
    parameters_at,
    sensor_state_at,
    state_at,
)
from tendon_mj.engine.sheath_plugin.subtree_velocities import READERS, skip_subtree_velocities
from tendon_mj.engine.sheath_plugin.trial import commit

_ACTUATOR, _SENSOR, _PASSIVE = 1, 2, 4  # mjtPluginCapabilityBit
_JOINT, _TENDON = 3, 18  # mjtObj


@compiled
def state_of(layout: Layout, m: int, d: int, instance: int) -> int:
    """Address of an instance's state."""
    start = integer(pointer(m + layout.m_plugin_stateadr), instance)
    return pointer(d + layout.d_plugin_state) + 8 * start


@compiled
def _is_sensor(layout: Layout, m: int, instance: int) -> bool:
    return integer(pointer(m + layout.m_plugin_statenum), instance) == SENSOR_SIZE


@compiled
def _find_sheath(layout: Layout, m: int, sensor: int) -> int:
    """The sheath on the tendon that a sensor's instance names, −1 if there is none."""
    slots = pointer(m + layout.m_plugin)
    tendon = at.text_at(layout, m, sensor, at.TENDON)
    for other in range(size(m + layout.m_nplugin)):
        if (
            integer(slots, other) == integer(slots, sensor)
            and at.sensor_kind_at(at.text_at(layout, m, other, at.SENSOR)) < 0
            and at.are_equal(tendon, at.text_at(layout, m, other, at.TENDON))
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
    """Write the configured parameters; the tendon is laid at the first evaluation."""
    sensors = pointer(m + layout.m_sensor_plugin)
    first, last = range_of(sensors, size(m + layout.m_nsensor), instance)
    kind = at.sensor_kind_at(at.text_at(layout, m, instance, at.SENSOR))
    if kind >= 0:
        shown = sensor_state_at(address)
        shown.sheath = _find_sheath(layout, m, instance)
        shown.kind = kind
        shown.first_sensor, shown.last_sensor = first, last
        return
    doubles(address, integer(pointer(m + layout.m_plugin_statenum), instance))[:] = 0.0
    values = parameters_at(address)
    for parameter in range(len(values)):
        values[parameter] = at.number_at(at.text_at(layout, m, instance, parameter))
    tendon = mj_name2id(m, _TENDON, at.text_at(layout, m, instance, at.TENDON))
    reels = pointer(m + layout.m_actuator_plugin)
    state = state_at(address)
    state.tendon = tendon
    state.guides = integer(pointer(m + layout.m_tendon_num), tendon) - 2
    state.reel_joint = mj_name2id(m, _JOINT, at.text_at(layout, m, instance, at.REEL_JOINT))
    state.output_joint = mj_name2id(m, _JOINT, at.text_at(layout, m, instance, at.OUTPUT_JOINT))
    state.first_sensor, state.last_sensor = first, last
    state.reel_actuator = range_of(reels, size(m + layout.m_nactuator), instance)[1]


@compiled
def _show(layout: Layout, m: int, d: int, instance: int) -> None:
    """Fill the sensors of an instance that shows something of a sheath."""
    shown = sensor_state_at(state_of(layout, m, d, instance))
    if shown.sheath < 0.0:
        return
    sheath = state_of(layout, m, d, int(shown.sheath))
    owners = pointer(m + layout.m_sensor_plugin)
    for sensor in range(int(shown.first_sensor), int(shown.last_sensor) + 1):
        if integer(owners, sensor) != instance:
            continue
        adr = integer(pointer(m + layout.m_sensor_adr), sensor)
        measure(sheath, int(shown.kind), pointer(d + layout.d_sensordata) + 8 * adr)


@compiled
def _show_ends(layout: Layout, m: int, d: int, instance: int) -> None:
    """Fill the sensors on the sheath's own instance."""
    sheath = state_of(layout, m, d, instance)
    state = state_at(sheath)
    owners = pointer(m + layout.m_sensor_plugin)
    for sensor in range(int(state.first_sensor), int(state.last_sensor) + 1):
        if integer(owners, sensor) == instance:
            adr = integer(pointer(m + layout.m_sensor_adr), sensor)
            measure_ends(sheath, pointer(d + layout.d_sensordata) + 8 * adr)


@compiled
def _compute(
    layout: Layout, readers: tuple[int, ...], m: int, d: int, instance: int, capability: int
) -> None:
    sensor = _is_sensor(layout, m, instance)
    if capability == _PASSIVE and not sensor:
        evaluate(layout, m, d, state_of(layout, m, d, instance))
        skip_subtree_velocities(layout, readers, m, d, instance)
    elif capability == _SENSOR and sensor:
        _show(layout, m, d, instance)
    elif capability == _SENSOR:
        _show_ends(layout, m, d, instance)
    elif capability == _ACTUATOR and not sensor:
        # a reel acts through the tendon's length, not through a force of its own
        reel = int(state_at(state_of(layout, m, d, instance)).reel_actuator)
        if reel >= 0:
            adr = integer(pointer(m + layout.m_actuator_outadr), reel)
            doubles(pointer(d + layout.d_actuator_force) + 8 * adr, 1)[0] = 0.0


@compiled
def _advance(layout: Layout, m: int, d: int, instance: int) -> None:
    if not _is_sensor(layout, m, instance):
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
    readers = READERS
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
