"""Binding of a sheath's state to the model that it is used with, and the proof that it still is.

A state outlives its model and may hold anything: `mj_setState`, `mujoco.rollout` and
`MjSpec.recompile` write it without asking the plugin. Nothing in it is used as an index before its
two signatures are found to be those of this model. Where only that of the binding differs, the
indices are resolved again and the tendon stays; where that of the configuration does, or the
numbers are none of ours, the state begins as after a reset.
"""

from __future__ import annotations

import mujoco

from tendon_mj.native import apart, compiled
from tendon_mj.plugin.abi.layout import LAYOUT
from tendon_mj.plugin.abi.memory import doubles, integer, pointer, size
from tendon_mj.plugin.sheath_plugin import attributes as at
from tendon_mj.plugin.sheath_plugin.input_force import (
    acts_on,
    has_spring,
    is_constrained,
    note_spring,
)
from tendon_mj.plugin.sheath_plugin.names import resolve
from tendon_mj.plugin.sheath_plugin.path import count_wraps, mark_branches
from tendon_mj.plugin.sheath_plugin.signature import (
    NONE,
    binding_signature,
    config_signature,
    is_sealed,
    is_signature,
    renew_signature,
    seal_sheath,
)
from tendon_mj.plugin.sheath_plugin.state import (
    State,
    clear_step,
    fits,
    is_wound,
    parameters_at,
    path_counts,
    state_at,
    state_of,
    state_size_of,
)

_JOINT, _TENDON = mujoco.mjtObj.mjOBJ_JOINT.value, mujoco.mjtObj.mjOBJ_TENDON.value
_MOST = 2.0**53  # up to which doubles hold every whole number


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
def _count_guides(m: int, instance: int, state: State) -> None:
    """Count the guides, arcs and pulleys of the path."""
    tendon = int(state.tendon)
    state.inner_guides = at.number(m, instance, at.INNER_GUIDES)
    state.arc_guides = max(1.0, at.number(m, instance, at.ARC_GUIDES))
    state.input_at_last = at.is_input_at_last(m, instance)
    state.arcs, state.pulleys = count_wraps(m, tendon)
    elements = integer(pointer(m + LAYOUT.m_tendon_num), tendon)
    sites = elements - state.arcs - state.pulleys - 2 * (1 + state.pulleys)  # within branches
    state.guides = state.inner_guides + sites + state.arcs * state.arc_guides + state.pulleys


@compiled
def _bind_drive(m: int, instance: int, state: State) -> None:
    """Find the forces along the tendon, for a sheath without a reel or spools."""
    tendon = int(state.tendon)
    state.first_actuator, state.last_actuator = -1.0, -1.0
    state.driven, state.leads, state.constrained = 0.0, 0.0, 0.0
    cable = at.is_cable_spring(m, instance)
    state.own_spring = cable
    if cable or is_wound(state):
        return
    for actuator in range(size(m + LAYOUT.m_nactuator)):
        if acts_on(m, actuator, tendon):
            if state.first_actuator < 0.0:
                state.first_actuator = actuator
            state.last_actuator = actuator
    if state.first_actuator < 0.0 and not _is_pulled(m, instance, tendon):
        return
    state.driven = 1.0
    state.constrained = is_constrained(m, tendon)
    state.leads = not _is_led(m, instance)


@compiled
def _is_pulled(m: int, instance: int, tendon: int) -> bool:
    """Whether a spring pulls a tendon, or an equality or a limit one of no stated length."""
    return has_spring(m, tendon) or (not at.has_length(m, instance) and is_constrained(m, tendon))


@apart
def _is_led(m: int, instance: int) -> bool:
    """Whether a sheath before this one is driven too."""
    reels, actuators = pointer(m + LAYOUT.m_actuator_plugin), size(m + LAYOUT.m_nactuator)
    for other in range(instance):
        if not at.is_sheath(m, other, instance):
            continue
        wound = at.is_cable_spring(m, other)
        wound |= at.is_given(m, other, at.REEL_JOINT)
        wound |= at.is_given(m, other, at.OUTPUT_JOINT)
        if wound or range_of(reels, actuators, other)[1] >= 0:
            continue
        tendon = resolve(m, other, at.TENDON, _TENDON)
        if _is_pulled(m, other, tendon):
            return True
        for actuator in range(actuators):
            if acts_on(m, actuator, tendon):
                return True
    return False


