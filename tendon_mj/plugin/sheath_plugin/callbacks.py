"""The functions of `mjpPlugin` that MuJoCo calls while it runs; no Python among them.

An instance is either a sheath, which acts on its tendon, or one with a `sensor` attribute, whose
sensors show a quantity of sheaths and which keeps in its state which sheaths these are.
"""

from __future__ import annotations

import mujoco

from tendon_mj.native import Text, apart, compiled, entry
from tendon_mj.plugin import compiled_checks
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.abi.library import (
    free,
    malloc,
    mj_fwdActuation,
    mj_passive,
    mj_referenceConstraint,
    mj_rne,
    warn,
)
from tendon_mj.plugin.abi.memory import (
    address_of,
    coordinates,
    copy_doubles,
    doubles,
    letters,
    word,
)
from tendon_mj.plugin.sheath_plugin import attributes as at
from tendon_mj.plugin.sheath_plugin import bind, evaluate, groups, trial
from tendon_mj.plugin.sheath_plugin.forces import add_reactions
from tendon_mj.plugin.sheath_plugin.inextensible import keep_slips, keep_unknown_forces
from tendon_mj.plugin.sheath_plugin.input_force import follow_constraint, is_pushed, pulls
from tendon_mj.plugin.sheath_plugin.name_lookup import own_name
from tendon_mj.plugin.sheath_plugin.sensors import show, show_ends
from tendon_mj.plugin.sheath_plugin.signature import pose_signature, pose_sum
from tendon_mj.plugin.sheath_plugin.state import (
    SHEATH,
    WORKSPACE,
    binding_at,
    binding_of,
    has_play,
    state_at,
    state_of,
    state_size_of,
)

_ACTUATION_OFF = mujoco.mjtDisableBit.mjDSBL_ACTUATION.value
_DCMOTOR = mujoco.mjtBias.mjBIAS_DCMOTOR.value
_ACTUATOR, _SENSOR, _PASSIVE = 1, 2, 4  # mjtPluginCapabilityBit
_PASSIVE_OFF = mujoco.mjtDisableBit.mjDSBL_SPRING.value | mujoco.mjtDisableBit.mjDSBL_DAMPER.value
_WARNING = Text("tendon_mj: sheath '")
_UNNAMED = Text("")
_REASONS = Text(
    "' was not solved in an evaluation: a control is not finite, more tendon is wound in than there"
    " is, a stretch has no length, or the solver did not converge; its sensor `unsolved` counts"
    " them"
)
_PUSHED = Text(
    "' is pushed by a motor: MuJoCo pulls with a force below 0, and one above 0 passes the sheath"
    ' without friction; pull with a negative ctrl, or give the motor gear="-1"'
)


@apart
def _warn_once(m: Model, d: Data, instance: int) -> None:
    """Warn of the first evaluation of a sheath since the reset that was not solved."""
    state = state_at(state_of(m, d, instance))
    if state.unsolved > 0.0 and state.warned == 0.0:
        state.warned = 1.0
        name = own_name(m, instance)
        warn(_WARNING(), name if name != 0 else _UNNAMED(), _REASONS())


@compiled
def _warn_of_push(m: Model, d: Data, instance: int) -> None:
    """Warn of the first finished step of a simulation in which a motor pushed a driven tendon."""
    bound = binding_at(binding_of(d, instance, SHEATH))
    if bound.driven == 0.0 or bound.push_warned != 0.0:
        return
    if is_pushed(m, d, state_at(state_of(m, d, instance))):
        bound.push_warned = 1.0
        name = own_name(m, instance)
        warn(_WARNING(), name if name != 0 else _UNNAMED(), _PUSHED())


@compiled
def _is_skipped(m: Model) -> bool:
    """Return whether MuJoCo leaves all passive forces out, those of plugins too."""
    return m.opt.disableflags & _PASSIVE_OFF == _PASSIVE_OFF


@compiled
def _quiet_reel(m: Model, d: Data, instance: int) -> None:
    """A reel acts through the tendon's length, not through a force of its own."""
    reel = state_at(state_of(m, d, instance)).reel_actuator
    if not 0.0 <= reel < m.nactuator:
        return
    if m.actuator_plugin[int(reel)] == instance:
        d.actuator_force[m.actuator_outadr[int(reel)]] = 0.0


@compiled
def _apply(m: Model, d: Data, work: int) -> None:
    """Add the friction of all driven sheaths to the passive forces before it."""
    nv = m.nv
    before = coordinates(groups.vector_at(work, nv, groups.BASE))
    added = coordinates(groups.vector_at(work, nv, groups.FRICTION))
    passive = d.qfrc_passive
    for k in range(nv):
        passive[k] = before[k] + added[k]


@compiled
def _solve(m: Model, d: Data, work: int) -> None:
    """Solve all driven sheaths, and apply their friction."""
    evaluate.solve_driven(m, d, work)
    _apply(m, d, work)
    sheaths = groups.driven_sheaths(work, m.nv)
    for k in range(int(groups.head_at(work).driven)):
        _warn_once(m, d, int(sheaths[k]))


