"""Evaluation of a sheath within a time step: tensions for the pose at hand, and their forces.

An evaluation stores its result on trial; `advance` makes it the committed state by `commit`.

Equations: docs/theory.md, sections 4, 7 and 8.
"""

from __future__ import annotations

import math

from tendon_mj.native import apart, compiled
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.abi.library import free, geared_control, is_stage, malloc
from tendon_mj.plugin.abi.memory import coordinates, copy_doubles, doubles
from tendon_mj.plugin.sheath_plugin import drive, friction, groups, inextensible, strain
from tendon_mj.plugin.sheath_plugin.attributes import is_sheath
from tendon_mj.plugin.sheath_plugin.bind import is_bound
from tendon_mj.plugin.sheath_plugin.fixed_tendon import lay_fixed
from tendon_mj.plugin.sheath_plugin.forces import apply_forces, pull_segment
from tendon_mj.plugin.sheath_plugin.input_force import follow_spring, input_force
from tendon_mj.plugin.sheath_plugin.response import respond
from tendon_mj.plugin.sheath_plugin.signature import pose_sum
from tendon_mj.plugin.sheath_plugin.state import (
    SHEATH,
    State,
    adopt_binding,
    binding_of,
    state_at,
    state_of,
    unpack,
    unpack_arcs,
)
from tendon_mj.plugin.sheath_plugin.wraps import trace_path
from tendon_mj.sheath import Arcs, Guides, Segments, friction_work, solve_flow
from tendon_mj.typing import FloatArray


