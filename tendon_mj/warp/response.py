"""The change of velocity that a force causes in a step, as MuJoCo Warp integrates it.

The same as `tendon_mj.plugin.sheath_plugin.response`: M̂ = M + h B + h Σ k r rᵀ, factored as LᵀDL
and, for dampers that join several dofs, by rows u = M̂⁻¹ r.
"""

from typing import Any

import mujoco_warp as mjw
import warp as wp

from tendon_mj.warp.groups import Groups
from tendon_mj.warp.tendons import Tendons

wp.set_module_options({"enable_backward": False})

_ONE = wp.constant(wp.float64(1.0))
_ZERO = wp.constant(wp.float64(0.0))
_PARAMETERS = mjw.Model.__annotations__["actuator_biasprm"].dtype


@wp.struct
class Motion:
    """Inertia, dampers and smooth forces of the worlds."""

    # of the model
    timestep: wp.array[wp.float32]
    nv: wp.int32
    M_rownnz: wp.array[wp.int32]
    M_rowadr: wp.array[wp.int32]
    M_colind: wp.array[wp.int32]
    dof_damping: wp.array2d[wp.float32]
    tendon_damping: wp.array2d[wp.float32]
    actuator_trntype: wp.array[wp.int32]
    actuator_trnid: wp.array[wp.vec2i]
    actuator_gear: wp.array2d[wp.spatial_vector]
    actuator_biasprm: wp.array2d[_PARAMETERS]
    actuator_forcelimited: wp.array[wp.bool]
    actuator_forcerange: wp.array2d[wp.vec2]
    joints_damp: wp.bool  # whether dampers of joints are integrated implicitly
    implicit: wp.bool  # whether those of actuators and tendons are
    actuates: wp.bool  # whether there are forces of actuators
    damps: wp.bool  # whether the option leaves dampers on
    # of the worlds
    M: wp.array2d[wp.float32]
    qvel: wp.array2d[wp.float32]
    actuator_force: wp.array2d[wp.float32]
    moment_rownnz: wp.array2d[wp.int32]
    moment_rowadr: wp.array2d[wp.int32]
    moment_colind: wp.array2d[wp.int32]
    actuator_moment: wp.array2d[wp.float32]
    qfrc_passive: wp.array2d[wp.float32]
    qfrc_actuator: wp.array2d[wp.float32]
    qfrc_applied: wp.array2d[wp.float32]
    qfrc_bias: wp.array2d[wp.float32]


@wp.func
def step_of(q: Motion, w: int) -> wp.float64:
    """Time step [s]."""
    return wp.float64(q.timestep[w % q.timestep.shape[0]])


@wp.func
def damping_of(q: Motion, actuator: int, w: int) -> wp.float64:
    """Force per velocity of an actuator, if it is implicit [N s/m or N m s/rad]."""
    if not (q.implicit and q.actuates):
        return _ZERO
    if q.actuator_forcelimited[actuator]:
        limits = q.actuator_forcerange[w % q.actuator_forcerange.shape[0], actuator]
        force = q.actuator_force[w, actuator]
        if force <= limits[0] or force >= limits[1]:
            return _ZERO
    parameters = q.actuator_biasprm[w % q.actuator_biasprm.shape[0], actuator]
    return wp.max(_ZERO, -wp.float64(parameters[2]))


@wp.func
def tendon_damping(q: Motion, tendon: int, w: int) -> wp.float64:
    """Linear damping of a tendon itself, if it is implicit [N s/m]."""
    if not (q.implicit and q.damps):
        return _ZERO
    return wp.float64(q.tendon_damping[w % q.tendon_damping.shape[0], tendon])


@wp.func
def _add_to_diagonal(q: Motion, y: Groups, dof: int, value: wp.float64, w: int) -> None:
    at = q.M_rowadr[dof] + q.M_rownnz[dof] - 1
    y.factor[at, w] = y.factor[at, w] + value


@wp.func
def _factor(q: Motion, y: Groups, w: int) -> None:
    """Factor M with the dampers that act on one dof."""
    h = step_of(q, w)
    for a in range(y.factor.shape[0]):
        y.factor[a, w] = wp.float64(q.M[w, a])
    if q.joints_damp:
        for i in range(q.nv):
            damping = wp.float64(q.dof_damping[w % q.dof_damping.shape[0], i])
            _add_to_diagonal(q, y, i, h * wp.max(_ZERO, damping), w)
    for n in range(y.joint_damper.shape[0]):
        actuator = y.joint_damper[n]
        adr = q.moment_rowadr[w, actuator]
        i = q.moment_colind[w, adr]
        moment = wp.float64(q.actuator_moment[w, adr])
        _add_to_diagonal(q, y, i, h * damping_of(q, actuator, w) * moment * moment, w)
    for back in range(q.nv):
        k = q.nv - 1 - back
        start, others = q.M_rowadr[k], q.M_rownnz[k] - 1
        inverse = _ONE / y.factor[start + others, w]
        y.inverse[k, w] = inverse
        for down in range(others):  # from the nearest ancestor on
            a = others - 1 - down
            row = q.M_rowadr[q.M_colind[start + a]]
            share = y.factor[start + a, w] * inverse
            for b in range(a + 1):
                y.factor[row + b, w] = y.factor[row + b, w] - share * y.factor[start + b, w]
        for a in range(others):
            y.factor[start + a, w] = y.factor[start + a, w] * inverse


