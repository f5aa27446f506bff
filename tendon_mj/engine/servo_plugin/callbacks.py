"""The functions of `mjpPlugin` that MuJoCo calls for a servo in a step; no Python among them."""

from __future__ import annotations

from numba import types

from tendon_mj.compilation import callback, compiled
from tendon_mj.engine.abi.layout import Layout
from tendon_mj.engine.abi.library import mj_name2id, mjp_getPluginAtSlot
from tendon_mj.engine.abi.memory import byte, double, doubles, integer, pointer, size
from tendon_mj.engine.servo_plugin import state as sv
from tendon_mj.engine.servo_plugin.evaluate import commit, evaluate
from tendon_mj.engine.servo_plugin.gains import GAINS
from tendon_mj.engine.sheath_plugin import attributes as at
from tendon_mj.engine.sheath_plugin.attributes import ATTRIBUTES
from tendon_mj.engine.sheath_plugin.callbacks import Callbacks, range_of, state_of

_JOINT = 3  # mjtObj
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
def _find_sheath(layout: Layout, m: int, servo: int) -> int:
    """The sheath on the tendon that a servo names, −1 if there is none."""
    slots = pointer(m + layout.m_plugin)
    tendon = at.text_at(layout, m, servo, sv.TENDON)
    for other in range(size(m + layout.m_nplugin)):
        name = pointer(mjp_getPluginAtSlot(integer(slots, other)))
        if (
            at.index_of(name, _SHEATH_PLUGIN) == 0
            and at.sensor_kind_at(at.text_at(layout, m, other, at.SENSOR)) < 0
            and at.are_equal(tendon, at.text_at(layout, m, other, at.TENDON))
        ):
            return other
    return -1


@compiled
def _given(layout: Layout, m: int, instance: int, parameter: int, otherwise: float) -> float:
    address = at.text_at(layout, m, instance, parameter)
    return otherwise if byte(address, 0) == 0 else at.number_at(address)


@compiled
def _reset(layout: Layout, m: int, address: int, instance: int) -> None:
    """Write the configured gains; others follow from these and from the sheath."""
    count = integer(pointer(m + layout.m_plugin_statenum), instance)
    doubles(address, count)[:] = 0.0
    values = sv.gains_at(address)
    for gain in range(len(values)):
        values[gain] = _given(layout, m, instance, gain, _DEFAULTS[gain])
    for pulling, loosening in _LOOSENING:
        values[loosening] = _given(layout, m, instance, loosening, values[pulling])
    state = sv.state_at(address)
    state.capacity = sv.capacity_of(count)
    state.observes = at.index_of(at.text_at(layout, m, instance, sv.FEEDBACK), _FEEDBACKS) == 1
    state.backdriven = at.index_of(at.text_at(layout, m, instance, sv.BACKDRIVE), _SWITCH) == 1
    actuators = pointer(m + layout.m_actuator_plugin)
    state.actuator = range_of(actuators, size(m + layout.m_nactuator), instance)[1]
    sheath = _find_sheath(layout, m, instance)
    state.sheath = -1.0
    if sheath >= 0:
        state.sheath = integer(pointer(m + layout.m_plugin_stateadr), sheath)
        friction = at.number_at(at.text_at(layout, m, sheath, _SHEATH_FRICTION))
        values[_FRICTION] = _given(layout, m, instance, _FRICTION, friction)
        joint = mj_name2id(m, _JOINT, at.text_at(layout, m, sheath, at.REEL_JOINT))
        if joint >= 0:
            dof = integer(pointer(m + layout.m_jnt_dofadr), joint)
            armature = double(pointer(m + layout.m_dof_armature), dof)
            values[_INERTIA] = _given(layout, m, instance, _INERTIA, armature)
        else:
            state.sheath = -1.0


def make_callbacks(layout: Layout) -> Callbacks:
    """Bind the functions to the offsets of the running MuJoCo, as those of the sheath are."""
    void, ptr, i32 = types.void, types.intp, types.int32

    @callback(void(ptr, ptr, ptr, i32))
    def reset(m: int, state: int, unused: int, instance: int) -> None:
        _reset(layout, m, state, instance)

    @callback(void(ptr, ptr, i32, i32))
    def compute(m: int, d: int, instance: int, capability: int) -> None:
        evaluate(layout, m, d, state_of(layout, m, d, instance))

    @callback(void(ptr, ptr, i32))
    def advance(m: int, d: int, instance: int) -> None:
        commit(state_of(layout, m, d, instance))

    return Callbacks(reset, compute, advance)
