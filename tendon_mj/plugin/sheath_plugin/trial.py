"""A step on trial: solved from the committed state, and made the committed one by `commit`.

Equations: docs/theory.md, sections 4 and 7.
"""

from __future__ import annotations

import math

from tendon_mj.native import compiled
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.abi.library import is_stage
from tendon_mj.plugin.sheath_plugin import drive, friction, inextensible, strain
from tendon_mj.plugin.sheath_plugin.state import State, state_at, unpack, unpack_arcs
from tendon_mj.sheath import Arcs, Guides, Segments, friction_work, solve_flow


@compiled
def moment(m: Model, d: Data, state: State) -> tuple[float, bool, float]:
    """Time [s]; whether this is an inner stage of Runge-Kutta; time since the last step [s]."""
    time = d.time
    stage = is_stage(m, time, state.has_trial, state.trial_time)
    elapsed = time - state.commit_time
    if not elapsed > 0.0:
        elapsed = m.opt.timestep
    return time, stage, elapsed


@compiled
def shift_guides(segments: Segments, guides: Guides) -> None:
    """Hand over the tendon that guides on arcs have moved past, for this evaluation only."""
    for j in range(len(segments)):
        segments[j].unshifted = segments[j].stored
    for i in range(len(guides)):
        segments[i].stored += guides[i].shift
        segments[i + 1].stored -= guides[i].shift


@compiled
def refuse(state: State) -> None:
    """Count an evaluation without a solution; an earlier one must not be committed instead."""
    state.unsolved += 1.0
    state.has_trial = 0.0


@compiled
def solve_from_last_step(
    state: State, segments: Segments, guides: Guides, elapsed: float, possible: bool
) -> bool:
    """Solve from the committed step, not an earlier evaluation; return whether tensions are finite.

    An evaluation that is not solved is counted; if it is not ``possible`` it is not tried.
    """
    strained = strain.fill_strain(state, segments, elapsed)
    for j in range(len(segments)):
        segments[j].tension = segments[j].previous_tension
    solved = possible and _solve(state, segments, guides, elapsed)
    finite = _are_finite(segments)
    if strained and finite:
        strain.store_new_strain(state, segments, guides, elapsed)
    if not (solved and finite):
        state.unsolved += 1.0
    return possible and finite


@compiled
def show_trial(segments: Segments, guides: Guides) -> None:
    """After an inner stage of Runge-Kutta, show the result of the step's first evaluation again."""
    for j in range(len(segments)):
        segments[j].tension = segments[j].trial_tension
    for i in range(len(guides)):
        guides[i].flow, guides[i].slip = guides[i].trial_flow, guides[i].trial_slip


@compiled
def store_trial(
    state: State,
    segments: Segments,
    guides: Guides,
    wound_in: float,
    wound_out: float,
    spring_length: float,
) -> None:
    """Store the result of an evaluation for ``commit``."""
    ea = state.law.axial_stiffness
    for i in range(len(guides)):
        guide = guides[i]
        flow = guide.flow
        left, right = segments[i].tension, segments[i + 1].tension
        guide.trial_flow = flow
        guide.trial_slip = guide.slip if flow != 0.0 else 0.0
        guide.trial_shift = guide.shift
        rubs = guide.is_pulley == 0.0
        work = max(0.0, ea * friction_work(left, right, flow))  # less by rounding alone
        guide.trial_friction_work = work if rubs else 0.0
    if state.law.tendon_mass > 0.0 or state.law.stiffening > 0.0:
        friction.store_trial_friction_work(state, segments, guides)
    for j in range(len(segments)):
        segments[j].trial_tension = segments[j].tension
    if state.strain_kept != 0.0:
        strain.store_trial_strain(state, segments)
    state.trial_wound_in, state.trial_wound_out = wound_in, wound_out
    state.trial_spring_length = spring_length
    state.has_trial = 1.0


@compiled
def _commit_arcs(arcs: Arcs) -> None:
    """Keep where arcs begin and end."""
    for k in range(len(arcs)):
        arc = arcs[k]
        arc.touches = arc.trial_touches
        arc.x1, arc.y1, arc.z1 = arc.trial_x1, arc.trial_y1, arc.trial_z1
        arc.x2, arc.y2, arc.z2 = arc.trial_x2, arc.trial_y2, arc.trial_z2


@compiled
def commit(address: int) -> None:
    """Make the step on trial the committed state."""
    state = state_at(address)
    segments, guides, _ = unpack(address)
    if state.has_trial == 0.0:
        return
    state.finished = 1.0
    if state.arcs > 0.0:
        _commit_arcs(unpack_arcs(address))
    if state.inextensible != 0.0:
        inextensible.commit_inextensible(segments, guides)
    else:
        _commit_elastic(state, segments, guides)
    friction.commit_velocity(state, guides)
    state.commit_time = state.trial_time
    state.has_trial = 0.0


@compiled
def _commit_elastic(state: State, segments: Segments, guides: Guides) -> None:
    last = len(guides)
    if state.driven != 0.0:
        for j in range(last + 1):
            segments[j].stored += segments[j].trial_yield
    if state.arcs > 0.0:  # guides on arcs have moved past tendon
        for i in range(last):
            segments[i].stored += guides[i].trial_shift
            segments[i + 1].stored -= guides[i].trial_shift
    segments[0].stored -= state.trial_wound_in - state.wound_in
    segments[0].stored += state.trial_spring_length - state.spring_length
    segments[last].stored -= state.trial_wound_out - state.wound_out
    if state.strain_kept != 0.0:
        strain.commit_strain(segments, guides)
    for i in range(last):
        guide = guides[i]
        flow = guide.trial_flow
        segments[i].stored += flow
        segments[i + 1].stored -= flow
        guide.passed += flow
        guide.previous_slip = guide.trial_slip
        guide.friction_work += guide.trial_friction_work
    for j in range(len(segments)):
        segments[j].previous_tension = segments[j].trial_tension
    if state.driven != 0.0:
        drive.refill_inputs(segments, guides)
    state.wound_in, state.wound_out = state.trial_wound_in, state.trial_wound_out
    state.spring_length = state.trial_spring_length


_TANGENTS = 8  # to a strain law that is not a line; about 2 are needed


@compiled
def _solve(state: State, segments: Segments, guides: Guides, elapsed: float) -> bool:
    """Solve the flow with a strain law that fits the tensions that come out."""
    dragged = friction.fill_drag(state, guides, elapsed)
    tangents = _TANGENTS if state.law.stiffening > 0.0 else 0
    solved = False
    for tried in range(tangents + 1):
        if state.driven != 0.0:
            solved = drive.solve_branches(state, segments, guides)
        else:
            solved = solve_flow(segments, guides, dragged, False)
        if not (solved and tried < tangents and strain.move_tangents(state, segments, elapsed)):
            break
    return solved


@compiled
def _are_finite(segments: Segments) -> bool:
    """Return whether every stretch has a tension; that of an emptied one is inf."""
    finite = True
    for j in range(len(segments)):
        finite = finite and math.isfinite(segments[j].tension)
    return finite
