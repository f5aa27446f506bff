"""A servo's part in a time step: what torque its motor gets, and what it remembers."""

from __future__ import annotations

import math
from typing import Any

from tendon_mj.compilation import compiled
from tendon_mj.engine.abi.memory import double, doubles, integer, pointer
from tendon_mj.engine.servo_plugin import state as sv
from tendon_mj.engine.servo_plugin.law import backlash_ahead, limited, play, stiffness_ahead
from tendon_mj.engine.servo_plugin.load import known_torque
from tendon_mj.engine.sheath_plugin import state as st
from tendon_mj.engine.sheath_plugin.moment import RK4, control, is_stage
from tendon_mj.sheath.tables import LENGTH, TENSION

_EARLY = 1e-6  # share of a time step by which a time counts as reached
_MOVED = 0.01  # share by which the output has to move for a backlash to be crossed


@compiled
def _turn(memory: Any, first: bool, reference: float, tension: float, band: float) -> None:
    """Notice when the reference turns back, and when the output has followed."""
    sense = memory[sv.SENSE]
    if first:
        memory[sv.TURNED_AT] = reference
    change = reference - memory[sv.TURNED_AT]
    way = 1.0 if change > 0.0 else -1.0
    if change != 0.0 and way == sense:
        memory[sv.TURNED_AT] = reference
    elif abs(change) > band:
        memory[sv.SENSE], memory[sv.TURNED_AT] = way, reference
        memory[sv.CROSSING], memory[sv.MARK] = 1.0, tension
    if memory[sv.CROSSING] != 0.0:
        sense = memory[sv.SENSE]
        if sense * (tension - memory[sv.MARK]) < 0.0:
            memory[sv.MARK] = tension
        elif sense * (tension - memory[sv.MARK]) > _MOVED * memory[sv.MARK]:
            memory[sv.CROSSING] = 0.0


@compiled
def _sample(
    s: Any, memory: Any, sheath: Any, segments: Any, guides: Any, reference: float, time: float
) -> float:
    """Tension that the motor is to bring up [N]: error and feed-forward; the memory moves on."""
    ea, last = sheath[st.AXIAL_STIFFNESS], guides.shape[1]
    pulled, output = ea * segments[TENSION, 0], ea * segments[TENSION, last]
    exponent = s[sv.OBSERVER_FRICTION] * sum(guides[st.ANGLE])
    first = s[sv.STARTED] == 0.0
    if first:
        memory[sv.ESTIMATE] = pulled  # before any motion the tension is the same all along
    memory[sv.ESTIMATE] = play(memory[sv.ESTIMATE], pulled, exponent)
    seen = memory[sv.ESTIMATE] if s[sv.OBSERVES] != 0.0 else output
    if not math.isfinite(reference):
        reference = seen
    _turn(memory, first, reference, seen, s[sv.REVERSAL_BAND])
    wanted, sense = reference - seen, memory[sv.SENSE]
    if sense != 0.0 and (s[sv.BACKLASH_FEEDFORWARD] != 0.0 or s[sv.RATE_FEEDFORWARD] != 0.0):
        tendon = ea / sum(segments[LENGTH])
        stiffness = stiffness_ahead(exponent, sense, tendon, s[sv.OUTPUT_STIFFNESS])
        if memory[sv.CROSSING] != 0.0:
            ahead = backlash_ahead(exponent, sense, tendon, pulled, seen)
            wanted += s[sv.BACKLASH_FEEDFORWARD] * stiffness * ahead
        since = time - memory[sv.TIME]
        if since > 0.0 and not first:
            rate = (reference - memory[sv.REFERENCE]) / since
            radius = sheath[st.REEL_RADIUS]
            gain = s[sv.TENSION_GAIN if sense > 0.0 else sv.LOOSENING_TENSION_GAIN]
            damping = s[sv.VELOCITY_GAIN if sense > 0.0 else sv.LOOSENING_VELOCITY_GAIN]
            speed = rate / (radius * stiffness)
            wanted += s[sv.RATE_FEEDFORWARD] * damping * speed / (gain * radius)
    memory[sv.REFERENCE], memory[sv.TIME] = reference, time
    return wanted


@compiled
def _arrived(s: Any, ring: Any, time: float, early: float, stage: bool) -> float:
    """The newest command that has had its delay [N m]; 0 before the first one."""
    due = time - s[sv.DELAY] + early
    taken = s[sv.TRIAL_TIME] if stage else time
    if s[sv.SAMPLED] != 0.0 and taken <= due:
        return s[sv.TRIAL_TORQUE]
    for back in range(1, int(s[sv.COUNT]) + 1):
        k = (int(s[sv.HEAD]) - back) % ring.shape[0]
        if ring[k, 0] <= due:
            return ring[k, 1]
    return 0.0


