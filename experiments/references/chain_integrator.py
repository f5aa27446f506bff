"""Energy-conserving implicit midpoint rule with exact sticking, for a chain of elements (Numba).

All compiled functions are in this file: Numba's cache does not notice a changed callee in another.

**State.** Spring j lies before element j + 1, the last one behind the last element. Displacements
are positive toward the input. Each element and each spring is one record of an array, whose named
fields Numba compiles to plain memory.

**Smooth part, order 2.** Over a step h the displacement d_i = ξ_i⁺ − ξ_i solves

    2 m_i (d_i/h − v_i)/h + c_i d_i/h = a_i T̄_i − T̄_{i+1} − s_i f_i,    v_i⁺ = 2 d_i/h − v_i,

T̄ the mean tension of each spring over the step (`mean_tension`) and a_i from the direction s_i of
sliding. Taut springs make it the implicit midpoint rule; in all cases T̄ × elongation is the change
of elastic energy, so that input work = Δ elastic + Δ kinetic + friction + damping holds to rounding
(and to `TOLERANCE` where springs turn slack).

**Stick events, a projection as in Moreau's time stepping.** Directions are part of the step's
unknowns. A resting element has d_i = 0 and v_i⁺ = 0 exactly while its mean net force is within the
static limit, else it slides, at μ_d. A sliding element that the step would carry backwards is held
(d_i = 0, v_i⁺ = 0) and treated as a resting one in the next step; one that only ends the step with
reversed velocity ends it at rest. Its kinetic energy, O(h²), goes to the friction work, which is
therefore never negative. Each element changes its direction at most twice in a step: the iteration
ends.

An element stops within O(h²) of its place and, with μ_s = μ_d, breaks away with a force that grows
from 0: order 2 is kept. With μ_s > μ_d the force jumps, and the breakaway is off by up to h: order
1. There, whether a slip carries a neighbour along depends on rounding: single slips differ between
steps h (T_out by some newtons at 64 light elements, the friction work by a few per cent).

Equations: docs/theory.md, section 5.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numba
import numpy as np
import numpy.typing as npt

from experiments.references.checks import History
from experiments.references.elements import ElementChain
from tendon_mj.typing import FloatArray

COLUMNS = 9  # of `record`
TOLERANCE = 1e-13  # of the largest tension, for the mean tension of springs that turn slack
RecordArray = npt.NDArray[np.void]

ELEMENT: Final = np.dtype(
    [
        ("mass", np.float64),  # m_i [kg]
        ("damping", np.float64),  # c_i [N s/m]
        ("static_pulled", np.float64),  # friction per unit of T_i up to which it rests [–]
        ("static_loosened", np.float64),
        ("dynamic_pulled", np.float64),  # friction per unit of T_i while it slides [–]
        ("dynamic_loosened", np.float64),
        ("force", np.float64),  # f_i [N]
        ("rubs", np.bool_),  # has friction of either kind
        ("displacement", np.float64),  # ξ_i [m]
        ("velocity", np.float64),  # ξ̇_i [m/s]
        ("friction_work", np.float64),  # so far [J]
        ("increment", np.float64),  # d_i, displacement within the step [m]
        ("direction", np.int64),  # of sliding, +1 toward the input, 0 at rest
        ("held", np.bool_),  # was stopped in this step
        ("inertia", np.float64),  # force of inertia and damping per d_i [N/m]
        ("momentum", np.float64),  # force of inertia per −v_i [kg/s]
        ("lower", np.float64),  # of the tridiagonal system for d [N/m]
        ("diagonal", np.float64),
        ("upper", np.float64),
        ("load", np.float64),  # its right side [N]
    ]
)
SPRING: Final = np.dtype(
    [
        ("stiffness", np.float64),  # k_j [N/m]
        ("tension", np.float64),  # at the start of the step, below 0 if slack [N]
        ("mean", np.float64),  # T̄_j over the step [N]
        ("slope", np.float64),  # its derivative in the elongation [N/m]
    ]
)


class ElementSystem(NamedTuple):
    """Chain of elements in the state it has reached.

    Attributes:
        pretension: T_0 [N].
        output_stiffness: k_se [N/m].
        tension_driven: whether T_in is prescribed, else ξ_in.
        elements: of type ``ELEMENT``. Shape (n,).
        springs: of type ``SPRING``. Shape (n + 1,).
    """

    pretension: float
    output_stiffness: float
    tension_driven: bool
    elements: RecordArray
    springs: RecordArray


def element_system(
    chain: ElementChain, displacement: FloatArray, velocity: FloatArray, tension_driven: bool
) -> ElementSystem:
    """Return a chain whose elements are at ``displacement`` [m] with ``velocity`` [m/s]."""
    elements = np.zeros(chain.n, dtype=ELEMENT)
    static = chain.friction_weights(chain.static_friction)
    dynamic = chain.friction_weights(chain.dynamic_friction)
    for name, values in {
        "mass": chain.mass,
        "damping": chain.damping,
        "static_pulled": static[0],
        "static_loosened": static[1],
        "dynamic_pulled": dynamic[0],
        "dynamic_loosened": dynamic[1],
        "force": chain.friction_force,
        "rubs": (static[0] > 0.0) | (chain.friction_force > 0.0),
        "displacement": displacement,
        "velocity": velocity,
    }.items():
        elements[name] = values
    springs = np.zeros(chain.n + 1, dtype=SPRING)
    springs["stiffness"] = chain.spring_stiffness
    return ElementSystem(
        pretension=float(chain.pretension),
        output_stiffness=float(chain.output_stiffness),
        tension_driven=tension_driven,
        elements=elements,
        springs=springs,
    )


@numba.njit(cache=True)
def mean_tension(before: float, after: float) -> tuple[float, float]:
    """Mean of max(0, τ) from ``before`` to ``after`` [N], and its derivative in ``after`` [–].

    τ moves evenly; below 0 is slack. The discrete gradient of the spring's energy: mean tension ×
    change of length is the change of T²/2k exactly, slack or taut.
    """
    if before >= 0.0 and after >= 0.0:
        return 0.5 * (before + after), 0.5
    if before <= 0.0 and after <= 0.0:
        return 0.0, 0.0
    taut = max(before, after) / abs(after - before)  # share of the step in which it is taut
    if after > 0.0:
        return 0.5 * after * taut, 0.5 * taut * (2.0 - taut)
    return 0.5 * before * taut, 0.5 * taut * taut


@numba.njit(cache=True)
def releases(net: float, limit_pull: float, limit_loosen: float) -> int:
    """Direction in which a resting element breaks away (+1, −1), or 0 while it stays; eq. (1)."""
    if net > limit_pull:
        return 1
    if net < -limit_loosen:
        return -1
    return 0


@numba.njit(cache=True)
def solve_tridiagonal(
    lower: FloatArray, diagonal: FloatArray, upper: FloatArray, right: FloatArray, d: FloatArray
) -> None:
    """Solve the tridiagonal system into ``d`` (Thomas); ``upper`` and ``right`` are overwritten.

    The rows here are diagonally dominant by the mass, so that no pivoting is needed; a row
    "1 · d_i = 0" gives 0 exactly.
    """
    n = diagonal.size
    upper[0] /= diagonal[0]
    right[0] /= diagonal[0]
    for i in range(1, n):
        pivot = diagonal[i] - lower[i] * upper[i - 1]
        upper[i] /= pivot
        right[i] = (right[i] - lower[i] * right[i - 1]) / pivot
    d[n - 1] = right[n - 1]
    for i in range(n - 2, -1, -1):
        d[i] = right[i] - upper[i] * d[i + 1]


@numba.njit(cache=True)
def solve_step(system: ElementSystem, h: float, pulled: float, input_mean: float) -> bool:
    """Find direction and increment of each element and the mean tensions; return if solved.

    ``pulled`` is the change of ξ_in [m], or the input is the tension ``input_mean`` [N] if that is
    ≥ 0.
    """
    elements = system.elements
    for i in range(elements.size):
        element = elements[i]
        v = element.velocity
        element.direction = 0 if v == 0.0 else (1 if v > 0.0 else -1)
        element.increment = h * v
        element.held = False
    for _ in range(4 * elements.size + 50):
        linearise_springs(system, pulled, input_mean)
        set_rows(system)
        elements[0].load -= elements[0].lower * pulled
        solve_tridiagonal(
            elements["lower"],
            elements["diagonal"],
            elements["upper"],
            elements["load"],
            elements["increment"],
        )
        solved = linear_enough(system, pulled, input_mean)
        if not revise_directions(system) and solved:
            return True
    return False


@numba.njit(cache=True)
def elongation(system: ElementSystem, j: int, pulled: float) -> float:
    """Change of length of spring ``j`` in the step [m]."""
    elements = system.elements
    before = pulled if j == 0 else elements[j - 1].increment
    return float(before - (elements[j].increment if j < elements.size else 0.0))


@numba.njit(cache=True)
def linearise_springs(system: ElementSystem, pulled: float, input_mean: float) -> None:
    """Set T̄_j = mean_j + slope_j × elongation for every spring."""
    for j in range(system.springs.size):
        spring = system.springs[j]
        if j == 0 and input_mean >= 0.0:
            spring.mean, spring.slope = input_mean, 0.0
            continue
        change = elongation(system, j, pulled)
        mean, share = mean_tension(spring.tension, spring.tension + spring.stiffness * change)
        spring.slope = share * spring.stiffness
        spring.mean = mean - spring.slope * change


@numba.njit(cache=True)
def set_rows(system: ElementSystem) -> None:
    """Set the row of each element: balance of forces, or d = 0 at rest."""
    for i in range(system.elements.size):
        element, before, behind = system.elements[i], system.springs[i], system.springs[i + 1]
        side = element.direction
        if element.rubs and side == 0:
            element.lower, element.diagonal, element.upper, element.load = 0.0, 1.0, 0.0, 0.0
            continue
        ratio = 1.0
        if side > 0:
            ratio = 1.0 - element.dynamic_pulled
        elif side < 0:
            ratio = 1.0 + element.dynamic_loosened
        element.lower = -ratio * before.slope
        element.upper = -behind.slope
        element.diagonal = element.inertia + ratio * before.slope + behind.slope
        element.load = (
            element.momentum * element.velocity
            - side * element.force
            + ratio * before.mean
            - behind.mean
        )


@numba.njit(cache=True)
def linear_enough(system: ElementSystem, pulled: float, input_mean: float) -> bool:
    """Set the mean tensions at the increments; return whether they are the linearised ones."""
    springs = system.springs
    start = 1 if input_mean >= 0.0 else 0
    largest, solved = 0.0, True
    for j in range(start, springs.size):
        spring = springs[j]
        change = elongation(system, j, pulled)
        true, _ = mean_tension(spring.tension, spring.tension + spring.stiffness * change)
        spring.slope = abs(true - spring.mean - spring.slope * change)  # the error, from here on
        largest = max(largest, abs(spring.tension), true)
        spring.mean = true
    for j in range(start, springs.size):
        solved = solved and springs[j].slope <= TOLERANCE * largest
    return solved


@numba.njit(cache=True)
def revise_directions(system: ElementSystem) -> bool:
    """Stop elements that would slide backwards, release those beyond their limit; return if any."""
    changed = False
    for i in range(system.elements.size):
        element = system.elements[i]
        if not element.rubs:
            continue
        if element.direction != 0 and element.increment * element.direction < 0.0:
            element.direction, element.held, changed = 0, True, True
        elif element.direction == 0 and not element.held:
            before, behind = system.springs[i].mean, system.springs[i + 1].mean
            element.direction = releases(
                before - behind,
                element.static_pulled * before + element.force,
                element.static_loosened * before + element.force,
            )
            changed = changed or element.direction != 0
    return changed


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
