"""Control law of the servo: τ = G_t r ΔT − G_v θ̇, with observer, feed-forward and limits.

ΔT is the reference less the tension that the sensor or the observer shows, and what the
feed-forward adds for the backlash and for the rate of the reference. Equations: docs/servo.md; K_ap
is equation (18) of docs/theory.md, which `theory.stiffness` has too: neither imports the other, so
that their agreement is evidence.
"""

from __future__ import annotations

import math

from tendon_mj.native import compiled
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.abi.library import RK4, control, is_stage
from tendon_mj.plugin.abi.memory import address_of
from tendon_mj.plugin.force_servo_plugin.state import (
    TRIAL,
    Commands,
    Memory,
    State,
    commands_at,
    scratch_memory,
    state_at,
    trial_memory,
)
from tendon_mj.plugin.sheath_plugin.state import State as Sheath
from tendon_mj.plugin.sheath_plugin.state import state_at as sheath_at
from tendon_mj.plugin.sheath_plugin.state import unpack
from tendon_mj.sheath import Guides, Segments

_STRAIGHT = 1e-6  # friction exponents below this are none


@compiled
def play(estimate: float, input_tension: float, exponent: float) -> float:
    """T̂_out ← clip(T̂_out, T_in e^{−λ}, T_in e^{λ}), the sheath seen from its input end [N]."""
    low, high = input_tension * math.exp(-exponent), input_tension * math.exp(exponent)
    return min(max(estimate, low), high)


@compiled
def stiffness_ahead(exponent: float, sense: float, tendon: float, output: float) -> float:
    """K_t(±λ) [N/m] of a tendon that slides, 1/K_t = 1/k_se + 1/K_ap, K_ap = K_w λ/(e^λ − 1).

    Args:
        exponent: |λ|.
        sense: its sign, +1 pulling.
        tendon: K_w = EA/L [N/m].
        output: k_se [N/m]; 0: not known, taken as rigid.
    """
    lam = sense * exponent
    apparent = tendon
    if exponent > _STRAIGHT:
        apparent = tendon * lam / math.expm1(lam)
    return apparent if output == 0.0 else 1.0 / (1.0 / output + 1.0 / apparent)


@compiled
def backlash_ahead(
    exponent: float, sense: float, tendon: float, input_tension: float, output_tension: float
) -> float:
    """Travel of the input that is left until the output follows in direction ``sense`` [m].

    The tendon once slid the other way; over the friction angle d from the input it slides this
    way already, e^{2sd} = e^{sλ} (T_in/T_out). The rest is the integral of the difference to a
    tendon that slides all along:
    Δξ = s (T_out (e^{sλ} + e^{−s(λ−d)} − 2) − T_in (1 − e^{−sd}))/(K_w λ),
    from the whole reversal backlash for d = 0 to nothing for d = λ.

    Args:
        exponent: λ ≥ 0.
        sense: s, +1 pulling.
        tendon: K_w = EA/L [N/m].
        input_tension, output_tension: T_in and T_out [N].
    """
    if not (exponent > _STRAIGHT and input_tension > 0.0 and output_tension > 0.0):
        return 0.0
    slid = 0.5 * (exponent + sense * math.log(input_tension / output_tension))
    slid = min(max(slid, 0.0), exponent)
    stretched = output_tension * (
        math.expm1(sense * exponent) + math.expm1(-sense * (exponent - slid))
    )
    return sense * (stretched + input_tension * math.expm1(-sense * slid)) / (tendon * exponent)


@compiled
def limited(
    torque: float, load: float, speed: float, inertia: float, h: float, top: float
) -> float:
    """Torque that, with ``load``, will not carry the motor beyond ``top`` (0: none) in a step."""
    if top == 0.0:
        return torque
    low, high = inertia * (-top - speed) / h, inertia * (top - speed) / h
    return min(max(torque + load, low), high) - load