@compiled
def _is_actuated(m: Model) -> bool:
    """Return whether MuJoCo computes actuators, after passive forces."""
    off = m.opt.disableflags & _ACTUATION_OFF != 0
    return m.nactuator > 0 and not off


@compiled
def _is_listed(m: Model, binding: int) -> bool:
    """Return whether the last sheath's workspace lists the driven sheaths of the model as it is."""
    if binding == 0 or word(binding + WORKSPACE) == 0:
        return False
    bound = binding_at(binding)
    return bound.listed_for == bound.signature


@apart
def _evaluate_driven(m: Model, d: Data, last: int) -> None:
    """Set up all driven sheaths, which the last sheath does for all of them.

    They are solved once MuJoCo has computed actuators. `mj_inverse` does not: what it shows is the
    friction that was shown last, or, in another pose, that of tendons that slide as they move.
    """
    binding, nv = binding_of(d, last, SHEATH), m.nv
    bound = binding_at(binding)
    first = int(bound.first_sheath)
    if not _is_listed(m, binding):  # all of them have been bound by now
        evaluate.list_driven(m, d, groups.workspace(m, d, first, last), first, last)
        bound.listed_for = bound.signature
    work = word(binding + WORKSPACE)
    head = groups.head_at(work)
    if head.driven == 0.0:
        return
    copy_doubles(groups.vector_at(work, nv, groups.BASE), address_of(d.qfrc_passive), nv)
    if head.gives == 0.0:
        pose = pose_signature(m, d)
        moves = head.signature != pose
        evaluate.read_inputs(m, d, work)
        evaluate.set_up_driven(m, d, work, first)
        head.signature = pose
        if _is_actuated(m):
            evaluate.repeat_driven(m, d, work, moves)
        else:
            bias = malloc(8 * nv)
            copy_doubles(bias, address_of(d.qfrc_bias), nv)
            mj_rne(m, d, 0, d.qfrc_bias)
            mj_referenceConstraint(m, d)
            _solve(m, d, work)
            copy_doubles(address_of(d.qfrc_bias), bias, nv)
            free(bias)
    _apply(m, d, work)


@apart
def _limit_forces(m: Model, d: Data) -> None:
    """Clamp the forces of actuators as MuJoCo will: the sum on a tendon, then each."""
    forces, adr, count = d.actuator_force, m.actuator_outadr, m.nactuator
    for tendon in range(m.ntendon):
        if not m.tendon_actfrclimited[tendon]:
            continue
        total = 0.0
        for k in range(count):
            if pulls(m, k, tendon):
                total += forces[adr[k]]
        limits = m.tendon_actfrcrange[tendon]
        bound = min(max(total, limits[0]), limits[1])
        for k in range(count):
            if bound != total and pulls(m, k, tendon):
                forces[adr[k]] *= bound / total
    for k in range(count):
        if m.actuator_forcelimited[k]:
            limits = m.actuator_forcerange[k]
            for out in range(m.actuator_outnum[k]):
                force = forces[adr[k] + out]
                forces[adr[k] + out] = min(max(force, limits[0]), limits[1])


@apart
def _has_mechanical(m: Model) -> bool:
    """Return whether an actuator has forces that MuJoCo adds after it has clamped all."""
    found = False
    for k in range(m.nactuator):
        found |= m.actuator_biastype[k] == _DCMOTOR
    return found


@apart
def _meet_actuators(m: Model, d: Data, last: int) -> None:
    """Let friction meet the forces of actuators, which MuJoCo has before it clamps them by now.

    It adds those of some, and those of plugins that come later, after that: then actuators are
    computed once more to know them.
    """
    listed = _is_listed(m, binding_of(d, last, SHEATH))
    if not listed:
        first = at.first_sheath(m, last)
        for instance in range(first, last + 1):
            if at.is_sheath(m, instance, last):
                bind.has_own_state(m, d, instance)  # binds it in a copy
        if binding_of(d, last, SHEATH) == 0:
            return
        evaluate.list_driven(m, d, groups.workspace(m, d, first, last), first, last)
    bound = binding_at(binding_of(d, last, SHEATH))
    work = word(binding_of(d, last, SHEATH) + WORKSPACE)
    head = groups.head_at(work)
    if head.driven == 0.0 or head.is_nested != 0.0:
        return
    known = listed and head.signature == pose_signature(m, d)
    forces, count = address_of(d.actuator_force), m.nout
    kept = malloc(8 * count)
    copy_doubles(kept, forces, count)
    if bound.is_last_plugin == 0.0 or _has_mechanical(m):
        head.is_nested = 1.0
        mj_fwdActuation(m, d)
        head.is_nested = 0.0
    else:
        _limit_forces(m, d)
    skipped = _is_skipped(m)
    if not known:
        if skipped:
            _evaluate_driven(m, d, last)
        else:
            mj_passive(m, d)  # in a copy they were computed elsewhere
    evaluate.read_inputs(m, d, work)
    _solve(m, d, work)
    if bound.is_last_plugin == 0.0 and not skipped:
        head.gives = 1.0
        mj_passive(m, d)  # as other plugins have added to them
        head.gives = 0.0
    copy_doubles(forces, kept, count)
    free(kept)


