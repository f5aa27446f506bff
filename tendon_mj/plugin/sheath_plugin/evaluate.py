"""Evaluation of a sheath within a time step: tensions for the pose at hand, and their forces.

Equations: docs/theory.md, sections 4, 7 and 8.
"""

from __future__ import annotations

import math

from tendon_mj.compilation import compiled
from tendon_mj.plugin.abi.control import control
from tendon_mj.plugin.abi.layout import Layout
from tendon_mj.plugin.abi.memory import coordinates, double, integer, pointer
from tendon_mj.plugin.abi.runge_kutta import is_stage
from tendon_mj.plugin.sheath_plugin.driven import lay_at_rest, let_guides_yield, solve_branches
from tendon_mj.plugin.sheath_plugin.forces import apply_forces
from tendon_mj.plugin.sheath_plugin.holding_ratios import update_ratios
from tendon_mj.plugin.sheath_plugin.initial_state import lay_tendon
from tendon_mj.plugin.sheath_plugin.input_force import follow_spring, input_force
from tendon_mj.plugin.sheath_plugin.path.over_geoms import trace_path
from tendon_mj.plugin.sheath_plugin.path.over_sites import update_path, update_spans
from tendon_mj.plugin.sheath_plugin.sliding_resistance import fill_drag
from tendon_mj.plugin.sheath_plugin.spools import (
    flank_stiffness,
    on_drum,
    torque_on_drive,
    wound_by,
)
from tendon_mj.plugin.sheath_plugin.state import State, state_at, unpack, unpack_arcs
from tendon_mj.plugin.sheath_plugin.strain_law import fill_strain, move_tangents, store_new_strain
from tendon_mj.plugin.sheath_plugin.trial import store_trial
from tendon_mj.sheath import Guides, Segments, solve_flow

_TANGENTS = 8  # to a strain law that is no line; about 2 are needed


@compiled
def _solve(state: State, segments: Segments, guides: Guides, elapsed: float) -> bool:
    """Solve the flow with a strain law that fits the tensions that come out."""
    dragged = fill_drag(state, guides, elapsed)
    tangents = _TANGENTS if state.law.stiffening > 0.0 else 0
    solved = False
    for tried in range(tangents + 1):
        if state.driven != 0.0:
            solved = solve_branches(state, segments, guides)
        else:
            solved = solve_flow(segments, guides, dragged, False)
        if not (solved and tried < tangents and move_tangents(state, segments, elapsed)):
            break
    return solved


@compiled
def _are_finite(segments: Segments) -> bool:
    """Whether every stretch has a tension; one that was emptied has none, and reads inf."""
    finite = True
    for j in range(len(segments)):
        finite = finite and math.isfinite(segments[j].tension)
    return finite


@compiled
def _update_path(layout: Layout, m: int, d: int, address: int, fresh: bool, stage: bool) -> None:
    """Bring lengths, bends and spans up to date."""
    state = state_at(address)
    segments, guides, path = unpack(address)
    plain = state.arcs == 0.0 and state.pulleys == 0.0 and state.inner_guides == 0.0
    if not plain or state.input_at_last != 0.0:
        arcs = unpack_arcs(address)
        trace_path(layout, m, d, state, segments, guides, arcs, coordinates(path), stage)
        return
    start = integer(pointer(d + layout.d_ten_wrapadr), int(state.tendon))
    points = coordinates(pointer(d + layout.d_wrap_xpos) + 24 * start)
    update_path(points, coordinates(path), segments, guides, fresh)
    update_spans(layout, m, int(state.tendon), segments)  # bodies are others in another model


@compiled
def _shift_guides(segments: Segments, guides: Guides) -> None:
    """Hand over, for this evaluation only, the tendon that guides on arcs have moved past."""
    for j in range(len(segments)):
        segments[j].unshifted = segments[j].stored
    for i in range(len(guides)):
        segments[i].stored += guides[i].shift
        segments[i + 1].stored -= guides[i].shift