@compiled
def _of_actuators(m: Model, d: Data, dof: int, own: int) -> float:
    """Torque of the other actuators on a degree of freedom, each within its range of forces.

    MuJoCo has not summed them up yet. Those that a plugin drives come in the order of the plugins'
    instances, so that of a later one is still 0.
    """
    forces, moments = d.actuator_force, d.actuator_moment
    columns = d.moment_colind
    total = 0.0
    for actuator in range(m.nactuator):
        if actuator == own:
            continue
        first = m.actuator_outadr[actuator]
        for row in range(first, first + m.actuator_outnum[actuator]):
            force = forces[row]
            if m.actuator_forcelimited[actuator]:
                limits = m.actuator_forcerange[actuator]
                force = min(max(force, limits[0]), limits[1])
            start = d.moment_rowadr[row]
            for k in range(start, start + d.moment_rownnz[row]):
                if columns[k] == dof:
                    total += moments[k] * force
    return total


@compiled
def known_torque(m: Model, d: Data, dof: int, own: int) -> float:
    """Torque on a degree of freedom but for actuator ``own`` and constraints [N m].

    Springs, dampers, gravity, the tendon on its spool, applied forces, other actuators.
    Forces of contacts, limits and dry friction follow later in the step, from all of this.
    """
    return (
        d.qfrc_passive[dof] + d.qfrc_applied[dof] - d.qfrc_bias[dof] + _of_actuators(m, d, dof, own)
    )


_EARLY = 1e-6  # share of a time step by which a time counts as reached
_MOVED = 0.01  # share by which the output has to move for a backlash to be crossed


@compiled
def _note_reversal(
    memory: Memory, first: bool, reference: float, tension: float, band: float
) -> None:
    """Update the memory where the reference turns back and where the output has followed."""
    sense = memory.sense
    if first:
        memory.turned_at = reference
    change = reference - memory.turned_at
    way = 1.0 if change > 0.0 else -1.0
    if change != 0.0 and way == sense:
        memory.turned_at = reference
    elif abs(change) > band:
        memory.sense, memory.turned_at = way, reference
        memory.crossing, memory.mark = 1.0, tension
    if memory.crossing != 0.0:
        sense = memory.sense
        if sense * (tension - memory.mark) < 0.0:
            memory.mark = tension
        elif sense * (tension - memory.mark) > _MOVED * memory.mark:
            memory.crossing = 0.0


@compiled
def _sample(
    state: State,
    memory: Memory,
    sheath: Sheath,
    segments: Segments,
    guides: Guides,
    reference: float,
    time: float,
) -> float:
    """Tension that the motor is to bring up [N]: error and feed-forward; updates the memory."""
    gains = state.gains
    ea, last = sheath.law.axial_stiffness, len(guides)
    pulled, output = ea * segments[0].tension, ea * segments[last].tension
    exponent = gains.observer_friction * sum(guides["angle"])
    first = state.started == 0.0
    if first:
        memory.estimate = pulled  # before any motion the tension is the same all along
    memory.estimate = play(memory.estimate, pulled, exponent)
    seen = memory.estimate if state.observes != 0.0 else output
    if not math.isfinite(reference):
        reference = seen
    _note_reversal(memory, first, reference, seen, gains.reversal_band)
    wanted, sense = reference - seen, memory.sense
    if sense != 0.0 and (gains.backlash_feedforward != 0.0 or gains.rate_feedforward != 0.0):
        tendon = ea / sum(segments["length"])
        stiffness = stiffness_ahead(exponent, sense, tendon, gains.output_stiffness)
        if memory.crossing != 0.0:
            ahead = backlash_ahead(exponent, sense, tendon, pulled, seen)
            wanted += gains.backlash_feedforward * stiffness * ahead
        since = time - memory.time
        if since > 0.0 and not first:
            rate = (reference - memory.reference) / since
            radius = sheath.reel_radius
            gain = gains.tension_gain if sense > 0.0 else gains.loosening_tension_gain
            damping = gains.velocity_gain if sense > 0.0 else gains.loosening_velocity_gain
            speed = rate / (radius * stiffness)
            wanted += gains.rate_feedforward * damping * speed / (gain * radius)
    memory.reference, memory.time = reference, time
    return wanted


