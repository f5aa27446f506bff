"""Evaluation of a servo within a time step: torque of its motor, and memory of the step."""

from __future__ import annotations

import math

from tendon_mj.compilation import compiled
from tendon_mj.plugin.abi.control import control
from tendon_mj.plugin.abi.layout import Layout
from tendon_mj.plugin.abi.memory import double, doubles, integer, pointer
from tendon_mj.plugin.abi.runge_kutta import RK4, is_stage
from tendon_mj.plugin.servo_plugin.control_law import backlash_ahead, limited, play, stiffness_ahead
from tendon_mj.plugin.servo_plugin.motor_load import known_torque
from tendon_mj.plugin.servo_plugin.state import (
    Commands,
    Memory,
    State,
    commands_at,
    committed_memory,
    state_at,
    trial_memory,
)
from tendon_mj.plugin.sheath_plugin.state import State as Sheath
from tendon_mj.plugin.sheath_plugin.state import state_at as sheath_at
from tendon_mj.plugin.sheath_plugin.state import unpack
from tendon_mj.sheath import Guides, Segments

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
    """Whether the controller samples now; stores the index of the sample on trial."""
    gains = state.gains
    if gains.period == 0.0:
        return True
    state.trial_sample = math.floor((time + early) / gains.period)
    return state.started == 0.0 or state.trial_sample != state.sample


@compiled
def evaluate(layout: Layout, m: int, d: int, address: int) -> None:
    """Torque for the tension at hand, from the committed state; see docs/servo.md."""
    state, ring = state_at(address), commands_at(address)
    gains, actuator = state.gains, int(state.actuator)
    if actuator < 0 or state.sheath < 0.0:
        return
    states = pointer(d + layout.d_plugin_state)
    place = states + 8 * int(state.sheath)
    sheath = sheath_at(place)
    segments, guides, _ = unpack(place)
    time, h = double(d + layout.d_time, 0), double(m + layout.o_timestep, 0)
    dof = integer(pointer(m + layout.m_jnt_dofadr), int(sheath.reel_joint))
    speed, radius = double(pointer(d + layout.d_qvel), dof), sheath.reel_radius
    spool = sheath.reel_torque  # which has just been applied
    adr = integer(pointer(m + layout.m_actuator_outadr), actuator)
    force = doubles(pointer(d + layout.d_actuator_force) + 8 * adr, 1)
    if not math.isfinite(spool):
        force[0], state.has_trial = 0.0, 0.0
        return
    held = 0.0 if state.backdriven != 0.0 else spool  # by a gear that cannot be driven back
    load = known_torque(layout, m, d, dof, actuator) + held
    stage = is_stage(layout, m, time, state.has_trial, state.trial_time)
    sampled, early = len(ring) > 0, _EARLY * h

    memory = trial_memory(address, stage)
    torque = damping = 0.0
    if not (stage and sampled):  # a controller with a clock does not see inside a step
        memory[0] = committed_memory(address)[0]
        due = _is_due(state, time, early)
        if due:
            reference = control(layout, m, d, actuator)
            wanted = _sample(state, memory[0], sheath, segments, guides, reference, time)
            torque, damping = _driven(state, wanted, speed, radius)
        state.sampled, state.trial_torque = due, torque - damping * speed
    if sampled:
        torque = _arrived(state, ring, time, early, stage)
    elif integer(m + layout.o_integrator, 0) == RK4:
        torque -= damping * speed
    else:  # the damping as at the end of the step, whatever else turns the motor: always stable
        torque -= damping * speed
        torque = (torque + load) / (1.0 + h * damping / gains.motor_inertia) - load
    torque = limited(torque, load, speed, gains.motor_inertia, h, gains.speed_limit)
    if gains.torque_limit > 0.0:
        torque = min(max(torque, -gains.torque_limit), gains.torque_limit)
    if not stage:
        state.trial_time, state.has_trial = time, 1.0
    force[0] = torque + held


@compiled
def commit(address: int) -> None:
    """Make the step on trial the committed state, and send off its command."""
    state, ring = state_at(address), commands_at(address)
    if state.has_trial == 0.0:
        return
    committed_memory(address)[0] = trial_memory(address, False)[0]
    state.started, state.has_trial = 1.0, 0.0
    capacity = len(ring)
    if capacity > 0 and state.sampled != 0.0:
        head = int(state.head)
        ring[head].time, ring[head].torque = state.trial_time, state.trial_torque
        state.head = (head + 1) % capacity
        state.count = min(state.count + 1.0, capacity)
        state.sample = state.trial_sample
