"""Evaluation of a sheath within a time step: tensions for the pose at hand, and their forces.

Equations: docs/theory.md, sections 4 and 7.
"""

from __future__ import annotations

import math

from tendon_mj.compilation import compiled
from tendon_mj.engine.abi.control import control
from tendon_mj.engine.abi.layout import Layout
from tendon_mj.engine.abi.memory import coordinates, double, integer, pointer
from tendon_mj.engine.abi.runge_kutta import is_stage
from tendon_mj.engine.sheath_plugin.forces import apply_forces
from tendon_mj.engine.sheath_plugin.holding_ratios import update_ratios
from tendon_mj.engine.sheath_plugin.initial_state import lay_tendon
from tendon_mj.engine.sheath_plugin.path_geometry import update_path
from tendon_mj.engine.sheath_plugin.sliding_resistance import fill_drag
from tendon_mj.engine.sheath_plugin.spools import (
    flank_stiffness,
    on_drum,
    torque_on_drive,
    wound_by,
)
from tendon_mj.engine.sheath_plugin.state import State, state_at, unpack
from tendon_mj.engine.sheath_plugin.strain_law import fill_strain, move_tangents, store_new_strain
from tendon_mj.engine.sheath_plugin.trial import store_trial
from tendon_mj.sheath.records import Guides, Segments
from tendon_mj.sheath.tension_solver import solve_flow

_TANGENTS = 8  # to a strain law that is no line; about 2 are needed


@compiled
def _solve(state: State, segments: Segments, guides: Guides, elapsed: float) -> bool:
    """Solve the flow with a strain law that fits the tensions that come out."""
    dragged = fill_drag(state, guides, elapsed)
    tangents = _TANGENTS if state.law.stiffening > 0.0 else 0
    solved = False
    for tried in range(tangents + 1):
        solved = solve_flow(segments, guides, dragged)
        if not (solved and tried < tangents and move_tangents(state, segments, elapsed)):
            break
    return solved


@compiled
def evaluate(layout: Layout, m: int, d: int, address: int) -> None:
    """Solve the tendon for the pose at hand, from the committed state, and apply its forces."""
    state = state_at(address)
    segments, guides, path = unpack(address)
    last = len(guides)
    time = double(d + layout.d_time, 0)
    start = integer(pointer(d + layout.d_ten_wrapadr), int(state.tendon))
    points = coordinates(pointer(d + layout.d_wrap_xpos) + 24 * start)
    fresh = state.started == 0.0
    update_path(points, coordinates(path), segments, guides, fresh)
    update_ratios(address, state, guides, time)
    if fresh:
        lay_tendon(layout, m, d, state, segments)

    stage = is_stage(layout, m, time, state.has_trial, state.trial_time)
    elapsed = time - state.commit_time
    if not elapsed > 0.0:
        elapsed = double(m + layout.o_timestep, 0)
    drive = wound_by(layout, m, d, state.reel_joint, state.reel_radius)
    drive += control(layout, m, d, int(state.reel_actuator))
    flank = flank_stiffness(layout, m, state, elapsed)
    wound_in = on_drum(state, segments, drive, flank)
    wound_out = wound_by(layout, m, d, state.output_joint, state.output_radius)
    strained = fill_strain(state, segments, elapsed)

    # for this evaluation only: wound tendon leaves the two end segments, the sheath's mount yields
    input_stored, output_stored = segments[0].stored, segments[last].stored
    segments[0].stored -= wound_in - state.wound_in
    segments[last].stored -= wound_out - state.wound_out
    input_length = segments[0].length
    segments[0].length = input_length + state.law.sheath_compliance * state.laid_pretension
    segments[0].support_compliance = state.law.sheath_compliance * state.law.axial_stiffness
    for j in range(last + 1):  # start from the committed step, not from an earlier evaluation
        segments[j].tension = segments[j].previous_tension
    possible = math.isfinite(drive + wound_out)
    solved = possible and _solve(state, segments, guides, elapsed)
    if strained:
        store_new_strain(state, segments, guides, elapsed)
    segments[0].length = input_length
    segments[last].stored = output_stored
    segments[0].stored = input_stored
    if not solved:
        state.unsolved += 1.0
    state.reel_torque = torque_on_drive(state, segments, drive - wound_in, flank)
    if not possible or not math.isfinite(segments[last].tension):
        state.has_trial = 0.0  # an earlier evaluation's result must not be committed instead
        return
    apply_forces(layout, m, d, state, segments, points)
    if not stage:
        state.trial_elapsed = elapsed
        store_trial(state, segments, guides, wound_in, wound_out, time)
