"""The strain law of the tendon: Hooke's, with damping, stiffening and creep where asked for.

    T = EA ε_e (1 + κ ε_e) + c dε_e/dt,   ε = ε_e + ε_c,   τ_c dε_c/dt = χ T/EA − ε_c

The flow solver knows strains ε = d + a τ. Time derivatives become that by backward Euler; a tendon
that stiffens by its tangent, which is moved until the solution lies on it.

Equations: docs/theory.md, sections 4 and 7.
"""

from __future__ import annotations

from typing import Any

from tendon_mj.compilation import apart, compiled
from tendon_mj.engine.sheath_plugin import state as st
from tendon_mj.sheath.segments import borne, strain_at
from tendon_mj.sheath.tables import FLOW, GIVE, LENGTH, OFFSET, SHARE, STORED, TENSION

_CLOSE = 1e-13  # strain by which the tangent may miss the curve


@compiled
def rest_strain(state: Any) -> tuple[float, float]:
    """Elastic strain and creep strain under the pretension, when all has come to rest."""
    tau = state[st.PRETENSION] / state[st.AXIAL_STIFFNESS]
    crept = state[st.CREEP] * tau if state[st.CREEP_TIME] > 0.0 else 0.0
    return strain_at(tau, state[st.STIFFENING]), crept


@compiled
def _arrival(state: Any, elapsed: float) -> float:
    """Share of the creep still missing that comes within the step."""
    if state[st.CREEP_TIME] == 0.0:
        return 0.0
    return elapsed / (state[st.CREEP_TIME] + elapsed)


@compiled
def _tangent(state: Any, before: float, at: float, elapsed: float) -> tuple[float, float]:
    """Offset and share of the elastic strain, ``before`` being what it was, on the tangent ``at``.

    With K = c/(EA Δt), τ = g(ε) = ε (1 + κ ε) + K (ε − ε⁻); for κ = 0 that is a line.
    """
    kappa = state[st.AXIAL_DAMPING] / (state[st.AXIAL_STIFFNESS] * elapsed)
    stiffening = state[st.STIFFENING]
    if stiffening == 0.0:
        share = 1.0 / (1.0 + kappa)
        return (1.0 - share) * before, share
    at = max(0.0, at)
    share = 1.0 / (1.0 + 2.0 * stiffening * at + kappa)
    return at - (at * (1.0 + stiffening * at) + kappa * (at - before)) * share, share


@apart
def be_hookean(segments: Any) -> None:
    """ε = τ in every segment."""
    for j in range(segments.shape[1]):
        segments[OFFSET, j], segments[SHARE, j] = 0.0, 1.0


@apart
def _fill_tangents(state: Any, segments: Any, elapsed: float) -> None:
    """Strain law of each segment on the tangent at the strain that it had."""
    if state[st.STRAINED] == 0.0:
        for j in range(segments.shape[1]):
            segments[st.STRAIN, j] = strain_at(segments[st.START, j], state[st.STIFFENING])
        state[st.STRAINED] = 1.0
    arrives = _arrival(state, elapsed)
    for j in range(segments.shape[1]):
        before = segments[st.STRAIN, j]
        offset, share = _tangent(state, before, before, elapsed)
        segments[OFFSET, j] = offset + (1.0 - arrives) * segments[st.CREPT, j]
        segments[SHARE, j] = share + arrives * state[st.CREEP]


@compiled
def fill_strain(state: Any, segments: Any, elapsed: float) -> bool:
    """Fill in each segment's strain law; return whether it is another than Hooke's."""
    plain = (
        state[st.AXIAL_DAMPING] == 0.0
        and state[st.STIFFENING] == 0.0
        and state[st.CREEP_TIME] == 0.0
    )
    if plain:
        if state[st.STRAINED] != 0.0:
            be_hookean(segments)
            state[st.STRAINED] = 0.0
        return False
    _fill_tangents(state, segments, elapsed)
    return True


