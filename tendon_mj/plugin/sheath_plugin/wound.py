"""A tendon of given length between its ends, where drums and pulleys wind it.

Equations: docs/theory.md, sections 4 and 7.
"""

from __future__ import annotations

import math

from tendon_mj.native import compiled
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.abi.library import geared_control
from tendon_mj.plugin.sheath_plugin import drive, friction, strain
from tendon_mj.plugin.sheath_plugin.forces import apply_forces
from tendon_mj.plugin.sheath_plugin.input_force import follow_spring
from tendon_mj.plugin.sheath_plugin.state import State, state_at, unpack
from tendon_mj.plugin.sheath_plugin.trial import (
    moment,
    refuse,
    shift_guides,
    show_trial,
    solve_from_last_step,
    store_trial,
)
from tendon_mj.sheath import Segment


@compiled
def is_ready(m: Model, d: Data, address: int) -> bool:
    """Lay a wound tendon if it is not yet; return whether it has a length that can be solved."""
    state = state_at(address)
    segments, guides, _ = unpack(address)
    if not state.law.axial_stiffness > 0.0:  # it was driven, and what drove it is gone
        refuse(state)
        return False
    if state.started == 0.0:
        drive.lay_wound(m, d, state, segments)
    if state.own_spring != 0.0 and not follow_spring(m, d, state):
        for j in range(len(segments)):
            segments[j].tension = 0.0
        state.has_trial = 0.0
        return False
    friction.update_ratios(address, state, segments, guides, d.time)
    return True


@compiled
def _hold_by_mount(state: State, segment: Segment, compliance: float) -> None:
    """Let a segment end at a mount, which yields in proportion to the tension beyond T_0."""
    segment.length += compliance * state.laid_pretension
    segment.support_compliance += compliance * state.law.axial_stiffness


@compiled
def solve_wound(m: Model, d: Data, address: int) -> tuple[bool, float, float, float]:
    """Solve a tendon of given length between its ends, with its drum and pulley where they stand.

    Returns:
        Whether its tensions are finite; unstretched tendon on the drum and on the pulley, and
        length of the tendon's own spring at rest [m].
    """
    state = state_at(address)
    segments, guides, _ = unpack(address)
    last = len(guides)
    _, _, elapsed = moment(m, d, state)
    rest = state.spring_length
    if state.own_spring != 0.0:
        rest = m.tendon_lengthspring[int(state.tendon), 1]
    travel = state.reel_radius * state.drum + geared_control(m, d, int(state.reel_actuator))
    travel = strain.unstretched(state, travel)
    flank = drive.flank_stiffness(m, state, elapsed)
    wound_in = drive.on_drum(state, segments, travel, flank)
    wound_out = strain.unstretched(state, state.output_radius * state.pulley)

    # for this evaluation only: wound tendon leaves the two end segments, the mounts yield
    if state.arcs > 0.0:
        shift_guides(segments, guides)
    else:
        segments[0].unshifted, segments[last].unshifted = segments[0].stored, segments[last].stored
    segments[0].stored -= wound_in - state.wound_in
    segments[0].stored += rest - state.spring_length
    segments[last].stored -= wound_out - state.wound_out
    input_length, output_length = segments[0].length, segments[last].length
    segments[0].support_compliance = segments[last].support_compliance = 0.0
    _hold_by_mount(state, segments[0], state.law.sheath_compliance)
    _hold_by_mount(state, segments[last], state.law.output_compliance)
    possible = math.isfinite(travel + wound_out)
    finite = solve_from_last_step(state, segments, guides, elapsed, possible)
    segments[0].length, segments[last].length = input_length, output_length
    if state.arcs > 0.0:
        for j in range(1, last):
            segments[j].stored = segments[j].unshifted
    segments[last].stored = segments[last].unshifted
    segments[0].stored = segments[0].unshifted
    state.reel_torque = drive.torque_on_drive(state, segments, travel - wound_in, flank)
    return finite, wound_in, wound_out, rest


@compiled
def evaluate_wound(m: Model, d: Data, address: int) -> None:
    """Solve a tendon of given length between its ends, and apply its forces."""
    state = state_at(address)
    segments, guides, _ = unpack(address)
    time, stage, elapsed = moment(m, d, state)
    finite, wound_in, wound_out, rest = solve_wound(m, d, address)
    if not finite:
        state.has_trial = 0.0
        return
    apply_forces(m, d, state, segments, d.qfrc_passive)
    if stage:
        show_trial(segments, guides)
        return
    state.trial_time, state.trial_elapsed = time, elapsed
    store_trial(state, segments, guides, wound_in, wound_out, rest)
