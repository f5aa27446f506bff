"""Energy-conserving implicit midpoint rule with exact sticking (Numba).

**Smooth part, order 2.** Over a step h the displacement d_i = ξ_i⁺ − ξ_i solves

    2 m_i (d_i/h − v_i)/h + c_i d_i/h = a_i T̄_i − T̄_{i+1} − s_i f_i,    v_i⁺ = 2 d_i/h − v_i,

T̄ the mean tension of each spring over the step (`stick.mean_tension`) and a_i from the direction
s_i of sliding. Taut springs make it the implicit midpoint rule; in all cases T̄ × elongation is the
change of elastic energy, so that input work = Δ elastic + Δ kinetic + friction + damping holds to
rounding (and to `midpoint_step.TOLERANCE` where springs turn slack).

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

import numba

from experiments.references.element_system import ElementSystem
from experiments.references.history import History
from experiments.references.midpoint_step import solve_step
from tendon_mj.typing import FloatArray

COLUMNS = 9  # of `record`


@numba.njit(cache=True)
def march(
    system: ElementSystem, history: History, record: FloatArray, positions: FloatArray
) -> int:
    """March ``system`` through ``history``; fill ``record``, ``positions``; count unsolved steps.

    Columns of ``record``: T_in, T_out, ξ_in, ξ_out, elastic, kinetic energy, then the works so far
    of input, friction, damping. ``positions`` with no rows is not filled.
    """
    elements, springs = system.elements, system.springs
    time, value, unsolved = history.time, history.value, 0
    supplied, damped = 0.0, 0.0
    for sample in range(time.size):
        steps, h, rise = 0, 1.0, 0.0  # the first sample is the start
        if sample > 0:
            steps = history.steps[sample - 1]
            h = (time[sample] - time[sample - 1]) / steps
            rise = (value[sample] - value[sample - 1]) / steps
            for i in range(elements.size):
                element = elements[i]
                element.inertia = 2.0 * element.mass / h**2 + element.damping / h
                element.momentum = 2.0 * element.mass / h
        for step in range(steps):
            start = value[sample - 1] + step * rise
            set_tensions(system, start)
            if system.tension_driven:
                ok = solve_step(system, h, 0.0, max(0.0, start + 0.5 * rise))
                supplied += springs[0].mean * (elements[0].increment + rise / springs[0].stiffness)
            else:
                ok = solve_step(system, h, rise, -1.0)
                supplied += springs[0].mean * rise
            unsolved += 0 if ok else 1
            damped = end_step(system, h, damped)
        fill_row(system, value[sample], supplied, damped, record[sample])
        if positions.shape[0] > 0:
            for i in range(elements.size):
                positions[sample, i] = elements[i].displacement
    return unsolved


@numba.njit(cache=True)
def set_tensions(system: ElementSystem, drive: float) -> None:
    """Set the tensions at the start of a step [N]; ``drive`` is T_in [N] or ξ_in [m]."""
    elements, springs = system.elements, system.springs
    first = springs[0]
    if system.tension_driven:
        first.tension = drive
    else:
        first.tension = system.pretension + first.stiffness * (drive - elements[0].displacement)
    for j in range(1, springs.size):
        behind = elements[j].displacement if j < elements.size else 0.0
        elongation = elements[j - 1].displacement - behind
        springs[j].tension = system.pretension + springs[j].stiffness * elongation


@numba.njit(cache=True)
def end_step(system: ElementSystem, h: float, damped: float) -> float:
    """Carry displacement, velocity and friction work over a step h [s].

    Returns the work of damping so far [J], ``damped`` before the step.
    """
    for i in range(system.elements.size):
        element = system.elements[i]
        d, side = element.increment, element.direction
        end = 2.0 * d / h - element.velocity
        if element.rubs:
            weight = element.dynamic_pulled if side > 0 else element.dynamic_loosened
            element.friction_work += (weight * system.springs[i].mean + element.force) * abs(d)
            if side == 0 or end * side < 0.0:
                element.friction_work += 0.5 * element.mass * end**2
                end = 0.0
        damped += element.damping * d**2 / h
        element.displacement += d
        element.velocity = end
    return damped


@numba.njit(cache=True)
def fill_row(
    system: ElementSystem, drive: float, supplied: float, damped: float, row: FloatArray
) -> None:
    """Fill a row of the record; ``drive`` is T_in [N] or ξ_in [m]."""
    elements, springs, pretension = system.elements, system.springs, system.pretension
    first, place = springs[0], elements[0].displacement
    if system.tension_driven:
        row[0] = drive
        row[2] = place + (drive - pretension) / first.stiffness
    else:
        row[0] = max(0.0, pretension + first.stiffness * (drive - place))
        row[2] = drive
    row[4] = 0.5 * row[0] ** 2 / first.stiffness
    row[5], rubbed = 0.0, 0.0
    for i in range(elements.size):
        element, spring = elements[i], springs[i + 1]
        behind = elements[i + 1].displacement if i + 1 < elements.size else 0.0
        row[1] = max(0.0, pretension + spring.stiffness * (element.displacement - behind))
        row[4] += 0.5 * row[1] ** 2 / spring.stiffness
        row[5] += 0.5 * element.mass * element.velocity**2
        rubbed += element.friction_work
    row[3] = (row[1] - pretension) / system.output_stiffness
    row[6], row[7], row[8] = supplied, rubbed, damped
