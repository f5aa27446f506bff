"""Sensors of the plugin: which sheaths they show, and of these which numbers.

Each sensor of an instance with `sensor` shows the sheath on the tendon that is its object, or that
its instance names. Which sheaths these are is kept in `mjData.plugin_data`.
"""

from __future__ import annotations

from collections.abc import Callable

from tendon_mj.native import Record, apart, compiled
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.abi.memory import address_of, doubles
from tendon_mj.plugin.sheath_plugin import attributes as at
from tendon_mj.plugin.sheath_plugin import bind
from tendon_mj.plugin.sheath_plugin.name_lookup import tendon_of_sensor
from tendon_mj.plugin.sheath_plugin.state import (
    SENSORS,
    SHEATH,
    binding_at,
    binding_of,
    state_at,
    state_of,
    tension_unit,
    unpack,
)
from tendon_mj.plugin.sheath_plugin.strain import unstretched
from tendon_mj.sheath import record_type
from tendon_mj.typing import FloatArray


@compiled
def _measure(address: int, kind: int, out: int) -> None:
    """Write at ``out`` the quantity ``kind`` of the sheath at ``address``."""
    state = state_at(address)
    segments, guides, _ = unpack(address)
    ea, last = tension_unit(state), len(guides)
    shown = doubles(out, last + 1)
    if kind == at.INPUT_TENSION:
        shown[0] = ea * segments[0].tension
    elif kind == at.OUTPUT_TENSION:
        shown[0] = ea * segments[last].tension
    elif kind == at.TENSION:
        for j in range(last + 1):
            shown[j] = ea * segments[j].tension
    elif kind == at.REEL_DISPLACEMENT:
        shown[0] = state.trial_wound_in / unstretched(state, 1.0)
    elif kind == at.UNSOLVED:
        shown[0] = state.unsolved
    else:
        for i in range(last):
            if kind == at.BEND_ANGLE:
                shown[i] = guides[i].angle
            elif kind == at.SLIP:
                shown[i] = guides[i].slip if guides[i].flow != 0.0 else 0.0
            else:
                shown[i] = guides[i].friction_work + guides[i].trial_friction_work


class _Binding:
    """Which sheaths an instance with `sensor` shows; behind it lie their instances."""

    signature: float  # of the model for which this holds
    capacity: float  # sensors of a model for which there is room
    first_sheath: float  # instance of the model's first sheath, −1 without one
    kind: float
    first_sensor: float
    last_sensor: float


_BINDING = record_type(_Binding)
_COUNT = _BINDING.itemsize // 8
_binding_at: Callable[[int], _Binding] = Record(_BINDING)


@compiled
def _shown_at(binding: int) -> FloatArray:
    """Sheath that each sensor of the model shows for an instance; −1 for none."""
    return doubles(binding + 8 * _COUNT, int(_binding_at(binding).capacity) + 1)


@compiled
def _present(d: Data, instance: int) -> float:
    """Signature of the model as its first sheath has seen it last, 0 without a sheath."""
    first = int(_binding_at(binding_of(d, instance, SENSORS)).first_sheath)
    sheath = binding_of(d, first, SHEATH) if first >= 0 else 0
    return binding_at(sheath).present if sheath != 0 else 0.0


@apart
def _find_shown(m: Model, d: Data, instance: int) -> None:
    """Find the sheath that each sensor of the instance shows."""
    sensors = m.nsensor
    address = binding_of(d, instance, SENSORS)
    if address == 0 or sensors > _binding_at(address).capacity:
        address = bind.new_binding(d, instance, SENSORS, _COUNT + sensors + 1)
        _binding_at(address).capacity = sensors
    bound, shown = _binding_at(address), _shown_at(address)
    owners = m.sensor_plugin
    first, last = bind.range_of(owners, m.nsensor, instance)
    bound.first_sheath = at.first_sheath(m, instance)
    bound.signature = _present(d, instance)
    bound.first_sensor, bound.last_sensor = first, last
    bound.kind = at.sensor_kind(m, instance)
    shown[:] = -1.0
    for other in range(m.nplugin):
        if not at.is_sheath(m, other, instance):
            continue
        sheath = binding_of(d, other, SHEATH)
        if sheath == 0:
            continue
        runs = binding_at(sheath).tendon
        for sensor in range(first, last + 1):
            if owners[sensor] == instance and tendon_of_sensor(m, sensor) == runs:
                shown[sensor] = other


@compiled
def show(m: Model, d: Data, instance: int) -> None:
    """Fill the sensors of an instance with `sensor`."""
    address = binding_of(d, instance, SENSORS)
    if address == 0 or _binding_at(address).signature != _present(d, instance):
        _find_shown(m, d, instance)
        address = binding_of(d, instance, SENSORS)
    bound, shown = _binding_at(address), _shown_at(address)
    owners, widths = m.sensor_plugin, m.sensor_dim
    kind = int(bound.kind)
    for sensor in range(int(bound.first_sensor), int(bound.last_sensor) + 1):
        source = shown[sensor]
        if owners[sensor] != instance or source < 0.0:
            continue
        if not bind.has_own_state(m, d, int(source)):
            continue
        sheath = state_of(m, d, int(source))
        count = at.numbers_of(kind, int(state_at(sheath).guides))
        if 0 < count <= widths[sensor]:
            adr = m.sensor_adr[sensor]
            _measure(sheath, kind, address_of(d.sensordata) + 8 * adr)


@compiled
def show_ends(m: Model, d: Data, instance: int) -> None:
    """Fill the sensors on the sheath's own instance with T_in and T_out."""
    if not bind.has_own_state(m, d, instance):
        return
    sheath = state_of(m, d, instance)
    state, bound = state_at(sheath), binding_at(binding_of(d, instance, SHEATH))
    first, last = bound.first_sensor, bound.last_sensor
    segments, _, _ = unpack(sheath)
    ea = tension_unit(state)
    owners = m.sensor_plugin
    for sensor in range(int(first), int(last) + 1):
        if owners[sensor] == instance:
            adr = m.sensor_adr[sensor]
            d.sensordata[adr] = ea * segments[0].tension
            d.sensordata[adr + 1] = ea * segments[len(segments) - 1].tension