@apart
def _bind(m: int, instance: int, address: int, keep: bool) -> None:
    """Resolve the elements that a sheath is attached to, and sign it.

    With ``keep`` the tendon stays as it lies, where the path has as many guides and arcs as before.
    """
    state = state_at(address)
    before = path_counts(state)
    was_driven = state.driven
    sensors, reels = pointer(m + LAYOUT.m_sensor_plugin), pointer(m + LAYOUT.m_actuator_plugin)
    state.sheath_signature = NONE
    state.tendon = resolve(m, instance, at.TENDON, _TENDON)
    state.reel_joint = resolve(m, instance, at.REEL_JOINT, _JOINT)
    state.output_joint = resolve(m, instance, at.OUTPUT_JOINT, _JOINT)
    first, last = range_of(sensors, size(m + LAYOUT.m_nsensor), instance)
    state.first_sensor, state.last_sensor = first, last
    state.reel_actuator = range_of(reels, size(m + LAYOUT.m_nactuator), instance)[1]
    if state.tendon < 0.0:
        return
    _count_guides(m, instance, state)
    state_size = state_size_of(m, instance)
    if not fits(address, state_size):
        state.guides, state.arcs = 0.0, 0.0
        return
    _bind_drive(m, instance, state)
    given = at.is_given(m, instance, at.AXIAL_STIFFNESS)
    if not given and state.driven == 0.0 and state.own_spring == 0.0:
        state.law.axial_stiffness = 0.0  # it was driven, and what drove it is gone
    if not keep or path_counts(state) != before or was_driven != state.driven:
        clear_step(address, state_size)
    state.has_trial = 0.0
    mark_branches(m, address)
    state.sheath_signature = binding_signature(m, instance, address)


@apart
def reset_sheath(m: int, address: int, instance: int) -> None:
    """Write the configured parameters; the segments are initialised at the first evaluation."""
    doubles(address, state_size_of(m, instance))[:] = 0.0
    values = parameters_at(address)
    for parameter in range(len(values)):
        values[parameter] = at.number(m, instance, at.FIRST_PARAMETER + parameter)
    _bind(m, instance, address, False)
    state = state_at(address)
    if state.own_spring != 0.0 and state.sheath_signature != NONE:
        note_spring(m, state, at.has_length(m, instance))
    state.config_signature = config_signature(m, instance)


@apart
def _is_proven(m: int, d: int, instance: int) -> bool:
    """Whether the signatures of a sheath's state are those of this model and this sheath."""
    address = state_of(m, d, instance)
    state = state_at(address)
    return (
        is_signature(state.sheath_signature)
        and config_signature(m, instance) == state.config_signature
        and binding_signature(m, instance, address) == state.sheath_signature
        and (state.driven == 0.0 or (state.leads == 0.0) == _is_led(m, instance))
    )


@compiled
def is_bound(m: int, d: int, instance: int) -> bool:
    """Whether a sheath's state is one of this model and this sheath."""
    return is_sealed(m, d, instance) or _is_proven(m, d, instance)


@compiled
def _count(number: float) -> float:
    """A count that a state had, 0 where the number is not one."""
    return number if 0.0 <= number < _MOST and number == float(int(number)) else 0.0


@apart
def _rebind(m: int, d: int, instance: int) -> None:
    address = state_of(m, d, instance)
    state = state_at(address)
    unsolved = rebound = 0.0
    if is_signature(state.config_signature):
        unsolved, rebound = _count(state.unsolved), _count(state.rebound)
    if config_signature(m, instance) == state.config_signature:
        _bind(m, instance, address, state.started == 1.0)
    else:
        reset_sheath(m, address, instance)
    state.unsolved, state.rebound = unsolved, rebound + 1.0


@apart
def _prove(m: int, d: int, instance: int) -> bool:
    """Prove that a sheath's state is bound, or bind it; seal it; return whether it now is bound."""
    if not _is_proven(m, d, instance):
        _rebind(m, d, instance)
        state = state_at(state_of(m, d, instance))
        if state.sheath_signature == NONE:
            state.first_sheath = -1.0  # so that no other trusts what it has
            state.unsolved += 1.0
            return False
    seal_sheath(m, d, instance)
    return True


@compiled
def ensure_bound(m: int, d: int, instance: int) -> bool:
    """Bind a sheath's state to the model unless it is; return whether it now is."""
    renew_signature(m, d, instance)
    if is_sealed(m, d, instance):
        return True
    return _prove(m, d, instance)
