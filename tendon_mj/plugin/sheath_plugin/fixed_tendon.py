"""Cables that are not drawn: a fixed tendon as the drive of its joints.

A fixed tendon of length l = Σ k_i q_i stands for two cables that turn drums of radius r by l, one
each way. One of them is shorter by r l, so that D = −r ∂l/∂q. T_0 = F/r, with F MuJoCo's force
along l, is its tension less that of the other, and may have either sign. One guide has all bends.

Two cables that were laid with the pretension P keep their mean tension, as the one gives what the
other takes, and so lose P times the sum of both exponents, whatever the load. From the load on at
which one is slack, the other loses as any tendon. The friction f on T_0 is the larger of the two,
with λ and λ' the exponents of either direction:

    max(P (λ + λ'), |T_0| (e^λ − 1))     where the load drives,
    max(P (λ + λ'), |T_0| (1 − e^−λ'))   where it is driven.

A gear before the cables has the friction c |T_g| on the tension T_g that it hands on to them, so
that between them T_g is from η_f T_0 to T_0/η_b at rest.

Equations: docs/theory.md, section 8.
"""

from __future__ import annotations

import mujoco

from tendon_mj.native import apart, compiled
from tendon_mj.plugin.abi.layout import Model
from tendon_mj.plugin.sheath_plugin.state import State
from tendon_mj.sheath import Guides, Segments
from tendon_mj.typing import FloatArray

_ON_JOINT = mujoco.mjtWrap.mjWRAP_JOINT.value


@compiled
def is_fixed(m: Model, tendon: int) -> bool:
    """Return whether a tendon is fixed, a sum of joint positions."""
    return m.wrap_type[m.tendon_adr[tendon]] == _ON_JOINT


@compiled
def coefficient_of(m: Model, tendon: int, joint: int) -> float:
    """Coefficient of a fixed tendon over this joint alone; 0 if it is not such a one."""
    first = m.tendon_adr[tendon]
    if not is_fixed(m, tendon) or m.tendon_num[tendon] != 1:
        return 0.0
    return m.wrap_prm[first] if m.wrap_objid[first] == joint else 0.0


@compiled
def metres(state: State) -> float:
    """Length that a cable becomes longer by per unit of its tendon's length."""
    return -state.radius if state.fixed != 0.0 else 1.0


@apart
def lay_fixed(state: State, segments: Segments, guides: Guides) -> None:
    """Lay the cable of a fixed tendon, which has no path."""
    for j in range(len(segments)):
        segments[j].point, segments[j].divisor = -1.0, 1.0
        segments[j].length = abs(state.radius)  # by which motion is told from rounding
    for i in range(len(guides)):
        guides[i].angle = 0.0


@apart
def add_fixed_row(m: Model, state: State, row: FloatArray) -> None:
    """Add D of a fixed tendon."""
    tendon = int(state.tendon)
    first = m.tendon_adr[tendon]
    for k in range(first, first + m.tendon_num[tendon]):
        row[m.jnt_dofadr[m.wrap_objid[k]]] += metres(state) * m.wrap_prm[k]
