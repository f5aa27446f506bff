"""The functions of `mjpPlugin` that MuJoCo calls for a servo in a step; no Python among them."""

from __future__ import annotations

from tendon_mj.native import LocalDoubles, apart, compiled, entry
from tendon_mj.plugin import compiled_checks
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.abi.memory import doubles, letters, word
from tendon_mj.plugin.force_servo_plugin import state as sv
from tendon_mj.plugin.force_servo_plugin.law import commit, evaluate
from tendon_mj.plugin.sheath_plugin import attributes as at
from tendon_mj.plugin.sheath_plugin import bind
from tendon_mj.plugin.sheath_plugin.name_lookup import joint_of, sheath_wound_by
from tendon_mj.plugin.sheath_plugin.signature import pair_signature
from tendon_mj.plugin.sheath_plugin.state import SERVO, SHEATH, binding_of, state_of, state_size_of
from tendon_mj.plugin.sheath_plugin.state import binding_at as sheath_binding_at

_BINDING_COUNT = sv.BINDING.itemsize // 8
_passing = LocalDoubles(_BINDING_COUNT)  # what is bound for the moment
_FEEDBACKS, _SWITCH = at.as_rows(sv.FEEDBACKS), at.as_rows(sv.SWITCH)
_DEFAULTS = tuple(gain.default or 0.0 for gain in sv.GAINS.values())
_GAIN = {name: k for k, name in enumerate(sv.GAINS)}
_LOOSENING = (
    (_GAIN["tension_gain"], _GAIN["loosening_tension_gain"]),
    (_GAIN["velocity_gain"], _GAIN["loosening_velocity_gain"]),
)
_FRICTION, _INERTIA = _GAIN["observer_friction"], _GAIN["motor_inertia"]
_SHEATH_FRICTION = at.ATTRIBUTES.index("friction")


@compiled
def _given(m: Model, instance: int, gain: int, otherwise: float) -> float:
    """A configured gain, ``otherwise`` if it is not written."""
    given = at.is_given(m, instance, gain)
    return at.number(m, instance, gain) if given else otherwise


@apart
def _bind(m: Model, instance: int, address: int, signature: float) -> None:
    """Find the actuator and the sheath."""
    bound = sv.binding_at(address)
    bound.signature = signature
    bound.capacity = sv.capacity_of(state_size_of(m, instance))
    bound.actuator = bind.range_of(m.actuator_plugin, m.nactuator, instance)[1]
    sheath = sheath_wound_by(m, instance, sv.TENDON)
    bound.sheath, bound.instance = -1.0, -1.0
    if sheath >= 0:
        bound.sheath = m.plugin_stateadr[sheath]
        bound.instance = sheath
    bound.config_signature = pair_signature(m, instance, int(bound.instance))


@compiled
def _present(d: Data, binding: int) -> float:
    """Signature of the model as its first sheath has seen it last, 0 without a sheath."""
    instance = int(sv.binding_at(binding).instance)
    sheath = binding_of(d, instance, SHEATH) if instance >= 0 else 0
    return bind.present_signature(d, sheath_binding_at(sheath)) if sheath != 0 else 0.0


@apart
def _reset(m: Model, address: int, binding: int, instance: int) -> None:
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
    sheath = sheath_wound_by(m, instance, sv.TENDON)
    if sheath >= 0:
        friction = at.number(m, sheath, _SHEATH_FRICTION)
        values[_FRICTION] = _given(m, instance, _FRICTION, friction)
        armature = m.dof_armature[m.jnt_dofadr[joint_of(m, sheath, at.REEL_JOINT)]]
        values[_INERTIA] = _given(m, instance, _INERTIA, armature)
    if binding == 0:
        binding = _passing()
        _bind(m, instance, binding, 0.0)
    sv.adopt_binding(address, binding)
    state.config_signature = sv.binding_at(binding).config_signature


@compiled
def _is_bound(m: Model, d: Data, instance: int) -> bool:
    """Return whether a servo is bound to the model as it is, and its state is one of this servo.

    The indices in its state are then those of the binding.
    """
    binding, address = binding_of(d, instance, SERVO), state_of(m, d, instance)
    if binding == 0:
        return False
    bound, state = sv.binding_at(binding), sv.state_at(address)
    if bound.signature != _present(d, binding):
        return False
    if state.config_signature != bound.config_signature:
        return False
    if not (0.0 <= state.count <= bound.capacity and 0.0 <= state.head <= bound.capacity):
        return False
    sv.adopt_binding(address, binding)
    return True


@apart
def _rebind(m: Model, d: Data, instance: int) -> None:
    """Bind a servo again, and begin as after a reset where its state is not one of it."""
    binding, address = binding_of(d, instance, SERVO), state_of(m, d, instance)
    if binding == 0:
        binding = bind.new_binding(d, instance, SERVO, _BINDING_COUNT)
    _bind(m, instance, binding, 0.0)
    bound = sv.binding_at(binding)
    if bound.instance >= 0.0:
        # which a copy between two halves of a step is not yet
        bind.is_bound(m, d, int(bound.instance))
    bound.signature = _present(d, binding)
    if not _is_bound(m, d, instance):
        _reset(m, address, binding, instance)


@entry("tendon_mj_servo_nstate", "i32(mjModel, i32)")
def nstate(m: Model, instance: int) -> int:
    """`nstate` of `mjpPlugin`."""
    out = compiled_checks.message()
    letters(out)[0] = 0
    return compiled_checks.servo_state(m, out, instance)


@entry("tendon_mj_servo_init", "i32(mjModel, mjData, i32)")
def init(m: Model, d: Data, instance: int) -> int:
    """`init` of `mjpPlugin`."""
    out = compiled_checks.message()
    letters(out)[0] = 0
    compiled_checks.servo_state(m, out, instance)
    compiled_checks.check_more(m, out, instance)
    if not compiled_checks.has_refused(out):
        compiled_checks.check_motor(m, out, instance)
    compiled_checks.refuse(out, d, instance)
    d.plugin_data[instance] = 0
    return 0


@entry("tendon_mj_servo_destroy", "void(mjData, i32)")
def destroy(d: Data, instance: int) -> None:
    """`destroy` of `mjpPlugin`."""
    bind.release(d, instance)


@entry("tendon_mj_servo_reset", "void(mjModel, ptr, ptr, i32)")
def reset(m: Model, state: int, block: int, instance: int) -> None:
    """`reset` of `mjpPlugin`."""
    binding = block + 8 if block != 0 and word(block) == SERVO else 0
    _reset(m, state, binding, instance)


@entry("tendon_mj_servo_compute", "void(mjModel, mjData, i32, i32)")
def compute(m: Model, d: Data, instance: int, capability: int) -> None:
    """`compute` of `mjpPlugin`."""
    if not _is_bound(m, d, instance):
        _rebind(m, d, instance)
    address = state_of(m, d, instance)
    state = sv.state_at(address)
    bound = _is_bound(m, d, instance) and state.instance >= 0.0
    if bound and bind.is_bound(m, d, int(state.instance)):
        evaluate(m, d, address)
    else:
        state.has_trial = 0.0


@entry("tendon_mj_servo_advance", "void(mjModel, mjData, i32)")
def advance(m: Model, d: Data, instance: int) -> None:
    """`advance` of `mjpPlugin`."""
    address = state_of(m, d, instance)
    if sv.state_at(address).has_trial != 0.0 and _is_bound(m, d, instance):
        commit(address)
