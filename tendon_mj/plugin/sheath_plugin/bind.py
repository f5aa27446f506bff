"""Binding of a sheath to its model: which tendon, joints, actuators and sensors it acts on.

A sheath looks these up when it is first evaluated, and keeps them in `mjData.plugin_data`, where
MuJoCo's own plugins keep such things and which no state overwrites. They are looked up again when
the model is another one, or when in the model itself something has changed that they depend on: the
first sheath of a model computes its signature (`signature`) in each evaluation, the others compare.

A *state* may be that of another model: `mj_setState`, `mujoco.rollout` and `MjSpec.recompile` write
it without asking the plugin. Where the signature of the configuration that it was made with is not
that of this sheath, it begins as after a reset; where the tendon now runs over another number of
guides, it is laid anew.
"""

from __future__ import annotations

import ctypes

import numpy as np

from tendon_mj.native import LocalDoubles, apart, compiled, entry, load
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.abi.library import free, malloc, plugin_name
from tendon_mj.plugin.abi.memory import address_of, doubles, word, words
from tendon_mj.plugin.compiled_checks import check_bound
from tendon_mj.plugin.sheath_plugin import attributes as at
from tendon_mj.plugin.sheath_plugin import input_force
from tendon_mj.plugin.sheath_plugin.fixed_tendon import is_fixed
from tendon_mj.plugin.sheath_plugin.name_lookup import joint_of, tendon_of
from tendon_mj.plugin.sheath_plugin.path import count_guides, mark_branches
from tendon_mj.plugin.sheath_plugin.signature import (
    as_number,
    config_signature,
    hashed,
    is_signature,
    mixed,
    model_signature,
)
from tendon_mj.plugin.sheath_plugin.state import (
    BINDING,
    SERVO,
    SHEATH,
    WORKSPACE,
    Binding,
    adopt_binding,
    binding_at,
    binding_of,
    clear_step,
    fits,
    is_wound,
    parameters_at,
    path_counts,
    state_at,
    state_of,
    state_size_of,
)
from tendon_mj.typing import IntArray

_COUNT = BINDING.itemsize // 8
_passing = LocalDoubles(_COUNT)  # what is bound for the moment
_SERVO_NAME = at.as_rows(("tendon_mj.servo",))
_MOST = 2.0**53  # up to which doubles hold every whole number


@compiled
def range_of(owners: IntArray, count: int, instance: int) -> tuple[int, int]:
    """First and last element that belongs to an instance, (0, −1) if none does."""
    first, last = 0, -1
    for k in range(count):
        if owners[k] == instance:
            first = k if last < 0 else first
            last = k
    return first, last


@apart
def _is_last_plugin(m: Model, last: int) -> bool:
    """Return whether only sensors of sheaths and servos come after the last sheath of a model."""
    for other in range(last + 1, m.nplugin):
        is_servo = at.index_of(plugin_name(m, other), _SERVO_NAME) == 0
        if m.plugin[other] != m.plugin[last] and not is_servo:
            return False
    return True


@compiled
def _count_guides(m: Model, instance: int, bound: Binding) -> None:
    """Count the guides, arcs and pulleys of the path."""
    tendon = int(bound.tendon)
    bound.inner_guides = at.number(m, instance, at.INNER_GUIDES)
    bound.arc_guides = max(1.0, at.number(m, instance, at.ARC_GUIDES))
    bound.input_at_last = at.is_input_at_last(m, instance)
    bound.fixed = is_fixed(m, tendon)
    bound.guides, bound.arcs, bound.pulleys = count_guides(
        m, tendon, bound.arc_guides, bound.inner_guides
    )
    bound.branches = 0.0
    if bound.pulleys > 0.0:
        first, elements = 4 * m.tendon_adr[tendon], m.tendon_num[tendon]
        h = hashed(address_of(m.wrap_type) + first, 4 * elements)
        ends = hashed(address_of(m.wrap_objid) + first, 4 * elements)
        bound.branches = as_number(mixed(h, ends))


@compiled
def _bind_drive(m: Model, instance: int, bound: Binding) -> None:
    """Find the forces along the tendon, for a sheath without a reel or spools."""
    tendon = int(bound.tendon)
    bound.first_actuator, bound.last_actuator = -1.0, -1.0
    bound.driven = bound.inextensible = bound.constrained = bound.spreads = 0.0
    cable = at.is_cable_spring(m, instance)
    bound.own_spring = cable
    if cable or is_wound(bound):
        return
    for actuator in range(m.nactuator):
        if input_force.acts_on(m, actuator, tendon):
            if bound.first_actuator < 0.0:
                bound.first_actuator = actuator
            bound.last_actuator = actuator
    if bound.first_actuator < 0.0 and not _is_pulled(m, instance, tendon):
        return
    bound.driven = 1.0
    if bound.fixed != 0.0:  # what holds it holds its joints
        bound.inextensible = 1.0
        return
    bound.constrained = input_force.is_constrained(m, tendon)
    bound.spreads = input_force.holds_length(m, tendon)
    bound.inextensible = not _is_elastic(m, instance)


