"""The change of velocity that a force causes in a step, as MuJoCo Warp integrates it.

The same as `tendon_mj.plugin.sheath_plugin.response`: M̂ = M + h B + h Σ k r rᵀ, factored as LᵀDL
and, for dampers that join several dofs, by rows u = M̂⁻¹ r.
"""

from typing import Any

import warp as wp

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
def _add_to_diagonal(b: Dynamics, y: Groups, dof: int, value: wp.float64, w: int) -> None:
    at = b.M_rowadr[dof] + b.M_rownnz[dof] - 1
    y.factor[at, w] = y.factor[at, w] + value


@wp.func
def _factor(b: Dynamics, y: Groups, w: int) -> None:
    """Factor M with the dampers that act on one dof."""
    h = step_of(b, w)
    for a in range(y.factor.shape[0]):
        y.factor[a, w] = wp.float64(b.M[w, a])
    if b.joints_damp:
        for i in range(b.nv):
            damping = wp.float64(b.dof_damping[w % b.dof_damping.shape[0], i])
            _add_to_diagonal(b, y, i, h * wp.max(ZERO, damping), w)
    for n in range(y.joint_damper.shape[0]):
        actuator = y.joint_damper[n]
        adr = b.moment_rowadr[w, actuator]
        i = b.moment_colind[w, adr]
        moment = wp.float64(b.actuator_moment[w, adr])
        _add_to_diagonal(b, y, i, h * damping_of(b, actuator, w) * moment * moment, w)
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
def _solve(
    b: Dynamics, y: Groups, x: wp.array2d[Any], base: int, low: int, high: int, w: int
) -> None:
    """Multiply by the inverse of what is factored; x is that of dofs from ``low`` to ``high``."""
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


@wp.func
def _along(
    b: Dynamics, y: Groups, n: int, x: wp.array2d[Any], base: int, low: int, high: int, w: int
) -> wp.float64:
    """rᵀx of damper n."""
    total = wp.float64(0.0)
    source = y.damper[n]
    if source >= 0:
        start = b.moment_rowadr[w, source]
        for a in range(start, start + b.moment_rownnz[w, source]):
            i = b.moment_colind[w, a]
            if i >= low and i < high:
                value = wp.float64(x[base + i - low, w])
                total += wp.float64(b.actuator_moment[w, a]) * value
    else:
        for e in range(y.first_dof[-1 - source], y.first_dof[-source]):
            i = y.dof[e]
            if i >= low and i < high:
                total += wp.float64(y.input_row[e, w]) * wp.float64(x[base + i - low, w])
    return total


@wp.func
def respond(
    b: Dynamics,
    y: Groups,
    x: wp.array2d[Any],
    base: int,
    low: int,
    high: int,
    dampers: int,
    w: int,
) -> None:
    """Replace a force on dofs from ``low`` to ``high`` by M̂⁻¹ times it, with the first dampers."""
    _solve(b, y, x, base, low, high, w)
    for n in range(dampers):
        if y.damper_scale[n, w] != ZERO:
            scaled = y.damper_scale[n, w] * _along(b, y, n, x, base, low, high, w)
            for i in range(low, high):
                u = wp.float64(y.damper_row[n * b.nv + i, w])
                x[base + i - low, w] = x.dtype(wp.float64(x[base + i - low, w]) - scaled * u)


@wp.func
def _add_damper(b: Dynamics, y: Groups, tendon: wp.array[wp.int32], n: int, w: int) -> None:
    """Add h k r rᵀ to M̂."""
    source, row = y.damper[n], n * b.nv
    damping = wp.float64(0.0)
    for i in range(b.nv):
        y.damper_row[row + i, w] = wp.float32(0.0)
    if source >= 0:
        damping = damping_of(b, source, w)
        start = b.moment_rowadr[w, source]
        for a in range(start, start + b.moment_rownnz[w, source]):
            y.damper_row[row + b.moment_colind[w, a], w] = b.actuator_moment[w, a]
    else:
        damping = tendon_damping(b, tendon[y.sheath[-1 - source]], w)
        for e in range(y.first_dof[-1 - source], y.first_dof[-source]):
            y.damper_row[row + y.dof[e], w] = y.input_row[e, w]
    y.damper_scale[n, w] = ZERO
    if damping > ZERO:
        respond(b, y, y.damper_row, row, 0, b.nv, n, w)
        strength = step_of(b, w) * damping
        mobility = _along(b, y, n, y.damper_row, row, 0, b.nv, w)
        y.damper_scale[n, w] = strength / (ONE + strength * mobility)


@wp.kernel(module="unique", module_options={"max_unroll": 0}, enable_backward=False)
def accelerate(b: Dynamics, t: Tendons, y: Groups) -> None:
    """Set up M̂, and the acceleration without friction; threads (worlds,)."""
    w = wp.tid()
    _factor(b, y, w)
    for n in range(y.damper.shape[0]):
        _add_damper(b, y, t.tendon, n, w)
    for i in range(b.nv):
        force = wp.float64(b.qfrc_passive[w, i] + b.qfrc_applied[w, i] - b.qfrc_bias[w, i])
        if b.has_forces:
            force += wp.float64(b.qfrc_actuator[w, i])
        y.known[i, w] = force
        if t.started[y.sheath[0], w]:
            force += y.unknown[i, w]
        y.acceleration[i, w] = force
    respond(b, y, y.acceleration, 0, 0, b.nv, y.damper.shape[0], w)
