"""The change of velocity that a force causes in a step, as MuJoCo integrates it.

    v⁺ − v = h M̂⁻¹ F,   M̂ = M + h B + h Σ k r rᵀ

with B the damping of joints, which Euler's method and the implicit ones integrate implicitly, and,
for the implicit ones, k the force per velocity of each actuator whose moment is r, and of each
sheathed tendon. M̂⁻¹ F is that of M + h B, which is factored as MuJoCo factors M, M + h B = LᵀDL,
less a multiple of each u = M̂⁻¹ r, dampers being added in turn (Sherman and Morrison).
"""

from __future__ import annotations

from collections.abc import Callable

import mujoco

from tendon_mj.native import Record, apart, compiled
from tendon_mj.plugin.abi.layout import LAYOUT
from tendon_mj.plugin.abi.memory import (
    byte,
    coordinates,
    double,
    doubles,
    integer,
    pointer,
    size,
)
from tendon_mj.sheath import record_type
from tendon_mj.typing import FloatArray

_EULER = mujoco.mjtIntegrator.mjINT_EULER.value
_RK4 = mujoco.mjtIntegrator.mjINT_RK4.value
_OFF = mujoco.mjtDisableBit.mjDSBL_DAMPER.value
_EULER_OFF = _OFF | mujoco.mjtDisableBit.mjDSBL_EULERDAMP.value
_ACTUATION_OFF = mujoco.mjtDisableBit.mjDSBL_ACTUATION.value
_AFFINE = mujoco.mjtBias.mjBIAS_AFFINE.value
_BIAS_BYTES = 8 * mujoco.mjNBIAS
_SMALL = 1e-3  # h k rᵀM̂⁻¹r up to which a damper changes nothing that matters


class _Response:
    """Sizes; the factor, the inverse of D, room for a force, and the rows u follow."""

    numbers: float  # of the factor
    dofs: float
    rows: float  # how many rows u there are


_RESPONSE = record_type(_Response)
_COUNT = _RESPONSE.itemsize // 8
_response_at: Callable[[int], _Response] = Record(_RESPONSE)


@compiled
def _numbers(m: int) -> int:
    """Numbers of a factor of M."""
    last = size(m + LAYOUT.m_nv) - 1
    if last < 0:
        return 0
    begin = integer(pointer(m + LAYOUT.m_M_rowadr), last)
    return begin + integer(pointer(m + LAYOUT.m_M_rownnz), last)


@compiled
def is_implicit(m: int) -> bool:
    """Whether MuJoCo integrates the velocity terms of actuators and tendons implicitly."""
    integrator = integer(m + LAYOUT.o_integrator, 0)
    return integrator != _EULER and integrator != _RK4


@compiled
def most_dampers(m: int, tendons: int) -> int:
    """Dampers that may be integrated implicitly, with so many sheathed tendons."""
    return size(m + LAYOUT.m_nactuator) + tendons if is_implicit(m) else 0


@compiled
def response_size(m: int, tendons: int) -> int:
    """Numbers of memory for the response, with so many sheathed tendons."""
    nv = size(m + LAYOUT.m_nv)
    return _COUNT + _numbers(m) + 2 * nv + (most_dampers(m, tendons) + 1) * (nv + 1)


@compiled
def damping_of(m: int, d: int, actuator: int) -> float:
    """Force per velocity of an actuator, where it is implicit [N s/m or N m s/rad]."""
    off = integer(m + LAYOUT.o_disableflags, 0)
    if off & _ACTUATION_OFF != 0 or not is_implicit(m):
        return 0.0
    if integer(pointer(m + LAYOUT.m_actuator_biastype), actuator) != _AFFINE:
        return 0.0
    damping = -doubles(pointer(m + LAYOUT.m_actuator_biasprm) + _BIAS_BYTES * actuator, 3)[2]
    if damping != 0.0 and byte(pointer(m + LAYOUT.m_actuator_forcelimited), actuator) != 0:
        adr = integer(pointer(m + LAYOUT.m_actuator_outadr), actuator)
        limits = doubles(pointer(m + LAYOUT.m_actuator_forcerange) + 16 * actuator, 2)
        if not limits[0] < double(pointer(d + LAYOUT.d_actuator_force), adr) < limits[1]:
            return 0.0
    return damping


