"""The two ways to move a tendon: spools wind it, or MuJoCo's forces give its input tension.

**Wound.** With backlash b the drum follows its drive once that has crossed the gap, and holds
itself in it. If the drive is a joint, the flank by which it winds is a spring, as stiff as the
joint's inertia allows at this time step: the drive bears the contact force, and the drum yields
if that is more than the tendon's pull. No tendon is wound without work of the drive.

**Driven.** The input tension is T_in = max(0, −f) with f of `input_force`; a force that pushes
passes the sheath unrubbed. Each branch has a friction state of its own. A branch behind a pulley
starts with T_in over its divisor; one that begins at the site where an earlier one ended takes over
what arrived there, and draws its tendon through that one: what comes in at its beginning, times its
tension over that of the other, leaves the other's end.

A stretch j of an elastic tendon that its guides hold is a spring EA/ℓ_j on the inertia that it
meets, 1/a_j with a_j = Σ_k |J_j M̂⁻¹ J_kᵀ| over all stretches k of all such tendons in the pose at
hand. Where h² a_j EA/ℓ_j is above 1 the step does not resolve how the tendon comes to rest there:
friction would change its sense from step to step instead of holding, and make energy. Guides
therefore yield to a change of tension by g_j Δτ,

    g_j = max(0, EA h² a_j − ℓ_j),   so that the tendon acts as with an EA from 100 N to 1 MN.

A tendon whose elasticity is not stated does not stretch at all: see `inextensible`.

Equations: docs/theory.md, sections 7 and 8.
"""

from __future__ import annotations

from tendon_mj.native import apart, compiled
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.sheath_plugin.state import State, input_strain
from tendon_mj.plugin.sheath_plugin.strain import (
    reset_to_linear,
    rest_strain,
    spool_torque,
    unstretched,
)
from tendon_mj.sheath import Guides, Segment, Segments, convected, held, solve_flow, strain_at

_RIGIDITY = 0.25  # of the flank: (ωh)² of the drive on it; explicit steps are stable below 4


@compiled
def turned(m: Model, d: Data, joint: float) -> float:
    """How far a joint has turned since `qpos0` [its unit]; 0 without a joint."""
    if joint < 0.0:
        return 0.0
    adr = m.jnt_qposadr[int(joint)]
    return float(d.qpos[adr] - m.qpos0[adr])


@compiled
def flank_stiffness(m: Model, state: State, elapsed: float) -> float:
    """Stiffness of the contact between drive and drum [N/m]; inf without a joint to stop."""
    if state.law.backlash == 0.0 or state.reel_joint < 0.0:
        return float("inf")
    radius = unstretched(state, state.reel_radius)
    mobility = m.dof_invweight0[m.jnt_dofadr[int(state.reel_joint)]] * radius**2
    return _RIGIDITY / (mobility * elapsed * elapsed)


@compiled
def on_drum(state: State, segments: Segments, drive: float, flank: float) -> float:
    """Unstretched tendon on the drum when its drive stands at ``drive`` [m]."""
    if state.law.backlash == 0.0:
        return drive
    half = unstretched(state, 0.5 * state.law.backlash)
    before = max(0.0, segments[0].previous_tension)
    pull = state.law.axial_stiffness * convected(before, state.law.stiffening)
    return min(max(state.wound_in, drive - half - pull / flank), drive + half)


@compiled
def torque_on_drive(state: State, segments: Segments, ahead: float, flank: float) -> float:
    """Torque by which the tendon turns the reel's joint back [N m].

    The drive is ``ahead`` of the drum by that unstretched length [m]; ``flank`` is the stiffness of
    their contact [N/m].
    """
    if state.reel_joint < 0.0:
        return 0.0
    torque = spool_torque(state, segments, 0, state.reel_radius)
    if state.law.backlash == 0.0:
        return torque
    radius = unstretched(state, state.reel_radius)
    half = unstretched(state, 0.5 * state.law.backlash)
    pressed = radius * flank * max(0.0, ahead - half)
    return min(abs(torque), abs(pressed)) * (1.0 if torque > 0.0 else -1.0)


@apart
def lay_wound(m: Model, d: Data, state: State, segments: Segments) -> None:
    """Initialise the segments: the tendon lies evenly along its first path.

    Its unstretched length is fixed by the pretension in the reference pose `qpos0`, as MuJoCo fixes
    a spring length: S = (L(qpos0) + s)/(1 + ε_0) with a slack of s, and the tendon has crept as
    much as it will under it.
    """
    reference = m.tendon_length0[int(state.tendon)] + state.law.slack
    state.laid_pretension = state.law.pretension
    _, creep = rest_strain(state.law, state.laid_pretension)
    free = unstretched(state, reference)
    if state.own_spring != 0.0:  # which may be another since the reset
        rest = m.tendon_lengthspring[int(state.tendon), 1]
        free += rest - state.spring_length
        state.spring_length = rest
    state.wound_in = unstretched(state, state.reel_radius * turned(m, d, state.reel_joint))
    state.wound_out = unstretched(state, state.output_radius * turned(m, d, state.output_joint))
    free -= state.wound_in + state.wound_out
    total = sum(segments["length"])
    strain = total / free - 1.0 - creep
    for j in range(len(segments)):
        segment = segments[j]
        segment.stored = segment.length * free / total
        segment.strain, segment.creep_strain = strain, creep
        segment.previous_tension = strain * (1.0 + state.law.stiffening * max(0.0, strain))
    reset_to_linear(segments)
    state.strain_kept = 1.0  # so that the strains just written count
    state.started = 1.0


