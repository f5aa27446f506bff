"""One step of the energy-conserving implicit midpoint rule: stick and slip as unknowns (Numba).

Equations: `experiments.references.integrator`; docs/theory.md, section 5.
"""

from __future__ import annotations

import numba

from experiments.references.element_system import ElementSystem
from experiments.references.stick import mean_tension, releases, solve_tridiagonal

TOLERANCE = 1e-13  # of the largest tension, for the mean tension of springs that turn slack


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
    """Stop what would slide backwards, release what exceeds its limit; return whether any was."""
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
