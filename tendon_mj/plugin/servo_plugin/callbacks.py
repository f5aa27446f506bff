"""The functions of `mjpPlugin` that MuJoCo calls for a servo in a step; no Python among them."""

from __future__ import annotations

from tendon_mj.native import apart, compiled, entry
from tendon_mj.plugin.abi.layout import LAYOUT
from tendon_mj.plugin.abi.library import mjp_getPluginAtSlot
from tendon_mj.plugin.abi.memory import double, doubles, integer, pointer, size
from tendon_mj.plugin.servo_plugin import state as sv
from tendon_mj.plugin.servo_plugin.law import commit, evaluate
from tendon_mj.plugin.servo_plugin.state import GAINS
from tendon_mj.plugin.sheath_plugin import attributes as at
from tendon_mj.plugin.sheath_plugin.attributes import ATTRIBUTES
from tendon_mj.plugin.sheath_plugin.bind import is_bound, range_of
from tendon_mj.plugin.sheath_plugin.names import resolve, resolve_from
from tendon_mj.plugin.sheath_plugin.signature import (
    NONE,
    is_signature,
    pair_signature,
    servo_signature,
)
from tendon_mj.plugin.sheath_plugin.state import state_of, state_size_of

_JOINT, _TENDON = 3, 18  # mjtObj
_SHEATH_PLUGIN = at.as_rows(("tendon_mj.sheath",))
_FEEDBACKS, _SWITCH = at.as_rows(sv.FEEDBACKS), at.as_rows(sv.SWITCH)
_DEFAULTS = tuple(gain.default or 0.0 for gain in GAINS.values())
_GAIN = {name: k for k, name in enumerate(GAINS)}
_LOOSENING = (
    (_GAIN["tension_gain"], _GAIN["loosening_tension_gain"]),
    (_GAIN["velocity_gain"], _GAIN["loosening_velocity_gain"]),
)
_FRICTION, _INERTIA = _GAIN["observer_friction"], _GAIN["motor_inertia"]
_SHEATH_FRICTION = ATTRIBUTES.index("friction")


@compiled
def _find_sheath(m: int, servo: int) -> int:
    """The sheath on the tendon that a servo names, −1 if there is none."""
    slots = pointer(m + LAYOUT.m_plugin)
    tendon = resolve_from(m, servo, sv.TENDON, sv.INSTANCE, sv.TENDON, _TENDON)
    count = size(m + LAYOUT.m_nplugin)
    for step in range(count):  # backwards, as a servo comes after its sheath
        other = (servo - step + count) % count
        name = pointer(mjp_getPluginAtSlot(integer(slots, other)))
        if (
            at.index_of(name, _SHEATH_PLUGIN) == 0
            and not at.is_sensor(m, other)
            and tendon == resolve(m, other, at.TENDON, _TENDON)
        ):
            return other
    return -1


@compiled
def _given(m: int, instance: int, gain: int, otherwise: float) -> float:
    """A configured gain, ``otherwise`` where it is not written."""
    given = at.is_given(m, instance, gain)
    return at.number(m, instance, gain) if given else otherwise


@compiled
def _bind(m: int, address: int, instance: int) -> None:
    """Find the actuator and the sheath."""
    state = sv.state_at(address)
    state.capacity = sv.capacity_of(state_size_of(m, instance))
    actuators = pointer(m + LAYOUT.m_actuator_plugin)
    state.actuator = range_of(actuators, size(m + LAYOUT.m_nactuator), instance)[1]
    sheath = _find_sheath(m, instance)
    state.sheath, state.instance = -1.0, -1.0
    if sheath >= 0 and resolve(m, sheath, at.REEL_JOINT, _JOINT) >= 0:
        state.sheath = integer(pointer(m + LAYOUT.m_plugin_stateadr), sheath)
        state.instance = sheath
    state.has_trial = 0.0
    state.servo_signature = _servo_signature(m, address, instance)


