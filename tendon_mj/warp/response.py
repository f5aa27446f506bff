"""The change of velocity that a force causes in a step, as MuJoCo Warp integrates it.

The same as `tendon_mj.plugin.sheath_plugin.response`: M̂ = M + h B + h Σ k r rᵀ with the sparsity
of M, factored as LᵀDL.
"""

from typing import Any

import warp as wp

from tendon_mj.warp.constraints import (
    Constraints,
    is_equality,
    push_otherwise,
    pushes_at,
    read_known,
    rows_of,
)
from tendon_mj.warp.groups import Groups
from tendon_mj.warp.motion import Dynamics
from tendon_mj.warp.tendons import ONE, ZERO, Tendons

wp.set_module_options({"enable_backward": False})


@wp.func
def step_of(b: Dynamics, w: int) -> wp.float64:
    """Time step [s]."""
    return wp.float64(b.timestep[w % b.timestep.shape[0]])


@wp.func
def damping_of(b: Dynamics, actuator: int, w: int) -> wp.float64:
    """Force per velocity of an actuator, if it is implicit [N s/m or N m s/rad]."""
    if not (b.implicit and b.has_forces):
        return ZERO
    if b.actuator_forcelimited[actuator]:
        limits = b.actuator_forcerange[w % b.actuator_forcerange.shape[0], actuator]
        force = b.actuator_force[w, actuator]
        if force <= limits[0] or force >= limits[1]:
            return ZERO
    parameters = b.actuator_biasprm[w % b.actuator_biasprm.shape[0], actuator]
    return wp.max(ZERO, -wp.float64(parameters[2]))


@wp.func
def tendon_damping(b: Dynamics, tendon: int, w: int) -> wp.float64:
    """Linear damping of a tendon itself, if it is implicit [N s/m]."""
    if not (b.implicit and b.damper != 0.0):
        return ZERO
    return wp.float64(b.tendon_damping[w % b.tendon_damping.shape[0], tendon])


@wp.func
def _begin(b: Dynamics, y: Groups, w: int) -> None:
    """Set M̂ without actuators and tendons."""
    for a in range(y.factor.shape[0]):
        y.factor[a, w] = wp.float64(b.M[w, a])
    if b.joints_damp:
        for i in range(b.nv):
            damping = wp.float64(b.dof_damping[w % b.dof_damping.shape[0], i])
            at = b.M_rowadr[i] + b.M_rownnz[i] - 1
            y.factor[at, w] = y.factor[at, w] + step_of(b, w) * wp.max(ZERO, damping)


@wp.func
def _add_moment(b: Dynamics, y: Groups, strength: wp.float64, w: int) -> None:
    """Add k r rᵀ to M̂, with r the moment at hand."""
    for i in range(b.nv):
        pull = strength * y.moment[i, w]
        if pull != ZERO:
            for at in range(b.M_rowadr[i], b.M_rowadr[i] + b.M_rownnz[i]):
                y.factor[at, w] = y.factor[at, w] + pull * y.moment[b.M_colind[at], w]


@wp.func
def _add_damper(b: Dynamics, y: Groups, tendon: wp.array[wp.int32], n: int, w: int) -> None:
    """Add h k r rᵀ of an actuator, or of a tendon, to M̂."""
    source, strength = y.damper[n], step_of(b, w)
    if source >= 0:
        strength *= damping_of(b, source, w)
    else:
        strength *= tendon_damping(b, tendon[y.sheath[-1 - source]], w)
    if strength == ZERO:
        return
    for i in range(b.nv):
        y.moment[i, w] = ZERO
    if source >= 0:
        begin = b.moment_rowadr[w, source]
        for a in range(begin, begin + b.moment_rownnz[w, source]):
            y.moment[b.moment_colind[w, a], w] = wp.float64(b.actuator_moment[w, a])
    else:
        for e in range(y.first_dof[-1 - source], y.first_dof[-source]):
            y.moment[y.dof[e], w] = wp.float64(y.input_row[e, w])
    _add_moment(b, y, strength, w)