@apart
def move_tangents(state: Any, segments: Any, elapsed: float) -> bool:
    """Touch the strain law where the solution lies; return whether that made a difference."""
    arrives, moved = _arrival(state, elapsed), False
    for j in range(segments.shape[1]):
        tau = segments[TENSION, j]
        crept = (1.0 - arrives) * segments[st.CREPT, j]
        at = segments[OFFSET, j] - crept + (segments[SHARE, j] - arrives * state[st.CREEP]) * tau
        touching = at if tau > 0.0 else 0.0  # what a far tangent calls slack need not be
        offset, share = _tangent(state, segments[st.STRAIN, j], touching, elapsed)
        moved |= abs(offset + share * tau - at) > _CLOSE
        segments[OFFSET, j] = offset + crept
        segments[SHARE, j] = share + arrives * state[st.CREEP]
    return moved


@compiled
def crept_after(state: Any, segments: Any, j: int, elapsed: float) -> float:
    """Creep strain of segment j at the end of the step."""
    arrives = _arrival(state, elapsed)
    reached = arrives * state[st.CREEP] * segments[TENSION, j]
    return (1.0 - arrives) * segments[st.CREPT, j] + reached


@apart
def strain_after(state: Any, segments: Any, guides: Any, elapsed: float) -> None:
    """Elastic strain of every segment once the flow of this evaluation has passed."""
    n = guides.shape[1]
    for j in range(n + 1):
        holds = segments[STORED, j]
        holds += guides[FLOW, j] if j < n else 0.0
        holds -= guides[FLOW, j - 1] if j > 0 else 0.0
        length = segments[LENGTH, j] - segments[GIVE, j] * segments[TENSION, j]
        segments[st.FRESH_STRAIN, j] = (
            length / holds - 1.0 - crept_after(state, segments, j, elapsed)
        )


@apart
def leave_strain(state: Any, segments: Any) -> None:
    """Remember the strains of this evaluation, for ``carry_strain`` to make them true."""
    for j in range(segments.shape[1]):
        segments[st.TRIAL_STRAIN, j] = segments[st.FRESH_STRAIN, j]
        segments[st.TRIAL_CREPT, j] = crept_after(state, segments, j, state[st.TRIAL_ELAPSED])


@apart
def carry_strain(segments: Any, guides: Any) -> None:
    """Make the strains on trial the committed ones; what flows takes its creep strain along.

    That the tendon and not the place has crept is what keeps a flow from making energy. To be
    called before the flow changes what is stored.
    """
    for j in range(segments.shape[1]):
        segments[st.STRAIN, j] = segments[st.TRIAL_STRAIN, j]
        segments[st.CREPT, j] = segments[st.TRIAL_CREPT, j]
    for i in range(guides.shape[1]):
        flow = guides[st.TRIAL_FLOW, i]
        if flow != 0.0:
            to, source = (i, i + 1) if flow > 0.0 else (i + 1, i)
            share = abs(flow) / max(segments[STORED, to] + abs(flow), abs(flow))
            segments[st.CREPT, to] += share * (segments[st.CREPT, source] - segments[st.CREPT, to])


@compiled
def spool_torque(state: Any, segments: Any, j: int, radius: float) -> float:
    """Torque that segment j exerts on a spool: −∂U/∂θ of the elastic energy U, r (T + T²/2EA).

    The second term is the energy that goes onto the drum; with it no cycle gains any. In general
    the bracket is T (1 + ε) − w, w = w_e + EA ε_c²/2χ being the energy per unstretched length.
    """
    tau, ea = segments[TENSION, j], state[st.AXIAL_STIFFNESS]
    crept = state[st.CREEP] > 0.0 and state[st.CREEP_TIME] > 0.0
    if state[st.STIFFENING] == 0.0 and not crept:
        return radius * ea * tau * (1.0 + 0.5 * tau)
    pull = borne(tau, state[st.STIFFENING])
    if crept:
        pull += segments[st.CREPT, j] * (tau - 0.5 * segments[st.CREPT, j] / state[st.CREEP])
    return radius * ea * pull
