"""The functions of `mjpPlugin` that MuJoCo calls while it runs; no Python among them.

An instance is either a sheath, which acts on its tendon, or one with a `sensor` attribute, whose
sensors show a quantity of sheaths and which keeps in its state which sheaths these are.
"""

from __future__ import annotations

import mujoco

from tendon_mj.native import Text, apart, compiled, entry
from tendon_mj.plugin.abi.checks import (
    SHEATH_INIT,
    SHEATH_NSENSORDATA,
    SHEATH_NSTATE,
    ask_complete,
    ask_sensor_size,
    ask_size,
    asks,
)
from tendon_mj.plugin.abi.layout import LAYOUT
from tendon_mj.plugin.abi.library import free, malloc, mj_passive, warn
from tendon_mj.plugin.abi.memory import (
    copy_doubles,
    doubles,
    integer,
    pointer,
    set_pointer,
    size,
)
from tendon_mj.plugin.compiled_checks import sensor_width, sheath_state
from tendon_mj.plugin.sheath_plugin.attributes import is_sensor
from tendon_mj.plugin.sheath_plugin.bind import (
    check_bindable,
    ensure_bound,
    has_own_state,
    is_bound,
    release,
    reset_sheath,
)
from tendon_mj.plugin.sheath_plugin.evaluate import commit, evaluate
from tendon_mj.plugin.sheath_plugin.forces import add_reactions
from tendon_mj.plugin.sheath_plugin.input_force import follow_constraint
from tendon_mj.plugin.sheath_plugin.names import own_name
from tendon_mj.plugin.sheath_plugin.sensors import show, show_ends
from tendon_mj.plugin.sheath_plugin.signature import control_signature
from tendon_mj.plugin.sheath_plugin.state import (
    SHEATH,
    binding_at,
    binding_of,
    state_at,
    state_of,
    state_size_of,
)

_ACTUATOR, _SENSOR, _PASSIVE = 1, 2, 4  # mjtPluginCapabilityBit
_PASSIVE_OFF = mujoco.mjtDisableBit.mjDSBL_SPRING.value | mujoco.mjtDisableBit.mjDSBL_DAMPER.value
_WARNING = Text("tendon_mj: sheath '")
_UNNAMED = Text("")
_REASONS = Text(
    "' was not solved in an evaluation: a control is not finite, more tendon is wound in than there"
    " is, a stretch has no length, or the solver did not converge; its sensor `unsolved` counts"
    " them"
)


@apart
def _warn(m: int, instance: int) -> None:
    """Warn of the first evaluation since the reset that was not solved."""
    name = own_name(m, instance)
    warn(_WARNING(), name if name != 0 else _UNNAMED(), _REASONS())


@compiled
def _is_skipped(m: int) -> bool:
    """Whether MuJoCo leaves all passive forces out, those of plugins too."""
    return integer(m + LAYOUT.o_disableflags, 0) & _PASSIVE_OFF == _PASSIVE_OFF


@compiled
def _quiet_reel(m: int, d: int, instance: int) -> None:
    """A reel acts through the tendon's length, not through a force of its own."""
    reel = state_at(state_of(m, d, instance)).reel_actuator
    if not 0.0 <= reel < size(m + LAYOUT.m_nactuator):
        return
    if integer(pointer(m + LAYOUT.m_actuator_plugin), int(reel)) == instance:
        adr = integer(pointer(m + LAYOUT.m_actuator_outadr), int(reel))
        doubles(pointer(d + LAYOUT.d_actuator_force) + 8 * adr, 1)[0] = 0.0


@apart
def _compute_passive_again(m: int, d: int) -> None:
    """Compute passive forces again, in the middle of MuJoCo's actuation.

    The forces of actuators are left as MuJoCo has them by now, before it clamps them.
    """
    forces, count = pointer(d + LAYOUT.d_actuator_force), size(m + LAYOUT.m_nout)
    kept = malloc(8 * count)
    copy_doubles(kept, forces, count)
    mj_passive(m, d)
    copy_doubles(forces, kept, count)
    free(kept)


@compiled
def _meet_late_controls(m: int, d: int, instance: int) -> None:
    """Let friction meet controls that were set after passive forces had been computed."""
    binding = binding_of(d, instance, SHEATH)
    if binding != 0 and binding_at(binding).leads == 0.0:
        return
    if not has_own_state(m, d, instance):  # binds it in a copy
        return
    bound = binding_at(binding_of(d, instance, SHEATH))
    if bound.leads != 0.0 and bound.controls != control_signature(m, d):
        _compute_passive_again(m, d)


