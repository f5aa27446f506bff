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
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.abi.library import mj_applyFT
from tendon_mj.plugin.abi.memory import address_of, coordinates, doubles
from tendon_mj.sheath import record_type
from tendon_mj.typing import FloatArray

_EULER = mujoco.mjtIntegrator.mjINT_EULER.value
_RK4 = mujoco.mjtIntegrator.mjINT_RK4.value
_OFF = mujoco.mjtDisableBit.mjDSBL_DAMPER.value
_EULER_OFF = _OFF | mujoco.mjtDisableBit.mjDSBL_EULERDAMP.value
_ACTUATION_OFF = mujoco.mjtDisableBit.mjDSBL_ACTUATION.value
_AFFINE = mujoco.mjtBias.mjBIAS_AFFINE.value
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
def _numbers(m: Model) -> int:
    """Numbers of a factor of M."""
    last = m.nv - 1
    if last < 0:
        return 0
    return m.M_rowadr[last] + m.M_rownnz[last]


@compiled
def is_implicit(m: Model) -> bool:
    """Return whether MuJoCo integrates the velocity terms of actuators and tendons implicitly."""
    return m.opt.integrator not in (_EULER, _RK4)


@compiled
def most_dampers(m: Model, tendons: int) -> int:
    """Dampers that may be integrated implicitly, with so many sheathed tendons."""
    return m.nactuator + tendons if is_implicit(m) else 0


@compiled
def response_size(m: Model, tendons: int) -> int:
    """Numbers of memory for the response, with so many sheathed tendons."""
    nv = m.nv
    return _COUNT + _numbers(m) + 2 * nv + (most_dampers(m, tendons) + 1) * (nv + 1)


@compiled
def damping_of(m: Model, d: Data, actuator: int) -> float:
    """Force per velocity of an actuator, where it is implicit [N s/m or N m s/rad]."""
    if m.opt.disableflags & _ACTUATION_OFF or not is_implicit(m):
        return 0.0
    if m.actuator_biastype[actuator] != _AFFINE:
        return 0.0
    damping = -m.actuator_biasprm[actuator, 2]
    if damping != 0.0 and m.actuator_forcelimited[actuator]:
        adr = m.actuator_outadr[actuator]
        limits = m.actuator_forcerange[actuator]
        if not limits[0] < d.actuator_force[adr] < limits[1]:
            return 0.0
    return damping


@apart
def _factor(m: Model, d: Data, factor: FloatArray, inverse: FloatArray) -> None:
    """Factor M + h B."""
    nv, count = m.nv, _numbers(m)
    inertia = d.M
    for k in range(count):
        factor[k] = inertia[k]
    starts, counts = m.M_rowadr, m.M_rownnz
    columns, h = m.M_colind, m.opt.timestep
    integrator, off = m.opt.integrator, m.opt.disableflags
    damped = off & (_EULER_OFF if integrator == _EULER else _OFF) == 0 and integrator != _RK4
    if damped:
        damping = m.dof_damping
        for i in range(nv):
            factor[starts[i] + counts[i] - 1] += h * max(0.0, damping[i])
    for k in range(nv - 1, -1, -1):
        start, others = starts[k], counts[k] - 1
        inverse[k] = 1.0 / factor[start + others]
        for a in range(others - 1, -1, -1):  # from the nearest ancestor on
            i = columns[start + a]
            share = factor[start + a] * inverse[k]
            row = starts[i]
            for b in range(a + 1):
                factor[row + b] -= share * factor[start + b]
        for a in range(others):
            factor[start + a] *= inverse[k]


@compiled
def _solve_upper(m: Model, factor: FloatArray, x: FloatArray) -> None:
    """Replace x by L⁻ᵀ x."""
    starts, counts = m.M_rowadr, m.M_rownnz
    columns = m.M_colind
    for i in range(m.nv - 1, -1, -1):
        if x[i] != 0.0:
            start, pull = starts[i], x[i]
            for a in range(start, start + counts[i] - 1):
                x[columns[a]] -= factor[a] * pull


@apart
def _solve(m: Model, factor: FloatArray, inverse: FloatArray, x: FloatArray) -> None:
    """Replace x by (M + h B)⁻¹ x."""
    nv = m.nv
    starts, counts = m.M_rowadr, m.M_rownnz
    columns = m.M_colind
    _solve_upper(m, factor, x)
    for i in range(nv):
        x[i] *= inverse[i]
        start = starts[i]
        for a in range(start, start + counts[i] - 1):
            x[i] -= factor[a] * x[columns[a]]


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
def prepare_response(m: Model, d: Data, work: int) -> None:
    """Set up M̂ without any damper, in the pose at hand."""
    response = _response_at(work)
    response.numbers, response.dofs, response.rows = _numbers(m), m.nv, 0.0
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
def go_half_way(m: Model, work: int, force: FloatArray, half: FloatArray) -> None:
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
def respond(m: Model, work: int, x: FloatArray) -> None:
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
def add_damper(m: Model, work: int, moment: FloatArray, damping: float) -> None:
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
    strength = m.opt.timestep * damping
    if strength * mobility > _SMALL:
        row[dofs] = strength / (1.0 + strength * mobility)
        response.rows += 1.0


@compiled
def _add_moment(m: Model, d: Data, output: int, factor: float, force: FloatArray) -> None:
    """Add a multiple of the moment of an actuator's output to ``force``."""
    moments, columns = d.actuator_moment, d.moment_colind
    start = d.moment_rowadr[output]
    for k in range(start, start + d.moment_rownnz[output]):
        force[columns[k]] += moments[k] * factor


@apart
def add_actuator_dampers(m: Model, d: Data, work: int, moment: FloatArray) -> None:
    """Add the dampers of all actuators to M̂; ``moment`` is room for their moments."""
    nv = m.nv
    for actuator in range(m.nactuator):
        damping = damping_of(m, d, actuator)
        if not damping > 0.0:
            continue
        for i in range(nv):
            moment[i] = 0.0
        _add_moment(m, d, m.actuator_outadr[actuator], 1.0, moment)
        add_damper(m, work, moment, damping)


@apart
def add_smooth_forces(m: Model, d: Data, target: int) -> None:
    """Add forces of actuators, as they are by now, applied ones and bias to those at ``target``.

    MuJoCo sums them up later, with those of constraints.
    """
    force, applied, bias = coordinates(target), d.qfrc_applied, d.qfrc_bias
    for i in range(m.nv):
        force[i] += applied[i] - bias[i]
    wrenches, places = address_of(d.xfrc_applied), address_of(d.xipos)
    for body in range(1, m.nbody):
        wrench, acts = doubles(wrenches + 48 * body, 6), False
        for k in range(6):
            acts = acts or wrench[k] != 0.0
        if acts:
            begin = wrenches + 48 * body
            mj_applyFT(m, d, begin, begin + 24, places + 24 * body, body, target)
    if m.opt.disableflags & _ACTUATION_OFF:
        return
    forces = d.actuator_force
    for output in range(m.nout):
        if forces[output] != 0.0:
            _add_moment(m, d, output, forces[output], force)