CHOSEN_STIFFNESS = 1e6  # EA if none is given, and beyond which nothing would change [N]
_SOFTEST = 1e2  # EA to which guides yield at most [N]
_PASSES = 3  # over branches that feed one another; they differ by the tendon's stretch alone


@compiled
def yield_of(state: State, segment: Segment, mobility: float, h: float) -> float:
    """Yield g of the guides beside a segment per unit τ [m], by the ``mobility`` that it meets."""
    ea, length = state.law.axial_stiffness, segment.length
    yields = max(ea * h * h * mobility, ea / CHOSEN_STIFFNESS * length)
    return max(0.0, min(yields, ea / _SOFTEST * length) - length)


@compiled
def _yielded(segment: Segment, tau: float) -> float:
    """Unstretched length that the guides beside a segment yield at a tension [m]."""
    strain = segment.strain_offset + segment.strain_slope * tau
    return segment.support_compliance * tau / (1.0 + strain)


@compiled
def begin_yield(segments: Segments) -> None:
    """Let the guides yield from the tension of the last step on, for this evaluation."""
    for j in range(len(segments)):
        segments[j].stored -= _yielded(segments[j], segments[j].previous_tension)


@compiled
def end_yield(segments: Segments, stage: bool) -> None:
    """Keep what the guides yield in the step on trial; they are rigid from then on."""
    for j in range(len(segments)):
        segment = segments[j]
        yields = _yielded(segment, segment.tension) - _yielded(segment, segment.previous_tension)
        if not stage:
            segment.trial_yield = yields
        segment.support_compliance = 0.0


@compiled
def lay_driven(state: State, segments: Segments) -> None:
    """Initialise the segments under the input tension, before anything rubs."""
    reset_to_linear(segments)
    for j in range(len(segments)):
        tau = input_strain(state) / segments[j].divisor
        segments[j].previous_tension = segments[j].tension = tau
        segments[j].strain = strain_at(tau, state.law.stiffening)
        segments[j].stored = segments[j].length / (1.0 + segments[j].strain)
    state.strain_kept = 1.0  # so that the strains just written count


@compiled
def _input(state: State, segments: Segments, guides: Guides, first: int) -> float:
    """τ at the beginning of the branch whose first segment is ``first``."""
    fed_by = guides[first - 1].fed_by if first > 0 else -1.0
    source = int(fed_by) if 0.0 <= fed_by < first else -1
    given, tau = input_strain(state), segments[source].tension
    if source < 0 or tau == given / segments[source].divisor:  # nothing rubbed: to the last bit
        return given / segments[first].divisor
    return tau * (segments[source].divisor / segments[first].divisor)


@compiled
def _drawn_through(segments: Segments, guides: Guides, last: int) -> float:
    """Tendon that its fed branches draw from the branch that ends with segment ``last`` [m]."""
    drawn, begin = 0.0, last + 1
    for i in range(last + 1, len(guides) + 1):
        if i < len(guides) and guides[i].is_pulley == 0.0:
            continue
        if guides[begin - 1].fed_by == last:
            taken = -guides[i].flow if i < len(guides) else 0.0  # by those that it feeds itself
            for j in range(begin, i + 1):
                taken += held(segments, j, segments[j].tension)[0] - segments[j].stored
            drawn += taken * segments[last].divisor / segments[begin].divisor
        begin = i + 1
    return drawn


@compiled
def _solve_in_order(state: State, segments: Segments, guides: Guides) -> bool:
    """Solve the branches in the order of the path, for the given flows over pulleys."""
    first, solved, last = 0, True, len(guides)
    for i in range(last + 1):
        if i < last and guides[i].is_pulley == 0.0:
            continue
        segments[first].tension = _input(state, segments, guides, first)
        if i > first:
            stored = segments[i].stored
            if i < last:
                segments[i].stored += guides[i].flow
            solved &= solve_flow(segments[first : i + 1], guides[first:i], False, True)
            segments[i].stored = stored
        first = i + 1
    return solved


@apart
def _solve_pulleys(state: State, segments: Segments, guides: Guides) -> bool:
    """Tensions and flows of branches that draw their tendon through one another."""
    solved = False
    for _ in range(_PASSES):
        for i in range(len(guides) - 1, -1, -1):  # those that are fed come later on the path
            if guides[i].is_pulley != 0.0:
                guides[i].flow, guides[i].slip = 0.0, 0.0
                guides[i].flow = -_drawn_through(segments, guides, i)
        for j in range(len(segments)):
            segments[j].tension = segments[j].previous_tension
        solved = _solve_in_order(state, segments, guides)
    return solved


@compiled
def solve_branches(state: State, segments: Segments, guides: Guides) -> bool:
    """Tensions and flows of all branches."""
    if state.pulleys > 0.0:
        return _solve_pulleys(state, segments, guides)
    return _solve_in_order(state, segments, guides)


@compiled
def refill_inputs(segments: Segments, guides: Guides) -> None:
    """Let tendon in at the input: each branch's first segment holds the length of its tension."""
    for j in range(len(segments)):
        if j == 0 or guides[j - 1].is_pulley != 0.0:
            segments[j].stored = held(segments, j, segments[j].trial_tension)[0]
