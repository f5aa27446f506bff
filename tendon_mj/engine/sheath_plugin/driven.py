"""A sheath that MuJoCo drives: its input tension is given, friction decides what arrives.

The input tension is T_in = max(0, −f) with f of `input_force`; a force that pushes passes the
sheath unrubbed. Each branch has a friction state of its own. A branch behind a pulley starts with
T_in over its divisor; one that begins at the site where an earlier one ended takes over what
arrived there.

Whatever the tendon's stiffness, its tensions stay within T_in e^{±Σμφ}, so that no step is too
large to be stable. A stretch of tendon that its guides hold is a spring EA/ℓ on the inertia that it
meets, 1/a with a = J M⁻¹ Jᵀ. Where h² a EA/ℓ is far above 1 the step does not resolve how the
tendon comes to rest there: friction then changes its sense from step to step instead of holding. A
stiffness beyond

    EA = max(100 kN, min_j ℓ_j / (h² a_j))

over the spans j that joints lengthen, in the pose of the first evaluation, therefore acts as this.
The tendon hardly stretches under it, so that it is nearer to one of any greater stiffness than what
the step would make of that one. Where none is given it is this, 1 MN at most.
"""

from __future__ import annotations

import math

from tendon_mj.abi.layout import Layout
from tendon_mj.abi.library import mj_freeStack, mj_markStack, mj_stackAllocNum
from tendon_mj.abi.memory import coordinates, pointer, size
from tendon_mj.compilation import apart, compiled
from tendon_mj.engine.sheath_plugin.forces import pull_segment
from tendon_mj.engine.sheath_plugin.input_force import input_strain
from tendon_mj.engine.sheath_plugin.state import State
from tendon_mj.engine.sheath_plugin.strain_law import reset_to_linear
from tendon_mj.sheath.records import Guides, Segments
from tendon_mj.sheath.segment_law import held, strain_at
from tendon_mj.sheath.tension_solver import solve_flow

_INEXTENSIBLE = 1e5  # EA under which the pull of muscles and motors stretches a tendon little [N]
_STIFFEST = 1e6  # EA where none is given [N]


@apart
def limit_stiffness(
    layout: Layout, m: int, d: int, state: State, segments: Segments, h: float
) -> None:
    """Limit the axial stiffness to what a step of h resolves; choose it where none is given.

    Args:
        layout, m, d: where things are, `mjModel`, `mjData`.
        state, segments: of the sheath.
        h: time step [s].
    """
    resolved, nv = math.inf, size(m + layout.m_nv)
    inverse = coordinates(pointer(m + layout.m_dof_invweight0))  # diagonal of M⁻¹ in `qpos0`
    mj_markStack(d)
    jacobian = coordinates(mj_stackAllocNum(d, nv))
    for j in range(len(segments)):
        mobility = 0.0
        for dof in range(nv):
            jacobian[dof] = 0.0
        pull_segment(layout, m, d, state, segments[j], -1.0, jacobian)
        for dof in range(nv):
            mobility += jacobian[dof] * jacobian[dof] * inverse[dof]
        if mobility > 0.0:
            resolved = min(resolved, segments[j].length / (h * h * mobility))
    mj_freeStack(d)
    given = state.law.axial_stiffness if state.law.axial_stiffness > 0.0 else _STIFFEST
    state.law.axial_stiffness = min(given, max(_INEXTENSIBLE, resolved))


@compiled
def lay_at_rest(state: State, segments: Segments) -> None:
    """Lay the tendon along its path under the input tension, before anything rubs."""
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
    if source < 0:
        return input_strain(state) / segments[first].divisor
    return segments[source].tension * (segments[source].divisor / segments[first].divisor)


@compiled
def solve_branches(state: State, segments: Segments, guides: Guides) -> bool:
    """Tensions and flows of all branches, in the order of the path."""
    first, solved, last = 0, True, len(guides)
    for i in range(last + 1):
        if i < last and guides[i].is_pulley == 0.0:
            continue
        segments[first].tension = _input(state, segments, guides, first)
        if i > first:
            solved &= solve_flow(segments[first : i + 1], guides[first:i], False, True)
        first = i + 1
    return solved


@compiled
def refill_inputs(segments: Segments, guides: Guides) -> None:
    """What came in at the input: each branch's first segment holds what its tension says."""
    for j in range(len(segments)):
        if j == 0 or guides[j - 1].is_pulley != 0.0:
            segments[j].stored = held(segments, j, segments[j].trial_tension)[0]