@compiled
def _is_pulled(m: Model, instance: int, tendon: int) -> bool:
    """Return whether a spring pulls a tendon, or an equality or a limit one of no stated length."""
    if input_force.has_spring(m, tendon):
        return True
    return not at.has_length(m, instance) and input_force.is_constrained(m, tendon)


@compiled
def _is_elastic(m: Model, instance: int) -> bool:
    """Return whether the elasticity of a sheath's tendon is stated."""
    return (
        at.number(m, instance, at.AXIAL_STIFFNESS) != 0.0
        or at.number(m, instance, at.STIFFENING) != 0.0
        or at.number(m, instance, at.CREEP) != 0.0
        or at.number(m, instance, at.AXIAL_DAMPING) != 0.0
    )


@apart
def _bind(m: Model, instance: int, address: int, signature: float) -> None:
    """Look up what a sheath is attached to; its tendon is −1 if that cannot be."""
    bound = binding_at(address)
    bound.signature, bound.listed_for = signature, 0.0
    bound.config_signature = config_signature(m, instance)
    bound.first_sheath = at.first_sheath(m, instance)
    bound.last_sheath = at.last_sheath(m, instance)
    bound.is_last_plugin = _is_last_plugin(m, int(bound.last_sheath))
    bound.guides, bound.arcs = 0.0, 0.0
    bound.dofs = m.nv if bound.first_sheath == instance else 0.0
    bound.tendon = tendon_of(m, instance)
    bound.reel_joint = joint_of(m, instance, at.REEL_JOINT)
    bound.output_joint = joint_of(m, instance, at.OUTPUT_JOINT)
    first, last = range_of(m.sensor_plugin, m.nsensor, instance)
    bound.first_sensor, bound.last_sensor = first, last
    bound.reel_actuator = range_of(m.actuator_plugin, m.nactuator, instance)[1]
    if not 0.0 <= bound.tendon < m.ntendon:
        bound.tendon = -1.0
        return
    _count_guides(m, instance, bound)
    _bind_drive(m, instance, bound)
    if not fits(bound, state_size_of(m, instance)):
        bound.tendon, bound.guides, bound.arcs = -1.0, 0.0, 0.0


@entry("tendon_mj_sheath_bind", "void(mjModel, i32, ptr)")
def bind(m: Model, instance: int, address: int) -> None:
    """Look up what a sheath is attached to, for Python."""
    _bind(m, instance, address, 0.0)


def attachment(model: int, instance: int) -> Binding:
    """What a sheath is attached to in the model at an address."""
    record = np.zeros(1, BINDING).view(np.recarray)
    function = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p)
    function(load().address("tendon_mj_sheath_bind"))(model, instance, record.ctypes.data)
    bound: Binding = record[0]
    return bound


@apart
def new_binding(d: Data, instance: int, kind: int, count: int) -> int:
    """Memory for so many numbers, all 0, in `mjData.plugin_data`; its address."""
    release(d, instance)
    block = malloc(8 * (count + 1))
    words(block)[0] = kind
    doubles(block + 8, count)[:] = 0.0
    d.plugin_data[instance] = block
    return block + 8


@apart
def reset_sheath(m: Model, address: int, binding: int, instance: int) -> None:
    """Write the configured parameters; the segments are initialised at the first evaluation.

    A ``binding`` of 0 is one that is not made yet.
    """
    doubles(address, state_size_of(m, instance))[:] = 0.0
    passing, signature = _passing(), model_signature(m)
    if binding == 0:
        binding = passing
    bound, state = binding_at(binding), state_at(address)
    if binding == passing or bound.signature != signature:
        _bind(m, instance, binding, signature)
    if bound.tendon < 0.0:
        return
    values = parameters_at(address)
    for parameter in range(len(values)):
        values[parameter] = at.number(m, instance, at.FIRST_PARAMETER + parameter)
    adopt_binding(address, binding)
    mark_branches(m, address)
    _forget_drive(m, instance, address)
    if state.own_spring != 0.0:
        input_force.note_spring(m, state, at.has_length(m, instance))
    state.config_signature = bound.config_signature


