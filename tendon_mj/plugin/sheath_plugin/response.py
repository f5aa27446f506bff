"""The change of velocity that a force causes in a step, as MuJoCo integrates it.

    v⁺ − v = h M̂⁻¹ F,   M̂ = M + h B + h Σ k r rᵀ

with B the damping of joints, which Euler's method and the implicit ones integrate implicitly, and,
for the implicit ones, k the force per velocity of each actuator whose moment is r, and of each
sheathed tendon. Of k r rᵀ only what joins a degree of freedom and one further from the world
counts, as in MuJoCo: M̂ = LᵀDL with an L that is 0 elsewhere, as that of M.
"""

from __future__ import annotations

import mujoco

from tendon_mj.native import apart, compiled
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.abi.library import mj_applyFT
from tendon_mj.plugin.abi.memory import address_of, coordinates, doubles
from tendon_mj.typing import FloatArray

_EULER = mujoco.mjtIntegrator.mjINT_EULER.value
_RK4 = mujoco.mjtIntegrator.mjINT_RK4.value
_OFF = mujoco.mjtDisableBit.mjDSBL_DAMPER.value
_EULER_OFF = _OFF | mujoco.mjtDisableBit.mjDSBL_EULERDAMP.value
_ACTUATION_OFF = mujoco.mjtDisableBit.mjDSBL_ACTUATION.value
_AFFINE = mujoco.mjtBias.mjBIAS_AFFINE.value


@compiled
def is_implicit(m: Model) -> bool:
    """Return whether MuJoCo integrates the velocity terms of actuators and tendons implicitly."""
    return m.opt.integrator not in (_EULER, _RK4)


@compiled
def response_size(m: Model) -> int:
    """Numbers of memory for the factor of M̂, (nv, nv), and the inverse of D."""
    return (m.nv + 1) * m.nv


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


@compiled
def _row_at(m: Model, work: int, k: int) -> FloatArray:
    """Row k of M̂, and then of L."""
    return coordinates(work + 8 * m.nv * k)


@compiled
def weights_at(work: int, nv: int) -> FloatArray:
    """The inverse of D: w of F M̂⁻¹ G = Σ w_k y_k z_k, with y and z the forces F and G half way."""
    return coordinates(work + 8 * nv * nv)


@apart
def begin_response(m: Model, d: Data, work: int) -> None:
    """Set M̂ without actuators and tendons, in the pose at hand."""
    inertia, columns, damping, h = d.M, m.M_colind, m.dof_damping, m.opt.timestep
    parents = m.dof_parentid
    integrator, off = m.opt.integrator, m.opt.disableflags
    damped = off & (_EULER_OFF if integrator == _EULER else _OFF) == 0 and integrator != _RK4
    for k in range(m.nv):
        row, start = _row_at(m, work, k), m.M_rowadr[k]
        i = parents[k]
        while i >= 0:
            row[i] = 0.0
            i = parents[i]
        for a in range(start, start + m.M_rownnz[k]):
            row[columns[a]] = inertia[a]
        if damped:
            row[k] += h * max(0.0, damping[k])


@apart
def add_damper(m: Model, work: int, moment: FloatArray, damping: float) -> None:
    """Add h k r rᵀ to M̂."""
    parents = m.dof_parentid
    for k in range(m.nv):
        pull, row, i = m.opt.timestep * damping * moment[k], _row_at(m, work, k), k
        while pull != 0.0 and i >= 0:
            row[i] += pull * moment[i]
            i = parents[i]


@apart
def factor_response(m: Model, work: int) -> None:
    """Factor M̂."""
    nv, parents, inverse = m.nv, m.dof_parentid, weights_at(work, m.nv)
    for k in range(nv - 1, -1, -1):
        row, i = _row_at(m, work, k), parents[k]
        inverse[k] = 1.0 / row[k]
        while i >= 0:
            above, j, share = _row_at(m, work, i), i, row[i] * inverse[k]
            while j >= 0:
                above[j] -= share * row[j]
                j = parents[j]
            i = parents[i]
        i = parents[k]
        while i >= 0:
            row[i] *= inverse[k]
            i = parents[i]


@compiled
def _solve_upper(m: Model, work: int, x: FloatArray) -> None:
    """Replace x by L⁻ᵀ x."""
    parents = m.dof_parentid
    for k in range(m.nv - 1, -1, -1):
        if x[k] != 0.0:
            row, i = _row_at(m, work, k), parents[k]
            while i >= 0:
                x[i] -= row[i] * x[k]
                i = parents[i]


@apart
def go_half_way(m: Model, work: int, force: FloatArray, half: FloatArray) -> None:
    """Set ``half`` to L⁻ᵀ F for a force F."""
    for k in range(m.nv):
        half[k] = force[k]
    _solve_upper(m, work, half)


@apart
def go_on(m: Model, work: int, x: FloatArray) -> None:
    """Replace a force that is half way, times the weights, by M̂⁻¹ times it."""
    parents = m.dof_parentid
    for k in range(m.nv):
        row, i = _row_at(m, work, k), parents[k]
        while i >= 0:
            x[k] -= row[i] * x[i]
            i = parents[i]


@apart
def respond(m: Model, work: int, x: FloatArray) -> None:
    """Replace a force by M̂⁻¹ times it."""
    inverse = weights_at(work, m.nv)
    _solve_upper(m, work, x)
    for k in range(m.nv):
        x[k] *= inverse[k]
    go_on(m, work, x)


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