@apart
def _factor(m: int, d: int, factor: FloatArray, inverse: FloatArray) -> None:
    """Factor M + h B."""
    nv, count = size(m + LAYOUT.m_nv), _numbers(m)
    inertia = coordinates(pointer(d + LAYOUT.d_M))
    for k in range(count):
        factor[k] = inertia[k]
    starts, counts = pointer(m + LAYOUT.m_M_rowadr), pointer(m + LAYOUT.m_M_rownnz)
    columns, h = pointer(m + LAYOUT.m_M_colind), double(m + LAYOUT.o_timestep, 0)
    integrator, off = integer(m + LAYOUT.o_integrator, 0), integer(m + LAYOUT.o_disableflags, 0)
    damped = off & (_EULER_OFF if integrator == _EULER else _OFF) == 0 and integrator != _RK4
    if damped:
        damping = coordinates(pointer(m + LAYOUT.m_dof_damping))
        for i in range(nv):
            factor[integer(starts, i) + integer(counts, i) - 1] += h * max(0.0, damping[i])
    for k in range(nv - 1, -1, -1):
        start, others = integer(starts, k), integer(counts, k) - 1
        inverse[k] = 1.0 / factor[start + others]
        for a in range(others - 1, -1, -1):  # from the nearest ancestor on
            i = integer(columns, start + a)
            share = factor[start + a] * inverse[k]
            row = integer(starts, i)
            for b in range(a + 1):
                factor[row + b] -= share * factor[start + b]
        for a in range(others):
            factor[start + a] *= inverse[k]


@compiled
def _solve_upper(m: int, factor: FloatArray, x: FloatArray) -> None:
    """Replace x by L⁻ᵀ x."""
    starts, counts = pointer(m + LAYOUT.m_M_rowadr), pointer(m + LAYOUT.m_M_rownnz)
    columns = pointer(m + LAYOUT.m_M_colind)
    for i in range(size(m + LAYOUT.m_nv) - 1, -1, -1):
        if x[i] != 0.0:
            start, pull = integer(starts, i), x[i]
            for a in range(start, start + integer(counts, i) - 1):
                x[integer(columns, a)] -= factor[a] * pull


@apart
def _solve(m: int, factor: FloatArray, inverse: FloatArray, x: FloatArray) -> None:
    """Replace x by (M + h B)⁻¹ x."""
    nv = size(m + LAYOUT.m_nv)
    starts, counts = pointer(m + LAYOUT.m_M_rowadr), pointer(m + LAYOUT.m_M_rownnz)
    columns = pointer(m + LAYOUT.m_M_colind)
    _solve_upper(m, factor, x)
    for i in range(nv):
        x[i] *= inverse[i]
        start = integer(starts, i)
        for a in range(start, start + integer(counts, i) - 1):
            x[i] -= factor[a] * x[integer(columns, a)]


@compiled
def _factor_at(work: int) -> FloatArray:
    return coordinates(work + 8 * _COUNT)


@compiled
def _inverse_at(work: int) -> FloatArray:
    return coordinates(work + 8 * (_COUNT + int(_response_at(work).numbers)))


@compiled
def _force_at(work: int) -> FloatArray:
    """Room for the force that is being replaced."""
    response = _response_at(work)
    return coordinates(work + 8 * (_COUNT + int(response.numbers) + int(response.dofs)))


@compiled
def _row_at(work: int, k: int) -> FloatArray:
    """A row u, and its factor h k / (1 + h k rᵀu)."""
    response = _response_at(work)
    dofs = int(response.dofs)
    return coordinates(work + 8 * (_COUNT + int(response.numbers) + 2 * dofs + k * (dofs + 1)))


@apart
def prepare_response(m: int, d: int, work: int) -> None:
    """Set up M̂ without any damper, in the pose at hand."""
    response = _response_at(work)
    response.numbers, response.dofs, response.rows = _numbers(m), size(m + LAYOUT.m_nv), 0.0
    _factor(m, d, _factor_at(work), _inverse_at(work))


@compiled
def response_width(work: int) -> int:
    """Numbers of a force half way to its response."""
    return int(_response_at(work).dofs) + int(_response_at(work).rows)


