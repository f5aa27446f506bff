"""One implicit step of a chain with effects: stick and slip as unknowns of the step (Numba).

The unknowns of a step h are d, the increments of the nodes. All forces are those at the end of the
step. A resting element stays (d = 0) while its two tensions are within the limits, else it slides
toward the larger one; one that would slide backwards is held for the rest of the step. All
directions are revised at once after each linear solve, the springs linearised anew, until nothing
changes.

F_c and c_v act one half before and one half behind the turn of an element, which makes them those
of friction along the turn to second order in φ_i.

Equations: docs/theory.md, section 5.
"""

from __future__ import annotations

import numba

from experiments.references.effect_spring import linearise_springs
from experiments.references.effect_system import EffectChain, RecordArray
from experiments.references.stick import solve_tridiagonal

ATTEMPTS = 100
TOLERANCE = 1e-8  # of the tensions against their linearisation [N]


@numba.njit(cache=True)
def solve_step(chain: EffectChain, drum: float) -> bool:
    """Find direction, increment and tension of one step; return whether it was solved.

    ``drum`` is the displacement of the drum at the end of the step [m].
    """
    for i in range(chain.elements.size):
        chain.elements[i].held = False
    linearise_springs(chain, drum)
    for _ in range(ATTEMPTS):
        set_element_rows(chain)
        set_carriage_rows(chain)
        chain.nodes[0].lower = 0.0
        solve_increments(chain.nodes, chain.springs)
        linearise_springs(chain, drum)
        solved = True
        for j in range(chain.springs.size):
            spring = chain.springs[j]
            solved = solved and abs(spring.tension - spring.linear_tension) <= TOLERANCE
        if not revise_directions(chain) and solved:
            return True
    return False


@numba.njit(cache=True)
def set_element_rows(chain: EffectChain) -> None:
    """Set the rows of the elements: balance of forces, or d = 0 at rest."""
    nodes, elements, springs = chain.nodes, chain.elements, chain.springs
    for i in range(elements.size):
        node, element, before, behind = nodes[i], elements[i], springs[i], springs[i + 1]
        side = element.direction
        if side == 0 and not element.frictionless:
            node.lower, node.diagonal, node.upper, node.load = 0.0, 1.0, 0.0, 0.0
            continue
        low = element.sliding_to_input if side >= 0 else 1.0  # weight of the output side
        high = element.sliding_to_output if side < 0 else 1.0
        mean = 0.5 * (low + high)
        damping = node.damping + mean * chain.friction.viscous
        node.lower = -high * before.input_slope
        node.upper = -low * behind.output_slope
        node.diagonal = (
            node.inertia
            + damping * node.rate
            + high * before.output_slope
            + low * behind.input_slope
        )
        load = (
            high * before.tension
            - low * behind.tension
            - side * mean * element.constant
            - node.inertia_offset
            - damping * node.rate_offset
            + high * before.output_slope * node.increment
            + low * behind.input_slope * node.increment
        )
        if i > 0:
            load -= high * before.input_slope * nodes[i - 1].increment
        if i + 1 < nodes.size:
            load -= low * behind.output_slope * nodes[i + 1].increment
        node.load = load


@numba.njit(cache=True)
def set_carriage_rows(chain: EffectChain) -> None:
    """Set the rows of the carriages: balance of forces, each on a spring and a damper."""
    nodes, carriages = chain.nodes, chain.carriages
    n, last = chain.elements.size, chain.springs[chain.elements.size]
    for e in range(carriages.size):
        i = n + e
        node, behind = nodes[i], carriages[e]
        beyond, drift = 0.0, node.rate_offset
        node.upper = 0.0
        if e + 1 < carriages.size:
            beyond = nodes[i + 1].displacement
            drift -= nodes[i + 1].rate_offset
            node.upper = -behind.stiffness - behind.damping * nodes[i + 1].rate
        node.diagonal = node.inertia + (behind.stiffness + behind.damping * node.rate)
        node.load = (
            -node.inertia_offset
            - behind.stiffness * (node.displacement - beyond)
            - behind.damping * drift
        )
        previous = nodes[i - 1]
        if e == 0:
            node.diagonal += last.output_slope
            node.lower = -last.input_slope
            node.load += (
                last.tension
                - chain.preload
                + last.output_slope * node.increment
                - last.input_slope * previous.increment
            )
        else:
            before = carriages[e - 1]
            node.diagonal += before.stiffness + before.damping * node.rate
            node.lower = -before.stiffness - before.damping * previous.rate
            node.load += before.stiffness * (previous.displacement - node.displacement)
            node.load += before.damping * (previous.rate_offset - node.rate_offset)


@numba.njit(cache=True)
def solve_increments(nodes: RecordArray, springs: RecordArray) -> None:
    """Solve for the increments, and set the tensions that linear springs would have at them."""
    for j in range(springs.size):
        spring = springs[j]
        linear = spring.tension
        linear -= spring.input_slope * nodes[j - 1].increment if j > 0 else 0.0
        linear += spring.output_slope * nodes[j].increment if j < nodes.size else 0.0
        spring.linear_tension = linear
    solve_tridiagonal(
        nodes["lower"], nodes["diagonal"], nodes["upper"], nodes["load"], nodes["increment"]
    )
    for j in range(springs.size):
        spring = springs[j]
        linear = spring.linear_tension
        linear += spring.input_slope * nodes[j - 1].increment if j > 0 else 0.0
        linear -= spring.output_slope * nodes[j].increment if j < nodes.size else 0.0
        spring.linear_tension = linear


@numba.njit(cache=True)
def revise_directions(chain: EffectChain) -> bool:
    """Stop what would slide backwards, release what exceeds its limit; return whether any was."""
    changed = False
    for i in range(chain.elements.size):
        element = chain.elements[i]
        if element.frictionless:
            continue
        if element.direction != 0:
            if chain.nodes[i].increment * element.direction < 0.0:
                element.direction, element.held, changed = 0, True, True
        elif not element.held:
            before, behind = chain.springs[i].tension, chain.springs[i + 1].tension
            half = 0.5 * element.constant
            if before - half > element.static_to_input * (behind + half):
                element.direction, changed = 1, True
            elif behind - half > element.static_to_output * (before + half):
                element.direction, changed = -1, True
    return changed