@apart
def _servo_signature(m: int, address: int, instance: int) -> float:
    """Signature of a servo's sheath and actuator, `NONE` where an index is out of range."""
    state = sv.state_at(address)
    if state.capacity != sv.capacity_of(state_size_of(m, instance)):
        return NONE
    if not (0.0 <= state.count <= state.capacity and 0.0 <= state.head <= state.capacity):
        return NONE
    sheath = -1
    if state.instance != -1.0:
        if not 0.0 <= state.instance < size(m + LAYOUT.m_nplugin):
            return NONE
        sheath = int(state.instance)
        if state.sheath != integer(pointer(m + LAYOUT.m_plugin_stateadr), sheath):
            return NONE
        slot = integer(pointer(m + LAYOUT.m_plugin), sheath)
        if at.index_of(pointer(mjp_getPluginAtSlot(slot)), _SHEATH_PLUGIN) != 0:
            return NONE
    return servo_signature(m, instance, sheath, state.actuator)


@apart
def _reset(m: int, address: int, instance: int) -> None:
    """Write the configured gains, and those that follow from them and from the sheath."""
    doubles(address, state_size_of(m, instance))[:] = 0.0
    values = sv.gains_at(address)
    for gain in range(len(values)):
        values[gain] = _given(m, instance, gain, _DEFAULTS[gain])
    for pulling, loosening in _LOOSENING:
        values[loosening] = _given(m, instance, loosening, values[pulling])
    state = sv.state_at(address)
    state.observes = at.index_of(at.text_at(m, instance, sv.FEEDBACK), _FEEDBACKS) == 1
    state.backdriven = at.index_of(at.text_at(m, instance, sv.BACKDRIVE), _SWITCH) == 1
    sheath = _find_sheath(m, instance)
    if sheath >= 0:
        friction = at.number(m, sheath, _SHEATH_FRICTION)
        values[_FRICTION] = _given(m, instance, _FRICTION, friction)
        joint = resolve(m, sheath, at.REEL_JOINT, _JOINT)
        if joint >= 0:
            dof = integer(pointer(m + LAYOUT.m_jnt_dofadr), joint)
            armature = double(pointer(m + LAYOUT.m_dof_armature), dof)
            values[_INERTIA] = _given(m, instance, _INERTIA, armature)
    _bind(m, address, instance)
    state.config_signature = pair_signature(m, instance, int(state.instance))


@apart
def _is_bound(m: int, address: int, instance: int) -> bool:
    """Whether a state is one of this model and this servo, and so is that of its sheath."""
    state = sv.state_at(address)
    return (
        is_signature(state.servo_signature)
        and _servo_signature(m, address, instance) == state.servo_signature
        and pair_signature(m, instance, int(state.instance)) == state.config_signature
    )


@apart
def _rebind(m: int, address: int, instance: int) -> None:
    """Bind a servo again, and read its configuration again where that has changed."""
    state = sv.state_at(address)
    known = is_signature(state.config_signature)
    known &= state.capacity == sv.capacity_of(state_size_of(m, instance))
    known &= 0.0 <= state.count <= state.capacity and 0.0 <= state.head <= state.capacity
    if known:
        _bind(m, address, instance)
        known = pair_signature(m, instance, int(state.instance)) == state.config_signature
    if not known:
        _reset(m, address, instance)


@compiled
def _evaluate(m: int, d: int, instance: int) -> None:
    address = state_of(m, d, instance)
    if not _is_bound(m, address, instance):
        _rebind(m, address, instance)
    state = sv.state_at(address)
    if state.instance < 0.0 or not is_bound(m, d, int(state.instance)):
        state.has_trial = 0.0
        return
    evaluate(m, d, address)


@compiled
def _advance(m: int, d: int, instance: int) -> None:
    address = state_of(m, d, instance)
    if sv.state_at(address).has_trial != 0.0 and _is_bound(m, address, instance):
        commit(address)


@entry("tendon_mj_servo_reset", "void(ptr, ptr, ptr, i32)")
def reset(m: int, state: int, unused: int, instance: int) -> None:
    _reset(m, state, instance)


@entry("tendon_mj_servo_compute", "void(ptr, ptr, i32, i32)")
def compute(m: int, d: int, instance: int, capability: int) -> None:
    _evaluate(m, d, instance)


@entry("tendon_mj_servo_advance", "void(ptr, ptr, i32)")
def advance(m: int, d: int, instance: int) -> None:
    _advance(m, d, instance)