@apart
def set_weights(work: int, weights: FloatArray) -> None:
    """Set w of F M̂⁻¹ G = Σ w_k y_k z_k, with y and z the forces F and G half way."""
    dofs = int(_response_at(work).dofs)
    inverse = _inverse_at(work)
    for i in range(dofs):
        weights[i] = inverse[i]
    for k in range(int(_response_at(work).rows)):
        weights[dofs + k] = -_row_at(work, k)[dofs]


@apart
def go_half_way(m: int, work: int, force: FloatArray, half: FloatArray) -> None:
    """Set ``half`` to L⁻ᵀ F, and to u F of each damper, for a force F."""
    dofs = int(_response_at(work).dofs)
    for i in range(dofs):
        half[i] = force[i]
    for k in range(int(_response_at(work).rows)):
        row, along = _row_at(work, k), 0.0
        for i in range(dofs):
            along += row[i] * force[i]
        half[dofs + k] = along
    _solve_upper(m, _factor_at(work), half)


@apart
def respond(m: int, work: int, x: FloatArray) -> None:
    """Replace a force by M̂⁻¹ times it."""
    response = _response_at(work)
    dofs, rows = int(response.dofs), int(response.rows)
    force = _force_at(work)
    if rows > 0:
        for i in range(dofs):
            force[i] = x[i]
    _solve(m, _factor_at(work), _inverse_at(work), x)
    for k in range(rows):
        row = _row_at(work, k)
        along = 0.0
        for i in range(dofs):
            along += row[i] * force[i]
        for i in range(dofs):
            x[i] -= row[dofs] * along * row[i]


@apart
def add_damper(m: int, work: int, moment: FloatArray, damping: float) -> None:
    """Add h k r rᵀ to M̂; a damper that is too weak to matter is left out."""
    response = _response_at(work)
    dofs = int(response.dofs)
    row = _row_at(work, int(response.rows))
    for i in range(dofs):
        row[i] = moment[i]
    respond(m, work, row)
    mobility = 0.0
    for i in range(dofs):
        mobility += moment[i] * row[i]
    strength = double(m + LAYOUT.o_timestep, 0) * damping
    if strength * mobility > _SMALL:
        row[dofs] = strength / (1.0 + strength * mobility)
        response.rows += 1.0


@compiled
def _add_moment(m: int, d: int, output: int, factor: float, force: FloatArray) -> None:
    """Add a multiple of the moment of an actuator's output to ``force``."""
    moments, columns = pointer(d + LAYOUT.d_actuator_moment), pointer(d + LAYOUT.d_moment_colind)
    start = integer(pointer(d + LAYOUT.d_moment_rowadr), output)
    for k in range(start, start + integer(pointer(d + LAYOUT.d_moment_rownnz), output)):
        force[integer(columns, k)] += double(moments, k) * factor


@apart
def add_actuator_dampers(m: int, d: int, work: int, moment: FloatArray) -> None:
    """Add the dampers of all actuators to M̂; ``moment`` is room for their moments."""
    nv = size(m + LAYOUT.m_nv)
    for actuator in range(size(m + LAYOUT.m_nactuator)):
        damping = damping_of(m, d, actuator)
        if not damping > 0.0:
            continue
        for i in range(nv):
            moment[i] = 0.0
        output = integer(pointer(m + LAYOUT.m_actuator_outadr), actuator)
        _add_moment(m, d, output, 1.0, moment)
        add_damper(m, work, moment, damping)


@apart
def add_smooth_forces(m: int, d: int, force: FloatArray) -> None:
    """Add the forces of actuators, as they are by now, applied forces and bias to ``force``.

    MuJoCo sums them up later. Forces on bodies, `xfrc_applied`, and those of constraints are not
    among them.
    """
    nv = size(m + LAYOUT.m_nv)
    applied = coordinates(pointer(d + LAYOUT.d_qfrc_applied))
    bias = coordinates(pointer(d + LAYOUT.d_qfrc_bias))
    for i in range(nv):
        force[i] += applied[i] - bias[i]
    if integer(m + LAYOUT.o_disableflags, 0) & _ACTUATION_OFF != 0:
        return
    forces = pointer(d + LAYOUT.d_actuator_force)
    for output in range(size(m + LAYOUT.m_nout)):
        if double(forces, output) != 0.0:
            _add_moment(m, d, output, double(forces, output), force)
