"""The functions of `mjpPlugin` that MuJoCo calls for a servo in a step; no Python among them."""

from __future__ import annotations

from numba import types

from tendon_mj.compilation import callback, compiled
from tendon_mj.engine.abi.layout import Layout
from tendon_mj.engine.abi.library import mj_name2id, mjp_getPluginAtSlot
from tendon_mj.engine.abi.memory import byte, double, doubles, integer, pointer, size
from tendon_mj.engine.servo_plugin import state as sv
from tendon_mj.engine.servo_plugin.step import commit, evaluate
from tendon_mj.engine.sheath_plugin import attributes as at
from tendon_mj.engine.sheath_plugin import state as st
from tendon_mj.engine.sheath_plugin.callbacks import Callbacks, range_of, state_of

_JOINT = 3  # mjtObj
_SHEATH_PLUGIN = at.words(("tendon_mj.sheath",))
_FEEDBACKS, _SWITCH = at.words(sv.FEEDBACKS), at.words(sv.SWITCH)
_DEFAULTS = tuple(default or 0.0 for *_, default in sv.GAINS.values())


@compiled
def _find_sheath(layout: Layout, m: int, servo: int) -> int:
    """The sheath on the tendon that a servo names, −1 if there is none."""
    slots = pointer(m + layout.m_plugin)
    tendon = at.text(layout, m, servo, sv.TENDON)
    for other in range(size(m + layout.m_nplugin)):
        name = pointer(mjp_getPluginAtSlot(integer(slots, other)))
        if (
            at.which(name, _SHEATH_PLUGIN) == 0
            and at.sensor_kind(at.text(layout, m, other, at.SENSOR)) < 0
            and at.same(tendon, at.text(layout, m, other, at.TENDON))
        ):
            return other
    return -1


@compiled
def _given(layout: Layout, m: int, instance: int, parameter: int, otherwise: float) -> float:
    address = at.text(layout, m, instance, parameter)
    return otherwise if byte(address, 0) == 0 else at.number(address)


@compiled
def _reset(layout: Layout, m: int, address: int, instance: int) -> None:
    """Configured gains into the state; what is not given follows from others and the sheath."""
    s = doubles(address, integer(pointer(m + layout.m_plugin_statenum), instance))
    s[:] = 0.0
    for parameter in range(len(sv.PARAMETERS)):
        s[parameter] = _given(layout, m, instance, parameter, _DEFAULTS[parameter])
    for pulling, loosening in (
        (sv.TENSION_GAIN, sv.LOOSENING_TENSION_GAIN),
        (sv.VELOCITY_GAIN, sv.LOOSENING_VELOCITY_GAIN),
    ):
        s[loosening] = _given(layout, m, instance, loosening, s[pulling])
    s[sv.CAPACITY] = (s.shape[0] - sv.SCALARS) // 2
    s[sv.OBSERVES] = at.which(at.text(layout, m, instance, sv.FEEDBACK), _FEEDBACKS) == 1
    s[sv.BACKDRIVEN] = at.which(at.text(layout, m, instance, sv.BACKDRIVE), _SWITCH) == 1
    actuators = pointer(m + layout.m_actuator_plugin)
    s[sv.ACTUATOR] = range_of(actuators, size(m + layout.m_nactuator), instance)[1]
    sheath = _find_sheath(layout, m, instance)
    s[sv.SHEATH] = -1.0
    if sheath >= 0:
        s[sv.SHEATH] = integer(pointer(m + layout.m_plugin_stateadr), sheath)
        friction = at.number(at.text(layout, m, sheath, st.FRICTION))
        s[sv.OBSERVER_FRICTION] = _given(layout, m, instance, sv.OBSERVER_FRICTION, friction)
        joint = mj_name2id(m, _JOINT, at.text(layout, m, sheath, at.REEL_JOINT))
        if joint >= 0:
            dof = integer(pointer(m + layout.m_jnt_dofadr), joint)
            armature = double(pointer(m + layout.m_dof_armature), dof)
            s[sv.MOTOR_INERTIA] = _given(layout, m, instance, sv.MOTOR_INERTIA, armature)
        else:
            s[sv.SHEATH] = -1.0


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
