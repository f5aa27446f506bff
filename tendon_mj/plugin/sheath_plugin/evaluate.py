"""Evaluation of a sheath within a time step: tensions for the pose at hand, and their forces.

Equations: docs/theory.md, sections 4, 7 and 8.
"""

from __future__ import annotations

import math

from tendon_mj.native import apart, compiled
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.abi.library import free, malloc
from tendon_mj.plugin.abi.memory import coordinates, copy_doubles, doubles
from tendon_mj.plugin.sheath_plugin import drive, friction, groups, inextensible, strain
from tendon_mj.plugin.sheath_plugin.attributes import is_sheath
from tendon_mj.plugin.sheath_plugin.bind import is_bound
from tendon_mj.plugin.sheath_plugin.fixed_tendon import lay_fixed
from tendon_mj.plugin.sheath_plugin.forces import apply_forces, pull_segment
from tendon_mj.plugin.sheath_plugin.input_force import input_force
from tendon_mj.plugin.sheath_plugin.play import evaluate_with_play
from tendon_mj.plugin.sheath_plugin.response import respond
from tendon_mj.plugin.sheath_plugin.signature import pose_sum
from tendon_mj.plugin.sheath_plugin.state import (
    SHEATH,
    adopt_binding,
    binding_of,
    has_play,
    state_at,
    state_of,
    unpack,
    unpack_arcs,
)
from tendon_mj.plugin.sheath_plugin.trial import (
    moment,
    refuse,
    shift_guides,
    show_trial,
    solve_from_last_step,
    store_trial,
)
from tendon_mj.plugin.sheath_plugin.wound import evaluate_wound, is_ready
from tendon_mj.plugin.sheath_plugin.wraps import trace_path
from tendon_mj.typing import FloatArray


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
def _evaluate_driven(m: Model, d: Data, address: int, force: FloatArray) -> None:
    """Solve an elastic tendon whose input tension is given; add what friction makes of it."""
    state = state_at(address)
    segments, guides, _ = unpack(address)
    time, stage, elapsed = moment(m, d, state)
    if state.finished == 0.0:
        drive.lay_driven(state, segments)
    shift_guides(segments, guides)
    strain.fill_strain(state, segments, elapsed)
    drive.begin_yield(segments)
    finite = solve_from_last_step(state, segments, guides, elapsed, True)
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
        show_trial(segments, guides)
        return
    state.trial_time, state.trial_elapsed = time, elapsed
    store_trial(state, segments, guides, 0.0, 0.0, 0.0)


@compiled
def evaluate(m: Model, d: Data, instance: int) -> None:
    """Bring a tendon's path up to date in the pose at hand.

    One that is wound is solved from the committed state, and its forces applied, together with all
    others that share drums or pulleys with play; those that are driven follow in `solve_driven`.
    """
    address = state_of(m, d, instance)
    state = state_at(address)
    if state.finished == 0.0:
        state.commit_time = d.time - m.opt.timestep
    time, stage, _ = moment(m, d, state)
    _update_path(m, d, address, stage)
    state.applied = 0.0
    if state.driven == 0.0:
        state.drum = drive.turned(m, d, state.reel_joint)
        state.pulley = drive.turned(m, d, state.output_joint)
        if has_play(state):
            evaluate_with_play(m, d, instance)
        elif is_ready(m, d, address):
            evaluate_wound(m, d, address)
    else:
        if not state.law.axial_stiffness > 0.0 and state.inextensible == 0.0:
            state.law.axial_stiffness = drive.CHOSEN_STIFFNESS
        segments, guides, _ = unpack(address)
        friction.update_ratios(address, state, segments, guides, time)
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
            _, stage, _ = moment(m, d, state)
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
            refuse(state)
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