@apart
def check_bindable(m: Model, out: int, instance: int) -> None:
    """Refuse a sheath that cannot act on its tendon, with a message at an address."""
    passing = _passing()
    _bind(m, instance, passing, 0.0)
    check_bound(m, out, instance, binding_at(passing))


@compiled
def _forget_drive(m: Model, instance: int, address: int) -> None:
    """A sheath that was driven has no axial stiffness once what drove it is gone."""
    state = state_at(address)
    given = at.is_given(m, instance, at.AXIAL_STIFFNESS)
    if not given and state.driven == 0.0 and state.own_spring == 0.0:
        state.law.axial_stiffness = 0.0


@compiled
def _is_laid_as(address: int, binding: int) -> bool:
    """Return whether a state is one of this sheath, with its tendon on the path bound."""
    state, bound = state_at(address), binding_at(binding)
    return (
        state.config_signature == bound.config_signature
        and path_counts(state) == path_counts(bound)
        and state.driven == bound.driven
    )


@compiled
def is_bound(m: Model, d: Data, instance: int) -> bool:
    """Return whether a sheath is bound to the model as it is, and its state is one of this sheath.

    The indices in its state are then those of the binding.
    """
    if not has_own_state(m, d, instance):
        return False
    adopt_binding(state_of(m, d, instance), binding_of(d, instance, SHEATH))
    return True


@compiled
def has_own_state(m: Model, d: Data, instance: int) -> bool:
    """As ``is_bound``; of the indices in the state only the counts of the path are looked at."""
    binding = binding_of(d, instance, SHEATH)
    if binding == 0:
        _rebind(m, d, instance)
        binding = binding_of(d, instance, SHEATH)
    bound, address = binding_at(binding), state_of(m, d, instance)
    if bound.tendon < 0.0 or bound.signature != present_signature(d, bound):
        return False
    return _is_laid_as(address, binding)


@compiled
def present_signature(d: Data, bound: Binding) -> float:
    """Signature of the model as the first sheath has seen it last."""
    first = binding_of(d, int(bound.first_sheath), SHEATH)
    return binding_at(first).present if first != 0 else 0.0


@compiled
def _count(number: float) -> float:
    """A count that a state had, 0 if the number is not one."""
    return number if 0.0 <= number < _MOST and number == float(int(number)) else 0.0


@apart
def _take_over(m: Model, d: Data, instance: int) -> bool:
    """Make a state that is not one of this sheath, as it is bound, one of it."""
    binding, address = binding_of(d, instance, SHEATH), state_of(m, d, instance)
    state, bound = state_at(address), binding_at(binding)
    if bound.tendon < 0.0:
        state.unsolved = _count(state.unsolved) + 1.0
        return False
    unsolved = rebound = 0.0
    if is_signature(state.config_signature):
        unsolved, rebound = _count(state.unsolved), _count(state.rebound)
    if state.config_signature != bound.config_signature:
        reset_sheath(m, address, binding, instance)
    else:
        adopt_binding(address, binding)
        clear_step(address, state_size_of(m, instance))
        mark_branches(m, address)
        _forget_drive(m, instance, address)
    state.unsolved, state.rebound = unsolved, rebound + 1.0
    return True


@compiled
def ensure_bound(m: Model, d: Data, instance: int) -> bool:
    """Bind a sheath to the model, and its state to the sheath; return whether they are."""
    binding = binding_of(d, instance, SHEATH)
    if binding != 0:
        bound = binding_at(binding)
        if bound.first_sheath == instance:
            bound.present = model_signature(m)
        if bound.signature != present_signature(d, bound):
            binding = 0
    if binding == 0:
        _rebind(m, d, instance)
    return is_bound(m, d, instance) or _take_over(m, d, instance)


@apart
def _rebind(m: Model, d: Data, instance: int) -> None:
    """Look up what a sheath is attached to, for the first time or again."""
    first = at.first_sheath(m, instance)
    if binding_of(d, first, SHEATH) == 0:
        new_binding(d, first, SHEATH, _COUNT)
    if binding_of(d, instance, SHEATH) == 0:
        new_binding(d, instance, SHEATH, _COUNT)
    leader = binding_at(binding_of(d, first, SHEATH))
    leader.present = model_signature(m)
    _bind(m, instance, binding_of(d, instance, SHEATH), leader.present)


@compiled
def release(d: Data, instance: int) -> None:
    """Free what an instance is bound to."""
    block = d.plugin_data[instance]
    if block != 0 and SHEATH <= word(block) <= SERVO:
        if word(block) == SHEATH:
            free(word(block + 8 + WORKSPACE))
        free(block)
        d.plugin_data[instance] = 0