@compiled
def _evaluate_driven(
    layout: Layout, m: int, d: int, address: int, time: float, elapsed: float, stage: bool
) -> None:
    """Solve a tendon whose input tension is given, and apply what friction makes of it."""
    state = state_at(address)
    segments, guides, _ = unpack(address)
    state.input_force = input_force(layout, m, d, address, state)
    if not math.isfinite(state.input_force):
        state.unsolved += 1.0
        state.has_trial = 0.0  # an earlier evaluation's result must not be committed instead
        return
    if state.started == 0.0:
        let_guides_yield(layout, m, d, state, segments, elapsed)
        lay_at_rest(state, segments)
        state.started = 1.0
    update_ratios(address, state, guides, time)
    strained = fill_strain(state, segments, elapsed)
    if state.arcs > 0.0:
        _shift_guides(segments, guides)
    for j in range(len(segments)):  # start from the committed step, not an earlier evaluation
        segments[j].tension = segments[j].previous_tension
    solved = _solve(state, segments, guides, elapsed)
    finite = _are_finite(segments)
    if not (solved and finite):
        state.unsolved += 1.0
    if strained and finite:
        store_new_strain(state, segments, guides, elapsed)
    if state.arcs > 0.0:
        for j in range(len(segments)):
            segments[j].stored = segments[j].unshifted
    if not finite:
        for i in range(len(guides)):  # nor is what its branches draw through one another
            guides[i].flow = 0.0
        state.has_trial = 0.0
        return
    apply_forces(layout, m, d, state, segments)
    if not stage:
        state.trial_elapsed = elapsed
        store_trial(state, segments, guides, 0.0, 0.0, 0.0, time)


@compiled
def _evaluate_wound(
    layout: Layout, m: int, d: int, address: int, time: float, elapsed: float, stage: bool
) -> None:
    """Solve a tendon of given length between its ends, and apply its forces."""
    state = state_at(address)
    segments, guides, _ = unpack(address)
    last = len(guides)
    if not state.law.axial_stiffness > 0.0:  # it was driven, and what drove it is gone
        state.unsolved += 1.0
        state.has_trial = 0.0
        return
    if state.started == 0.0:
        lay_tendon(layout, m, d, state, segments)
    rest = state.spring_length
    if state.own_spring != 0.0:
        rest = double(pointer(m + layout.m_tendon_lengthspring), 2 * int(state.tendon) + 1)
        if not follow_spring(layout, m, d, state):
            for j in range(last + 1):
                segments[j].tension = 0.0
            state.has_trial = 0.0
            return
    update_ratios(address, state, guides, time)
    drive = wound_by(layout, m, d, state.reel_joint, state.reel_radius)
    drive += control(layout, m, d, int(state.reel_actuator))
    flank = flank_stiffness(layout, m, state, elapsed)
    wound_in = on_drum(state, segments, drive, flank)
    wound_out = wound_by(layout, m, d, state.output_joint, state.output_radius)
    strained = fill_strain(state, segments, elapsed)

    # for this evaluation only: wound tendon leaves the two end segments, the sheath's mount yields
    if state.arcs > 0.0:
        _shift_guides(segments, guides)
    else:
        segments[0].unshifted, segments[last].unshifted = segments[0].stored, segments[last].stored
    segments[0].stored -= wound_in - state.wound_in
    segments[0].stored += rest - state.spring_length
    segments[last].stored -= wound_out - state.wound_out
    input_length = segments[0].length
    segments[0].length = input_length + state.law.sheath_compliance * state.laid_pretension
    segments[0].support_compliance = state.law.sheath_compliance * state.law.axial_stiffness
    for j in range(last + 1):  # start from the committed step, not from an earlier evaluation
        segments[j].tension = segments[j].previous_tension
    possible = math.isfinite(drive + wound_out)
    solved = possible and _solve(state, segments, guides, elapsed)
    finite = _are_finite(segments)
    if strained and finite:
        store_new_strain(state, segments, guides, elapsed)
    segments[0].length = input_length
    if state.arcs > 0.0:
        for j in range(1, last):
            segments[j].stored = segments[j].unshifted
    segments[last].stored = segments[last].unshifted
    segments[0].stored = segments[0].unshifted
    if not (solved and finite):
        state.unsolved += 1.0
    state.reel_torque = torque_on_drive(state, segments, drive - wound_in, flank)
    if not (possible and finite):
        state.has_trial = 0.0  # an earlier evaluation's result must not be committed instead
        return
    apply_forces(layout, m, d, state, segments)
    if not stage:
        state.trial_elapsed = elapsed
        store_trial(state, segments, guides, wound_in, wound_out, rest, time)


@compiled
def evaluate(layout: Layout, m: int, d: int, address: int) -> None:
    """Solve the tendon for the pose at hand, from the committed state, and apply its forces."""
    state = state_at(address)
    time = double(d + layout.d_time, 0)
    stage = is_stage(layout, m, time, state.has_trial, state.trial_time)
    _update_path(layout, m, d, address, state.started == 0.0, stage)
    if state.started == 0.0:
        state.commit_time = time - double(m + layout.o_timestep, 0)
    elapsed = time - state.commit_time
    if not elapsed > 0.0:
        elapsed = double(m + layout.o_timestep, 0)
    state.applied = 0.0
    if state.driven != 0.0:
        _evaluate_driven(layout, m, d, address, time, elapsed, stage)
    else:
        _evaluate_wound(layout, m, d, address, time, elapsed, stage)