@compiled
def _store_trial(
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


@compiled
def _update_path(m: Model, d: Data, address: int, stage: bool) -> None:
    """Bring lengths, bends and spans up to date."""
    state = state_at(address)
    segments, guides, path = unpack(address)
    if state.fixed != 0.0:
        lay_fixed(state, segments, guides)
    else:
        arcs = unpack_arcs(address)
        trace_path(m, d, state, segments, guides, arcs, coordinates(path), stage)


@compiled
def _shift_guides(segments: Segments, guides: Guides) -> None:
    """Hand over the tendon that guides on arcs have moved past, for this evaluation only."""
    for j in range(len(segments)):
        segments[j].unshifted = segments[j].stored
    for i in range(len(guides)):
        segments[i].stored += guides[i].shift
        segments[i + 1].stored -= guides[i].shift


@compiled
def _refuse(state: State) -> None:
    """Count an evaluation without a solution; an earlier one must not be committed instead."""
    state.unsolved += 1.0
    state.has_trial = 0.0


@compiled
def _solve_from_last_step(
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
def _evaluate_driven(m: Model, d: Data, address: int, force: FloatArray) -> None:
    """Solve an elastic tendon whose input tension is given; add what friction makes of it."""
    state = state_at(address)
    segments, guides, _ = unpack(address)
    time, stage, elapsed = _moment(m, d, state)
    if state.finished == 0.0:
        drive.lay_driven(state, segments)
    _shift_guides(segments, guides)
    strain.fill_strain(state, segments, elapsed)
    drive.begin_yield(segments)
    finite = _solve_from_last_step(state, segments, guides, elapsed, True)
    for j in range(len(segments)):
        segments[j].stored = segments[j].unshifted
    drive.end_yield(segments, stage)
    if not finite:
        for i in range(len(guides)):  # nor is what its branches draw through one another
            guides[i].flow = 0.0
        state.has_trial = 0.0
        return
    apply_forces(m, d, state, segments, force)
    if stage:
        _show_trial(segments, guides)
        return
    state.trial_time, state.trial_elapsed = time, elapsed
    _store_trial(state, segments, guides, 0.0, 0.0, 0.0)


@compiled
def _evaluate_wound(
    m: Model, d: Data, address: int, time: float, elapsed: float, stage: bool
) -> None:
    """Solve a tendon of given length between its ends, and apply its forces."""
    state = state_at(address)
    segments, guides, _ = unpack(address)
    last = len(guides)
    if not state.law.axial_stiffness > 0.0:  # it was driven, and what drove it is gone
        _refuse(state)
        return
    if state.started == 0.0:
        drive.lay_wound(m, d, state, segments)
    rest = state.spring_length
    if state.own_spring != 0.0:
        rest = m.tendon_lengthspring[int(state.tendon), 1]
        if not follow_spring(m, d, state):
            for j in range(last + 1):
                segments[j].tension = 0.0
            state.has_trial = 0.0
            return
    friction.update_ratios(address, state, guides, time)
    travel = drive.wound_by(m, d, state.reel_joint, state.reel_radius)
    travel += geared_control(m, d, int(state.reel_actuator))
    travel = strain.unstretched(state, travel)
    flank = drive.flank_stiffness(m, state, elapsed)
    wound_in = drive.on_drum(state, segments, travel, flank)
    wound_out = drive.wound_by(m, d, state.output_joint, state.output_radius)
    wound_out = strain.unstretched(state, wound_out)

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
    possible = math.isfinite(travel + wound_out)
    finite = _solve_from_last_step(state, segments, guides, elapsed, possible)
    segments[0].length = input_length
    if state.arcs > 0.0:
        for j in range(1, last):
            segments[j].stored = segments[j].unshifted
    segments[last].stored = segments[last].unshifted
    segments[0].stored = segments[0].unshifted
    state.reel_torque = drive.torque_on_drive(state, segments, travel - wound_in, flank)
    if not finite:
        state.has_trial = 0.0
        return
    apply_forces(m, d, state, segments, d.qfrc_passive)
    if stage:
        _show_trial(segments, guides)
        return
    state.trial_time, state.trial_elapsed = time, elapsed
    _store_trial(state, segments, guides, wound_in, wound_out, rest)


@compiled
def _show_trial(segments: Segments, guides: Guides) -> None:
    """After an inner stage of Runge-Kutta, show the result of the step's first evaluation again."""
    for j in range(len(segments)):
        segments[j].tension = segments[j].trial_tension
    for i in range(len(guides)):
        guides[i].flow, guides[i].slip = guides[i].trial_flow, guides[i].trial_slip


@compiled
def _moment(m: Model, d: Data, state: State) -> tuple[float, bool, float]:
    """Time [s]; whether this is an inner stage of Runge-Kutta; time since the last step [s]."""
    time = d.time
    stage = is_stage(m, time, state.has_trial, state.trial_time)
    elapsed = time - state.commit_time
    if not elapsed > 0.0:
        elapsed = m.opt.timestep
    return time, stage, elapsed


@compiled
def evaluate(m: Model, d: Data, address: int) -> None:
    """Bring a tendon's path up to date in the pose at hand.

    One that is wound is solved from the committed state, and its forces applied; those that are
    driven follow together, in `evaluate_driven`.
    """
    state = state_at(address)
    if state.finished == 0.0:
        state.commit_time = d.time - m.opt.timestep
    time, stage, elapsed = _moment(m, d, state)
    _update_path(m, d, address, stage)
    state.applied = 0.0
    if state.driven == 0.0:
        _evaluate_wound(m, d, address, time, elapsed, stage)
    else:
        if not state.law.axial_stiffness > 0.0 and state.inextensible == 0.0:
            state.law.axial_stiffness = drive.CHOSEN_STIFFNESS
        _, guides, _ = unpack(address)
        friction.update_ratios(address, state, guides, time)
        state.started = 1.0


@apart
def list_driven(m: Model, d: Data, work: int, first: int, last: int) -> None:
    """List the model's driven sheaths."""
    head, sheaths = groups.head_at(work), groups.driven_sheaths(work, m.nv)
    head.driven = head.elastic = 0.0
    head.leader = first
    for instance in range(first, last + 1):
        if is_sheath(m, instance, first) and is_bound(m, d, instance):
            state = state_at(state_of(m, d, instance))
            if state.driven != 0.0:
                sheaths[int(head.driven)] = instance
                head.driven += 1.0
                head.elastic += state.inextensible == 0.0


@apart
def set_up_driven(m: Model, d: Data, work: int, first: int) -> None:
    """Set up the groups of all inextensible tendons in the pose at hand."""
    head, sheaths = groups.head_at(work), groups.driven_sheaths(work, m.nv)
    head.members = head.groups = head.segments = head.rough = 0.0
    written = state_at(state_of(m, d, first)).end_sum != pose_sum(m, d)
    for k in range(int(head.driven)):
        state = state_at(state_of(m, d, int(sheaths[k])))
        if state.inextensible != 0.0:
            _, stage, _ = _moment(m, d, state)
            inextensible.set_up(m, d, work, int(sheaths[k]), stage, written)


@apart
def read_inputs(m: Model, d: Data, work: int) -> None:
    """Read the force along each driven tendon.

    Its state may have been written since the pose was evaluated, as between `mj_step1` and
    `mj_step2`: it receives a copy of its binding again.
    """
    sheaths = groups.driven_sheaths(work, m.nv)
    for k in range(int(groups.head_at(work).driven)):
        address = state_of(m, d, int(sheaths[k]))
        adopt_binding(address, binding_of(d, int(sheaths[k]), SHEATH))
        state = state_at(address)
        state.input_force = input_force(m, d, address, state)


@apart
def _let_guides_yield(m: Model, d: Data, work: int) -> None:
    """Let the guides of elastic tendons yield so far that a step resolves the stretches between."""
    count, nv, h = 0, m.nv, m.opt.timestep
    sheaths, driven = groups.driven_sheaths(work, nv), int(groups.head_at(work).driven)
    for one in range(driven):
        address = state_of(m, d, int(sheaths[one]))
        if state_at(address).inextensible == 0.0:
            count += len(unpack(address)[0])
    spans = malloc(16 * count * nv)
    answers, k = spans + 8 * count * nv, 0
    for one in range(driven):
        address = state_of(m, d, int(sheaths[one]))
        segments, _, _ = unpack(address)
        if state_at(address).inextensible != 0.0:
            continue
        for j in range(len(segments)):
            row, answer = spans + 8 * nv * k, answers + 8 * nv * k
            doubles(row, nv)[:] = 0.0
            pull_segment(m, d, state_at(address), segments[j], -1.0, coordinates(row))
            copy_doubles(answer, row, nv)
            respond(m, groups.response_at(work, nv), coordinates(answer))
            k += 1
    k = 0
    for one in range(driven):
        address = state_of(m, d, int(sheaths[one]))
        segments, _, _ = unpack(address)
        if state_at(address).inextensible != 0.0:
            continue
        for j in range(len(segments)):
            mobility, row = 0.0, coordinates(spans + 8 * nv * k)
            for other in range(count):
                answer, along = coordinates(answers + 8 * nv * other), 0.0
                for i in range(nv):
                    along += row[i] * answer[i]
                mobility += abs(along)
            yields = drive.yield_of(state_at(address), segments[j], mobility, h)
            segments[j].support_compliance = yields
            k += 1
    free(spans)


@apart
def solve_driven(m: Model, d: Data, work: int) -> None:
    """Solve all driven tendons under the forces at hand; their friction becomes FRICTION."""
    nv, head = m.nv, groups.head_at(work)
    force = coordinates(groups.vector_at(work, nv, groups.FRICTION))
    sheaths = groups.driven_sheaths(work, nv)
    for i in range(nv):
        force[i] = 0.0
    if head.rough > 0.0 or head.elastic > 0.0:
        inextensible.prepare(m, d, work)
    if head.elastic > 0.0:
        _let_guides_yield(m, d, work)
    for k in range(int(head.driven)):
        address = state_of(m, d, int(sheaths[k]))
        state = state_at(address)
        state.applied = 0.0
        if not math.isfinite(state.input_force):
            _refuse(state)
        elif state.inextensible == 0.0:
            _evaluate_driven(m, d, address, force)
    inextensible.solve(m, d, work)


@apart
def repeat_driven(m: Model, d: Data, work: int, moves: bool) -> None:
    """Set FRICTION without solving anything, from the tensions that were shown last."""
    nv = m.nv
    force = coordinates(groups.vector_at(work, nv, groups.FRICTION))
    sheaths = groups.driven_sheaths(work, nv)
    for i in range(nv):
        force[i] = 0.0
    for k in range(int(groups.head_at(work).driven)):
        address = state_of(m, d, int(sheaths[k]))
        state = state_at(address)
        if state.inextensible == 0.0 and math.isfinite(state.input_force):
            segments, _, _ = unpack(address)
            apply_forces(m, d, state, segments, force)
    inextensible.repeat(m, d, work, moves)