@wp.func
def _add_constraints(b: Dynamics, c: Constraints, y: Groups, w: int) -> None:
    """Add the constraints that bear to M̂, and set their force at no acceleration."""
    for i in range(b.nv):
        y.acceleration[i, w] = ZERO
    for row in range(rows_of(c, w)):
        if read_known(c, y, row, w):
            wanted = wp.float64(c.aref[w, row])
            if is_equality(c, row, w) or pushes_at(y, wanted, y.expected, w):
                stiffness = wp.float64(c.D[w, row])
                _add_moment(b, y, stiffness, w)
                for i in range(b.nv):
                    pushed = stiffness * wanted * y.moment[i, w]
                    y.acceleration[i, w] = y.acceleration[i, w] + pushed


@wp.func
def _factor(b: Dynamics, y: Groups, w: int) -> None:
    """Factor M̂."""
    for back in range(b.nv):
        k = b.nv - 1 - back
        start, others = b.M_rowadr[k], b.M_rownnz[k] - 1
        inverse = ONE / y.factor[start + others, w]
        y.inverse[k, w] = inverse
        for down in range(others):  # from the nearest ancestor on
            a = others - 1 - down
            row = b.M_rowadr[b.M_colind[start + a]]
            share = y.factor[start + a, w] * inverse
            for c in range(a + 1):
                y.factor[row + c, w] = y.factor[row + c, w] - share * y.factor[start + c, w]
        for a in range(others):
            y.factor[start + a, w] = y.factor[start + a, w] * inverse


@wp.func
def respond(
    b: Dynamics, y: Groups, x: wp.array2d[Any], base: int, low: int, high: int, w: int
) -> None:
    """Replace a force on dofs from ``low`` to ``high`` by M̂⁻¹ times it."""
    at = base - low
    for back in range(high - low):
        i = high - 1 - back
        value = wp.float64(x[at + i, w])
        if value != ZERO:
            start = b.M_rowadr[i]
            for a in range(start, start + b.M_rownnz[i] - 1):
                j = at + b.M_colind[a]
                x[j, w] = x.dtype(wp.float64(x[j, w]) - y.factor[a, w] * value)
    for i in range(low, high):
        value = wp.float64(x[at + i, w]) * y.inverse[i, w]
        start = b.M_rowadr[i]
        for a in range(start, start + b.M_rownnz[i] - 1):
            value -= y.factor[a, w] * wp.float64(x[at + b.M_colind[a], w])
        x[at + i, w] = x.dtype(value)


@wp.kernel(module="unique", module_options={"max_unroll": 0}, enable_backward=False)
def set_response(b: Dynamics, c: Constraints, t: Tendons, y: Groups, again: bool) -> None:
    """Set up M̂, and the forces of its constraints at no acceleration; threads (worlds,).

    With ``again`` where other constraints push than were expected to; the others are solved.
    """
    w = wp.tid()
    y.pending[w] = not again or push_otherwise(c, y, w)
    if not y.pending[w]:
        return
    started = bool(False)
    if y.sheath.shape[0] > 0:
        started = t.started[y.sheath[0], w]
    for i in range(b.nv):
        last = wp.where(started, y.last[i, w], ZERO)
        y.expected[i, w] = wp.where(again, y.acceleration[i, w], last)
    _begin(b, y, w)
    for n in range(y.damper.shape[0]):
        _add_damper(b, y, t.tendon, n, w)
    _add_constraints(b, c, y, w)
    _factor(b, y, w)


@wp.kernel
def accelerate(b: Dynamics, t: Tendons, y: Groups) -> None:
    """Set the acceleration without friction; threads (worlds,)."""
    w = wp.tid()
    if not y.pending[w]:
        return
    for i in range(b.nv):
        y.borne[i, w] = ZERO
        force = wp.float64(b.qfrc_passive[w, i] + b.qfrc_applied[w, i] - b.qfrc_bias[w, i])
        if b.has_forces:
            force += wp.float64(b.qfrc_actuator[w, i])
        y.known[i, w] = force
        if t.started[y.sheath[0], w]:
            force += y.unknown[i, w]
        y.acceleration[i, w] = y.acceleration[i, w] + force
    respond(b, y, y.acceleration, 0, 0, b.nv, w)