@compiled
def _arrived(state: State, ring: Commands, time: float, early: float, stage: bool) -> float:
    """The newest command that has had its delay [N m]; 0 before the first one."""
    gains = state.gains
    due = time - gains.delay + early
    taken = state.trial_time if stage else time
    if state.sampled != 0.0 and taken <= due:
        return state.trial_torque
    for back in range(1, int(state.count) + 1):
        k = (int(state.head) - back) % len(ring)
        if ring[k].time <= due:
            return ring[k].torque
    return 0.0


@compiled
def _driven(state: State, wanted: float, speed: float, radius: float) -> tuple[float, float]:
    """Torque G_t r ΔT [N m] and damping G_v [N m s/rad] for the direction of the motion."""
    gains = state.gains
    way = speed * radius if speed != 0.0 else wanted
    if way >= 0.0:
        return gains.tension_gain * radius * wanted, gains.velocity_gain
    return gains.loosening_tension_gain * radius * wanted, gains.loosening_velocity_gain


@compiled
def _is_due(state: State, time: float, early: float) -> bool:
    """Return whether the controller samples now; stores the index of the sample on trial."""
    gains = state.gains
    if gains.period == 0.0:
        return True
    state.trial_sample = math.floor((time + early) / gains.period)
    return state.started == 0.0 or state.trial_sample != state.sample


@compiled
def evaluate(m: Model, d: Data, address: int) -> None:
    """Torque for the tension at hand, from the committed state; see docs/servo.md."""
    state, ring = state_at(address), commands_at(address)
    gains, actuator = state.gains, int(state.actuator)
    if actuator < 0 or state.sheath < 0.0:
        return
    place = address_of(d.plugin_state) + 8 * int(state.sheath)
    sheath = sheath_at(place)
    segments, guides, _ = unpack(place)
    time, h = d.time, m.opt.timestep
    dof = m.jnt_dofadr[int(sheath.reel_joint)]
    speed, radius = d.qvel[dof], sheath.reel_radius
    spool = sheath.reel_torque  # which has just been applied
    adr = m.actuator_outadr[actuator]
    if not math.isfinite(spool):
        d.actuator_force[adr], state.has_trial = 0.0, 0.0
        return
    held = 0.0 if state.backdriven != 0.0 else spool  # by a gear that cannot be driven back
    load = known_torque(m, d, dof, actuator) + held
    stage = is_stage(m, time, state.has_trial, state.trial_time)
    sampled, early = len(ring) > 0, _EARLY * h

    memory = trial_memory(address, scratch_memory() if stage else address + TRIAL)
    torque = damping = 0.0
    if not (stage and sampled):  # a controller with a clock does not see inside a step
        due = _is_due(state, time, early)
        if due:
            reference = control(m, d, actuator)
            wanted = _sample(state, memory, sheath, segments, guides, reference, time)
            torque, damping = _driven(state, wanted, speed, radius)
        state.sampled, state.trial_torque = due, torque - damping * speed
    if sampled:
        torque = _arrived(state, ring, time, early, stage)
    elif m.opt.integrator == RK4:
        torque -= damping * speed
    else:  # the damping as at the end of the step, whatever else turns the motor: always stable
        torque -= damping * speed
        torque = (torque + load) / (1.0 + h * damping / gains.motor_inertia) - load
    torque = limited(torque, load, speed, gains.motor_inertia, h, gains.speed_limit)
    if gains.torque_limit > 0.0:
        torque = min(max(torque, -gains.torque_limit), gains.torque_limit)
    if not stage:
        state.trial_time, state.has_trial = time, 1.0
    d.actuator_force[adr] = torque + held


@compiled
def commit(address: int) -> None:
    """Make the step on trial the committed state, and send off its command."""
    state, ring = state_at(address), commands_at(address)
    if state.has_trial == 0.0:
        return
    state.committed = state.trial
    state.started, state.has_trial = 1.0, 0.0
    capacity = len(ring)
    if capacity > 0 and state.sampled != 0.0:
        head = int(state.head)
        ring[head].time, ring[head].torque = state.trial_time, state.trial_torque
        state.head = (head + 1) % capacity
        state.count = min(state.count + 1.0, capacity)
        state.sample = state.trial_sample