@entry("tendon_mj_sheath_advance", "void(mjModel, mjData, i32)")
def advance(m: Model, d: Data, instance: int) -> None:
    """`advance` of `mjpPlugin`."""
    if at.is_sensor(m, instance):
        return
    address = state_of(m, d, instance)
    state = state_at(address)
    is_ours = bind.is_bound(m, d, instance)
    if at.first_sheath(m, instance) == instance:
        state.end_sum = pose_sum(m, d)
        last, drives = at.last_sheath(m, instance), False
        for other in range(instance, last + 1):
            if at.is_sheath(m, other, instance):
                sheath = state_at(state_of(m, d, other))
                sheath.slips_kept = 0.0
                drives |= sheath.inextensible != 0.0
        if is_ours and drives:
            keep_unknown_forces(m, d, instance)
            binding = binding_of(d, last, SHEATH)
            if _is_actuated(m) and _is_listed(m, binding):  # else its pose may be that of a copy
                keep_slips(m, d, word(binding + WORKSPACE))
    if state.has_trial != 0.0 and is_ours:
        trial.commit(address)
        _warn_of_push(m, d, instance)
        follow_constraint(m, d, state)


@entry("tendon_mj_sheath_reset", "void(mjModel, ptr, ptr, i32)")
def reset(m: Model, state: int, block: int, instance: int) -> None:
    """`reset` of `mjpPlugin`."""
    binding = block + 8 if block != 0 and word(block) == SHEATH else 0
    if at.is_sensor(m, instance):
        doubles(state, state_size_of(m, instance))[:] = 0.0
    else:
        bind.reset_sheath(m, state, binding, instance)


@entry("tendon_mj_sheath_nstate", "i32(mjModel, i32)")
def nstate(m: Model, instance: int) -> int:
    """`nstate` of `mjpPlugin`."""
    out = compiled_checks.message()
    letters(out)[0] = 0
    return compiled_checks.sheath_state(m, out, instance)


@entry("tendon_mj_sheath_nsensordata", "i32(mjModel, i32, i32)")
def nsensordata(m: Model, instance: int, sensor: int) -> int:
    """`nsensordata` of `mjpPlugin`."""
    return compiled_checks.sensor_width(m, instance)


@entry("tendon_mj_sheath_init", "i32(mjModel, mjData, i32)")
def init(m: Model, d: Data, instance: int) -> int:
    """`init` of `mjpPlugin`."""
    out = compiled_checks.message()
    letters(out)[0] = 0
    compiled_checks.sheath_state(m, out, instance)
    compiled_checks.check_more(m, out, instance)
    compiled_checks.check_elements(m, out, instance)
    if not (compiled_checks.has_refused(out) or at.is_sensor(m, instance)):
        bind.check_bindable(m, out, instance)
    compiled_checks.refuse(out, d, instance)
    d.plugin_data[instance] = 0
    return 0


@entry("tendon_mj_sheath_destroy", "void(mjData, i32)")
def destroy(d: Data, instance: int) -> None:
    """`destroy` of `mjpPlugin`."""
    bind.release(d, instance)


@entry("tendon_mj_sheath_compute", "void(mjModel, mjData, i32, i32)")
def compute(m: Model, d: Data, instance: int, capability: int) -> None:
    """`compute` of `mjpPlugin`."""
    if at.is_sensor(m, instance):
        if capability == _SENSOR:
            show(m, d, instance)
        return
    if capability == _PASSIVE:
        _evaluate(m, d, instance)
        if _is_last(m, d, instance):
            _evaluate_driven(m, d, instance)
    elif capability == _ACTUATOR:
        if _is_skipped(m):  # a sheath acts after the actuators then
            _evaluate(m, d, instance)
        _quiet_reel(m, d, instance)
        if _is_last(m, d, instance):
            _meet_actuators(m, d, instance)
    elif capability == _SENSOR:
        show_ends(m, d, instance)
        binding = binding_of(d, instance, SHEATH)
        if binding != 0 and binding_at(binding).first_sheath == instance:
            add_reactions(m, d, instance, _is_skipped(m))


@compiled
def _evaluate(m: Model, d: Data, instance: int) -> None:
    """Evaluate a sheath, and with the last one all that are driven."""
    if bind.ensure_bound(m, d, instance):
        evaluate.evaluate(m, d, instance)
        _warn_once(m, d, instance)
        if has_play(state_at(state_of(m, d, instance))):  # then others before it are solved, too
            for other in range(instance):
                if at.is_sheath(m, other, instance):
                    _warn_once(m, d, other)


@compiled
def _is_last(m: Model, d: Data, instance: int) -> bool:
    """Return whether an instance is the last sheath of its model."""
    binding = binding_of(d, instance, SHEATH)
    last = int(binding_at(binding).last_sheath) if binding != 0 else at.last_sheath(m, instance)
    return last == instance
