"""The step on trial: stored by an evaluation, made the committed state by `advance`."""

from __future__ import annotations

from tendon_mj.compilation import compiled
from tendon_mj.plugin.sheath_plugin.driven import refill_inputs
from tendon_mj.plugin.sheath_plugin.sliding_resistance import (
    commit_velocity,
    store_trial_friction_work,
)
from tendon_mj.plugin.sheath_plugin.state import State, state_at, unpack, unpack_arcs
from tendon_mj.plugin.sheath_plugin.strain_law import commit_strain, store_trial_strain
from tendon_mj.sheath import Arcs, Guides, Segments, friction_work


@compiled
def store_trial(
    state: State,
    segments: Segments,
    guides: Guides,
    wound_in: float,
    wound_out: float,
    spring_length: float,
    time: float,
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
        guide.trial_friction_work = ea * friction_work(left, right, flow) if rubs else 0.0
    if state.law.tendon_mass > 0.0 or state.law.stiffening > 0.0:
        store_trial_friction_work(state, segments, guides)
    for j in range(len(segments)):
        segments[j].trial_tension = segments[j].tension
    if state.strain_kept != 0.0:
        store_trial_strain(state, segments)
    state.trial_wound_in, state.trial_wound_out = wound_in, wound_out
    state.trial_spring_length = spring_length
    state.trial_time = time
    state.has_trial = 1.0


@compiled
def _commit_arcs(segments: Segments, guides: Guides, arcs: Arcs) -> None:
    """Hand over the tendon that guides on arcs have moved past, and keep where they are."""
    for i in range(len(guides)):
        segments[i].stored += guides[i].trial_shift
        segments[i + 1].stored -= guides[i].trial_shift
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
    last = len(guides)
    if state.arcs > 0.0:
        _commit_arcs(segments, guides, unpack_arcs(address))
    segments[0].stored -= state.trial_wound_in - state.wound_in
    segments[0].stored += state.trial_spring_length - state.spring_length
    segments[last].stored -= state.trial_wound_out - state.wound_out
    if state.strain_kept != 0.0:
        commit_strain(segments, guides)
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
        refill_inputs(segments, guides)
    commit_velocity(state, guides)
    state.wound_in, state.wound_out = state.trial_wound_in, state.trial_wound_out
    state.spring_length = state.trial_spring_length
    state.commit_time = state.trial_time
    state.has_trial = 0.0
