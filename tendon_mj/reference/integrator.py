"""Energy-conserving implicit midpoint rule with exact sticking (Numba).

**Smooth part, order 2.** Over a step h the displacement d_i = ξ_i⁺ − ξ_i solves

    2 m_i (d_i/h − v_i)/h + c_i d_i/h = a_i T̄_i − T̄_{i+1} − s_i f_i,    v_i⁺ = 2 d_i/h − v_i,

T̄ the mean tension of each spring over the step (`mean_tension`) and a_i from the direction s_i of
sliding. Taut springs make it the implicit midpoint rule; in all cases T̄ × elongation is the change
of elastic energy, so that input work = Δ elastic + Δ kinetic + friction + damping holds to rounding
(and to `TOLERANCE` where springs turn slack).

**Stick events, a projection as in Moreau's time stepping.** Directions are part of the step's
unknowns. A resting element has d_i = 0 and v_i⁺ = 0 exactly while its mean net force is within the
static limit, else it slides, at μ_d. A sliding element that the step would carry backwards is held
(d_i = 0, v_i⁺ = 0) and looked at again as a resting one in the next step; one that only ends
the step with reversed velocity ends it at rest. Its kinetic energy, O(h²), goes to the friction
work, which is therefore never negative. Each element changes its direction at most twice in a step:
the iteration ends.

An element stops within O(h²) of its place and, with μ_s = μ_d, breaks away with a force that grows
from 0: order 2 is kept. With μ_s > μ_d the force jumps, and the breakaway is off by up to h: order
1. There, whether a slip carries a neighbour along can hang on a hair: single slips differ between
steps h (T_out by some newtons at 64 light elements, the friction work by a few per cent).

Equations: docs/theory.md, section 5.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tendon_mj.compilation import checked
from tendon_mj.reference.checks import FloatArray
from tendon_mj.reference.stick import mean_tension, releases, solve_tridiagonal

TOLERANCE = 1e-13  # of the largest tension, for the mean tension of springs that turn slack
COLUMNS = 9  # of `record`


@checked
def advance(
    h: float,
    pulled: float,
    input_mean: float,
    v: FloatArray,
    tau: FloatArray,
    springs: FloatArray,
    inertia: FloatArray,
    static: FloatArray,
    dynamic: FloatArray,
    force: FloatArray,
    side: npt.NDArray[np.int64],
    d: FloatArray,
    mean: FloatArray,
    work: FloatArray,
) -> bool:
    """Find directions ``side``, displacements ``d`` and mean tensions ``mean`` of one step.

    ``pulled`` is the change of ξ_in, or the input is the tension ``input_mean`` if that is ≥ 0.
    Returns whether the step was solved. ``work`` is scratch, shape (5, n + 1).
    """
    n = v.size
    lower, diagonal, upper, right, slope = (
        work[0, :n],
        work[1, :n],
        work[2, :n],
        work[3, :n],
        work[4],
    )
    prescribed = input_mean >= 0.0
    held = np.zeros(n, dtype=np.bool_)
    for i in range(n):
        side[i] = 0 if v[i] == 0.0 else (1 if v[i] > 0.0 else -1)
        d[i] = h * v[i]
    for _ in range(4 * n + 50):
        for j in range(n + 1):  # linearise the springs: T̄_j = mean_j + slope_j · elongation
            if j == 0 and prescribed:
                mean[0], slope[0] = input_mean, 0.0
                continue
            gap = (pulled if j == 0 else d[j - 1]) - (d[j] if j < n else 0.0)
            mean[j], share = mean_tension(tau[j], tau[j] + springs[j] * gap)
            slope[j] = share * springs[j]
            mean[j] -= slope[j] * gap
        for i in range(n):
            rubs = static[0, i] > 0.0 or force[i] > 0.0
            if rubs and side[i] == 0:
                lower[i], diagonal[i], upper[i], right[i] = 0.0, 1.0, 0.0, 0.0
                continue
            ratio = 1.0
            if side[i] > 0:
                ratio = 1.0 - dynamic[0, i]
            elif side[i] < 0:
                ratio = 1.0 + dynamic[1, i]
            lower[i] = -ratio * slope[i]
            upper[i] = -slope[i + 1]
            diagonal[i] = inertia[0, i] + ratio * slope[i] + slope[i + 1]
            right[i] = inertia[1, i] * v[i] - side[i] * force[i] + ratio * mean[i] - mean[i + 1]
        right[0] -= lower[0] * pulled
        solve_tridiagonal(lower, diagonal, upper, right, d)
        solved, largest = True, 0.0
        for j in range(n + 1):
            if j == 0 and prescribed:
                continue
            gap = (pulled if j == 0 else d[j - 1]) - (d[j] if j < n else 0.0)
            true, _share = mean_tension(tau[j], tau[j] + springs[j] * gap)
            slope[j] = abs(true - mean[j] - slope[j] * gap)
            largest = max(largest, abs(tau[j]), true)
            mean[j] = true
        for j in range(n + 1):
            if not (j == 0 and prescribed) and slope[j] > TOLERANCE * largest:
                solved = False
        for i in range(n):
            if static[0, i] == 0.0 and force[i] == 0.0:
                continue
            if side[i] != 0 and d[i] * side[i] < 0.0:
                side[i], held[i], solved = 0, True, False
            elif side[i] == 0 and not held[i]:
                side[i] = releases(
                    mean[i] - mean[i + 1],
                    static[0, i] * mean[i] + force[i],
                    static[1, i] * mean[i] + force[i],
                )
                solved = solved and side[i] == 0
        if solved:
            return True
    return False


@checked
def march(
    time: FloatArray,
    drive: FloatArray,
    tension_driven: bool,
    substeps: npt.NDArray[np.int64],
    pretension: float,
    springs: FloatArray,
    output_stiffness: float,
    mass: FloatArray,
    damping: FloatArray,
    static: FloatArray,
    dynamic: FloatArray,
    force: FloatArray,
    x: FloatArray,
    v: FloatArray,
    rubbed: FloatArray,
    record: FloatArray,
    positions: FloatArray,
) -> int:
    """March ``x``, ``v`` through ``time``; fill ``record``, ``positions``; count unsolved steps.

    Columns of ``record``: T_in, T_out, ξ_in, ξ_out, elastic, kinetic energy, then the works so far
    of input, friction, damping. ``positions`` with no rows is not filled.
    """
    n, unsolved = x.size, 0
    d, mean, tau = np.zeros(n), np.zeros(n + 1), np.zeros(n + 1)
    work, inertia, side = np.zeros((5, n + 1)), np.zeros((2, n)), np.zeros(n, dtype=np.int64)
    supplied, damped = 0.0, 0.0
    for sample in range(time.size):
        steps, h, rise = 0, 1.0, 0.0  # the first sample is the start
        if sample > 0:
            steps = substeps[sample - 1]
            h = (time[sample] - time[sample - 1]) / steps
            rise = (drive[sample] - drive[sample - 1]) / steps
            inertia[0] = 2.0 * mass / h**2 + damping / h
            inertia[1] = 2.0 * mass / h
        for step in range(steps):
            start = drive[sample - 1] + step * rise
            for j in range(1, n + 1):
                tau[j] = pretension + springs[j] * (x[j - 1] - (x[j] if j < n else 0.0))
            if tension_driven:
                tau[0] = start
                ok = advance(h, 0.0, max(0.0, start + 0.5 * rise), v, tau, springs, inertia,
                             static, dynamic, force, side, d, mean, work)  # fmt: skip
                supplied += mean[0] * (d[0] + rise / springs[0])
            else:
                tau[0] = pretension + springs[0] * (start - x[0])
                ok = advance(h, rise, -1.0, v, tau, springs, inertia,
                             static, dynamic, force, side, d, mean, work)  # fmt: skip
                supplied += mean[0] * rise
            unsolved += 0 if ok else 1
            for i in range(n):
                end = 2.0 * d[i] / h - v[i]
                if static[0, i] > 0.0 or force[i] > 0.0:
                    weight = dynamic[0, i] if side[i] > 0 else dynamic[1, i]
                    rubbed[i] += (weight * mean[i] + force[i]) * abs(d[i])
                    if side[i] == 0 or end * side[i] < 0.0:
                        rubbed[i] += 0.5 * mass[i] * end**2
                        end = 0.0
                damped += damping[i] * d[i] ** 2 / h
                x[i] += d[i]
                v[i] = end
        row = record[sample]
        if tension_driven:
            row[0] = drive[sample]
            row[2] = x[0] + (drive[sample] - pretension) / springs[0]
        else:
            row[0] = max(0.0, pretension + springs[0] * (drive[sample] - x[0]))
            row[2] = drive[sample]
        row[4] = 0.5 * row[0] ** 2 / springs[0]
        row[5] = 0.0
        for i in range(n):
            right = x[i + 1] if i + 1 < n else 0.0
            row[1] = max(0.0, pretension + springs[i + 1] * (x[i] - right))
            row[4] += 0.5 * row[1] ** 2 / springs[i + 1]
            row[5] += 0.5 * mass[i] * v[i] ** 2
        row[3] = (row[1] - pretension) / output_stiffness
        row[6], row[7], row[8] = supplied, rubbed.sum(), damped
        if positions.shape[0] > 0:
            positions[sample] = x
    return unsolved