@wp.func
def _solve(
    q: Motion, y: Groups, x: wp.array2d[Any], base: int, low: int, high: int, w: int
) -> None:
    """Multiply by the inverse of what is factored; x is that of dofs from ``low`` to ``high``."""
    at = base - low
    for back in range(high - low):
        i = high - 1 - back
        value = wp.float64(x[at + i, w])
        if value != _ZERO:
            start = q.M_rowadr[i]
            for a in range(start, start + q.M_rownnz[i] - 1):
                j = at + q.M_colind[a]
                x[j, w] = x.dtype(wp.float64(x[j, w]) - y.factor[a, w] * value)
    for i in range(low, high):
        value = wp.float64(x[at + i, w]) * y.inverse[i, w]
        start = q.M_rowadr[i]
        for a in range(start, start + q.M_rownnz[i] - 1):
            value -= y.factor[a, w] * wp.float64(x[at + q.M_colind[a], w])
        x[at + i, w] = x.dtype(value)


@wp.func
def _along(
    q: Motion, y: Groups, n: int, x: wp.array2d[Any], base: int, low: int, high: int, w: int
) -> wp.float64:
    """rᵀx of damper n."""
    total = wp.float64(0.0)
    source = y.damper[n]
    if source >= 0:
        start = q.moment_rowadr[w, source]
        for a in range(start, start + q.moment_rownnz[w, source]):
            i = q.moment_colind[w, a]
            if i >= low and i < high:
                value = wp.float64(x[base + i - low, w])
                total += wp.float64(q.actuator_moment[w, a]) * value
    else:
        for e in range(y.first_dof[-1 - source], y.first_dof[-source]):
            i = y.dof[e]
            if i >= low and i < high:
                total += wp.float64(y.input_row[e, w]) * wp.float64(x[base + i - low, w])
    return total


@wp.func
def respond(
    q: Motion,
    y: Groups,
    x: wp.array2d[Any],
    base: int,
    low: int,
    high: int,
    dampers: int,
    w: int,
) -> None:
    """Replace a force on dofs from ``low`` to ``high`` by M̂⁻¹ times it, with the first dampers."""
    _solve(q, y, x, base, low, high, w)
    for n in range(dampers):
        if y.damper_scale[n, w] != _ZERO:
            scaled = y.damper_scale[n, w] * _along(q, y, n, x, base, low, high, w)
            for i in range(low, high):
                u = wp.float64(y.damper_row[n * q.nv + i, w])
                x[base + i - low, w] = x.dtype(wp.float64(x[base + i - low, w]) - scaled * u)


@wp.func
def _add_damper(q: Motion, y: Groups, tendon: wp.array[wp.int32], n: int, w: int) -> None:
    """Add h k r rᵀ to M̂."""
    source, row = y.damper[n], n * q.nv
    damping = wp.float64(0.0)
    for i in range(q.nv):
        y.damper_row[row + i, w] = wp.float32(0.0)
    if source >= 0:
        damping = damping_of(q, source, w)
        start = q.moment_rowadr[w, source]
        for a in range(start, start + q.moment_rownnz[w, source]):
            y.damper_row[row + q.moment_colind[w, a], w] = q.actuator_moment[w, a]
    else:
        damping = tendon_damping(q, tendon[y.sheath[-1 - source]], w)
        for e in range(y.first_dof[-1 - source], y.first_dof[-source]):
            y.damper_row[row + y.dof[e], w] = y.input_row[e, w]
    y.damper_scale[n, w] = _ZERO
    if damping > _ZERO:
        respond(q, y, y.damper_row, row, 0, q.nv, n, w)
        strength = step_of(q, w) * damping
        mobility = _along(q, y, n, y.damper_row, row, 0, q.nv, w)
        y.damper_scale[n, w] = strength / (_ONE + strength * mobility)


@wp.kernel(module="unique", module_options={"max_unroll": 0}, enable_backward=False)
def accelerate(q: Motion, t: Tendons, y: Groups) -> None:
    """Set up M̂, and the acceleration without friction; threads (worlds,)."""
    w = wp.tid()
    _factor(q, y, w)
    for n in range(y.damper.shape[0]):
        _add_damper(q, y, t.tendon, n, w)
    for i in range(q.nv):
        force = wp.float64(q.qfrc_passive[w, i] + q.qfrc_applied[w, i] - q.qfrc_bias[w, i])
        if q.actuates:
            force += wp.float64(q.qfrc_actuator[w, i])
        y.known[i, w] = force
        if t.started[y.sheath[0], w]:
            force += y.unknown[i, w]
        y.acceleration[i, w] = force
    respond(q, y, y.acceleration, 0, 0, q.nv, y.damper.shape[0], w)