@entry("tendon_mj_sheath_advance", "void(ptr, ptr, i32)")
def advance(m: int, d: int, instance: int) -> None:
    """`advance` of `mjpPlugin`."""
    if is_sensor(m, instance):
        return
    address = state_of(m, d, instance)
    state = state_at(address)
    if state.has_trial == 0.0:
        if _is_skipped(m):
            # it was not evaluated at all, as where MuJoCo finds the range of a muscle's length
            state.unsolved += 1.0
    elif is_bound(m, d, instance):
        commit(address)
        follow_constraint(m, d, state)


@entry("tendon_mj_sheath_reset", "void(ptr, ptr, ptr, i32)")
def reset(m: int, state: int, block: int, instance: int) -> None:
    """`reset` of `mjpPlugin`."""
    binding = block + 8 if block != 0 and pointer(block) == SHEATH else 0
    if is_sensor(m, instance):
        doubles(state, state_size_of(m, instance))[:] = 0.0
    else:
        reset_sheath(m, state, binding, instance)


@entry("tendon_mj_sheath_nstate", "i32(ptr, i32)")
def nstate(m: int, instance: int) -> int:
    """`nstate` of `mjpPlugin`."""
    if asks(SHEATH_NSTATE):
        return ask_size(SHEATH_NSTATE, m, instance)
    return sheath_state(m, instance)


@entry("tendon_mj_sheath_nsensordata", "i32(ptr, i32, i32)")
def nsensordata(m: int, instance: int, sensor: int) -> int:
    """`nsensordata` of `mjpPlugin`."""
    if asks(SHEATH_NSENSORDATA):
        return ask_sensor_size(SHEATH_NSENSORDATA, m, instance, sensor)
    return sensor_width(m, instance)


@entry("tendon_mj_sheath_init", "i32(ptr, ptr, i32)")
def init(m: int, d: int, instance: int) -> int:
    """`init` of `mjpPlugin`."""
    if asks(SHEATH_INIT):
        ask_complete(SHEATH_INIT, m, d, instance)
    else:
        sheath_state(m, instance)  # of a binary model, whose `nstate` MuJoCo does not ask
        if not is_sensor(m, instance):
            check_bindable(m, d, instance)
    set_pointer(pointer(d + LAYOUT.d_plugin_data) + 8 * instance, 0)
    return 0


@entry("tendon_mj_sheath_destroy", "void(ptr, i32)")
def destroy(d: int, instance: int) -> None:
    """`destroy` of `mjpPlugin`."""
    release(d, instance)


@entry("tendon_mj_sheath_compute", "void(ptr, ptr, i32, i32)")
def compute(m: int, d: int, instance: int, capability: int) -> None:
    """`compute` of `mjpPlugin`."""
    if is_sensor(m, instance):
        if capability == _SENSOR:
            show(m, d, instance)
        return
    if capability == _PASSIVE:
        _evaluate(m, d, instance, False)
    elif capability == _ACTUATOR:
        if _is_skipped(m):  # a sheath acts after the actuators then
            _evaluate(m, d, instance, True)
        else:
            _meet_late_controls(m, d, instance)
        _quiet_reel(m, d, instance)
    elif capability == _SENSOR:
        show_ends(m, d, instance)
        binding = binding_of(d, instance, SHEATH)
        if binding != 0 and binding_at(binding).first_sheath == instance:
            add_reactions(m, d, instance, _is_skipped(m))


@compiled
def _evaluate(m: int, d: int, instance: int, late: bool) -> None:
    """Evaluate a sheath; warn of the first evaluation since the reset that was not solved."""
    if not ensure_bound(m, d, instance):
        return
    address = state_of(m, d, instance)
    state = state_at(address)
    if late and state.driven != 0.0:  # it needs the forces of all actuators: not there yet
        return
    before = state.unsolved
    if state.leads != 0.0:
        binding_at(binding_of(d, instance, SHEATH)).controls = control_signature(m, d)
    evaluate(m, d, address)
    if before == 0.0 and state.unsolved > 0.0:
        _warn(m, instance)