@compiled
def _driven(s: Any, wanted: float, speed: float, radius: float) -> tuple[float, float]:
    """Torque G_t r ΔT [N m] and damping G_v [N m s/rad] for the direction of the motion."""
    way = speed * radius if speed != 0.0 else wanted
    if way >= 0.0:
        return s[sv.TENSION_GAIN] * radius * wanted, s[sv.VELOCITY_GAIN]
    return s[sv.LOOSENING_TENSION_GAIN] * radius * wanted, s[sv.LOOSENING_VELOCITY_GAIN]


@compiled
def _is_due(s: Any, time: float, early: float) -> bool:
    """Whether the controller samples now; leaves the number of the sample on trial."""
    if s[sv.PERIOD] == 0.0:
        return True
    s[sv.TRIAL_SAMPLE] = math.floor((time + early) / s[sv.PERIOD])
    return s[sv.STARTED] == 0.0 or s[sv.TRIAL_SAMPLE] != s[sv.SAMPLE]


@compiled
def evaluate(layout: Any, m: int, d: int, address: int) -> None:
    """Torque for the tension at hand, from the committed state; see docs/servo.md."""
    s, ring = sv.unpack(address)
    actuator = int(s[sv.ACTUATOR])
    if actuator < 0 or s[sv.SHEATH] < 0.0:
        return
    states = pointer(d + layout.d_plugin_state)
    sheath, segments, guides, _ = st.unpack(states + 8 * int(s[sv.SHEATH]))
    time, h = double(d + layout.d_time, 0), double(m + layout.o_timestep, 0)
    dof = integer(pointer(m + layout.m_jnt_dofadr), int(sheath[st.REEL_JOINT]))
    speed, radius = double(pointer(d + layout.d_qvel), dof), sheath[st.REEL_RADIUS]
    spool = sheath[st.REEL_TORQUE]  # which has just been applied
    adr = integer(pointer(m + layout.m_actuator_outadr), actuator)
    force = doubles(pointer(d + layout.d_actuator_force) + 8 * adr, 1)
    if not math.isfinite(spool):
        force[0], s[sv.ON_TRIAL] = 0.0, 0.0
        return
    held = 0.0 if s[sv.BACKDRIVEN] != 0.0 else spool  # by a gear that cannot be driven back
    load = known_torque(layout, m, d, dof, actuator) + held
    stage = is_stage(layout, m, time, s[sv.ON_TRIAL], s[sv.TRIAL_TIME])
    sampled, early = ring.shape[0] > 0, _EARLY * h

    memory = s[sv.TRIAL : sv.TRIAL + sv.MEMORY]
    if stage:
        memory = memory.copy()
    torque = damping = 0.0
    if not (stage and sampled):  # a controller with a clock does not see inside a step
        memory[:] = s[sv.COMMITTED : sv.COMMITTED + sv.MEMORY]
        due = _is_due(s, time, early)
        if due:
            reference = control(layout, m, d, actuator)
            wanted = _sample(s, memory, sheath, segments, guides, reference, time)
            torque, damping = _driven(s, wanted, speed, radius)
        s[sv.SAMPLED], s[sv.TRIAL_TORQUE] = due, torque - damping * speed
    if sampled:
        torque = _arrived(s, ring, time, early, stage)
    elif integer(m + layout.o_integrator, 0) == RK4:
        torque -= damping * speed
    else:  # the damping as at the end of the step, whatever else turns the motor: always stable
        torque -= damping * speed
        torque = (torque + load) / (1.0 + h * damping / s[sv.MOTOR_INERTIA]) - load
    torque = limited(torque, load, speed, s[sv.MOTOR_INERTIA], h, s[sv.SPEED_LIMIT])
    if s[sv.TORQUE_LIMIT] > 0.0:
        torque = min(max(torque, -s[sv.TORQUE_LIMIT]), s[sv.TORQUE_LIMIT])
    if not stage:
        s[sv.TRIAL_TIME], s[sv.ON_TRIAL] = time, 1.0
    force[0] = torque + held


@compiled
def commit(address: int) -> None:
    """Make the step on trial the committed state, and send off its command."""
    s, ring = sv.unpack(address)
    if s[sv.ON_TRIAL] == 0.0:
        return
    s[sv.COMMITTED : sv.COMMITTED + sv.MEMORY] = s[sv.TRIAL : sv.TRIAL + sv.MEMORY]
    s[sv.STARTED], s[sv.ON_TRIAL] = 1.0, 0.0
    capacity = ring.shape[0]
    if capacity > 0 and s[sv.SAMPLED] != 0.0:
        head = int(s[sv.HEAD])
        ring[head, 0], ring[head, 1] = s[sv.TRIAL_TIME], s[sv.TRIAL_TORQUE]
        s[sv.HEAD] = (head + 1) % capacity
        s[sv.COUNT] = min(s[sv.COUNT] + 1.0, capacity)
        s[sv.SAMPLE] = s[sv.TRIAL_SAMPLE]
