"""Backward differences of order 2 with exact sticking, for chains with effects (Numba).

All compiled functions are in this file: Numba's cache does not notice a changed callee in another.

**State.** Nodes are the n elements and behind them the carriages; spring j lies before element
j + 1, spring n behind the last element. Displacements are positive toward the input. Each node,
element and spring is one record of an array, whose named fields Numba compiles to plain memory;
with a structure of many arrays a step took twice as long, for the references that every loop
counts.

**Differences.** A node's velocity and acceleration at the end of a step h are BDF2's, (3d − d⁻)/2h
and the like, or backward Euler's in the first two steps after it broke loose. All forces are those
at the end of the step, so that modes too fast for h are damped out instead of ringing, and friction
without inertia is met exactly: a slow run costs no more steps for light elements. The midpoint rule
of `chain_integrator` conserves energy, which this one does not, and would ring here.

**Stick and slip.** The unknowns of a step are d, the increments of the nodes. A resting element
stays (d = 0) while its two tensions are within the limits, else it slides toward the larger one;
one that would slide backwards is held for the rest of the step. All directions are revised at once
after each linear solve, the springs linearised again, until nothing changes. F_c and c_v act one
half before and one half behind the turn of an element, which makes them those of friction along the
turn to second order in φ_i.

**Springs** are written in newtons: τ = EA × strain. With a = 1/EA, k = EA/ℓ, ℓ the place that a
piece of tendon has and s the unstretched length in it, at first ℓ/(1 + a τ_0), then less by what
left, g:

    τ = EA (ℓ/s − 1) = (τ_0 e + k (g − y))/(e − a k g),   e = 1/(1 + a τ_0),

y the loss of ℓ itself because its output end moved. a = 0 is infinitesimal strain.

Equations: docs/theory.md, section 5.
"""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple

import numba
import numpy as np
import numpy.typing as npt

from experiments.references.checks import History
from tendon_mj.typing import FloatArray

COLUMNS = 5  # of `record`
ATTEMPTS = 100  # to solve a step
TOLERANCE = 1e-8  # of the tensions against their linearisation [N]
NEWTON_STEPS = 30  # for the tension of a spring
TENSION_TOLERANCE = 1e-11  # of 1 N + tension
RecordArray = npt.NDArray[np.void]

NODE: Final = np.dtype(
    [
        ("mass", np.float64),  # [kg]
        ("damping", np.float64),  # against the ground [N s/m]
        ("displacement", np.float64),  # [m]
        ("increment", np.float64),  # d, displacement within the last step [m]
        ("velocity", np.float64),  # at the end of the last step [m/s]
        ("previous_velocity", np.float64),  # at its beginning [m/s]
        ("smooth_steps", np.int64),  # since the element last stopped, started or turned
        ("inertia", np.float64),  # inertia force per d [N/m]
        ("inertia_offset", np.float64),  # inertia force at d = 0 [N]
        ("rate", np.float64),  # velocity per d [1/s]
        ("rate_offset", np.float64),  # velocity at d = 0 [m/s]
        ("lower", np.float64),  # of the tridiagonal system for d [N/m]
        ("diagonal", np.float64),
        ("upper", np.float64),
        ("load", np.float64),  # its right side [N]
    ]
)
ELEMENT: Final = np.dtype(
    [
        ("angle", np.float64),  # φ_i [rad]
        ("static", np.float64),  # μ_s [–]
        ("dynamic", np.float64),  # μ_d [–]
        ("constant", np.float64),  # F_c/n [N]
        ("static_to_input", np.float64),  # T_high/T_low up to which it rests [–]
        ("static_to_output", np.float64),
        ("sliding_to_input", np.float64),  # T_high/T_low while it slides [–]
        ("sliding_to_output", np.float64),
        ("frictionless", np.bool_),  # rubs in neither direction
        ("direction", np.int64),  # of sliding, +1 toward the input, 0 at rest
        ("previous_direction", np.int64),  # a step before
        ("held", np.bool_),  # was stopped in this step
        ("sliding_speed", np.float64),  # w [m/s]
    ]
)
SPRING: Final = np.dtype(
    [
        ("stiffness", np.float64),  # k [N/m]
        ("tension", np.float64),  # [N]
        ("previous_tension", np.float64),  # a step before [N]
        ("creep_strain", np.float64),  # EA ε_c [N]
        ("next_creep_strain", np.float64),  # predicted for the end of the step [N]
        ("input_slope", np.float64),  # derivative of the tension in the node before it [N/m]
        ("output_slope", np.float64),  # minus that in the node behind it [N/m]
        ("linear_tension", np.float64),  # were it linear within the step [N]
    ]
)
CARRIAGE: Final = np.dtype(
    [
        ("stiffness", np.float64),  # of the spring behind it [N/m]
        ("damping", np.float64),  # beside that spring [N s/m]
    ]
)


class Material(NamedTuple):
    """Law of the tendon, T = EA ε_e (1 + κ ε_e) + EA τ_r dε/dt with ε = ε_e + ε_c.

    Attributes:
        pretension: T_0 [N].
        compliance: 1/EA, strain per newton [1/N]; 0 is infinitesimal strain.
        initial_strain: EA ε under T_0, elastic and delayed [N].
        stiffening: κ [–].
        creep: χ [–].
        creep_time: τ_c [s].
        retardation_time: τ_r [s].
    """

    pretension: float
    compliance: float
    initial_strain: float
    stiffening: float
    creep: float
    creep_time: float
    retardation_time: float


class Friction(NamedTuple):
    """Friction parameters that all elements share.

    Attributes:
        viscous: c_v/n [N s/m].
        asymmetry: α [–].
        gradient: γ [1/m].
        drift: β [1/s].
        stribeck_friction: Δμ [–].
        stribeck_velocity: v_s [m/s].
        memory: of the sliding speed [s].
    """

    viscous: float
    asymmetry: float
    gradient: float
    drift: float
    stribeck_friction: float
    stribeck_velocity: float
    memory: float


class EffectChain(NamedTuple):
    """Chain of elements with effects, and the carriages behind it, in the state it has reached.

    Attributes:
        material: law of the tendon.
        friction: of the elements.
        preload: tension that the carriages' springs balance at the start [N].
        mount_compliance: C_s, of the sheath's mount at the input [m/N].
        output_compliance: of a massless output, if there is no carriage [m/N].
        backlash: b [m].
        nodes: of type ``NODE``. Shape (n + carriages,).
        elements: of type ``ELEMENT``. Shape (n,).
        springs: of type ``SPRING``. Shape (n + 1,).
        carriages: of type ``CARRIAGE``. Shape (carriages,).
    """

    material: Material
    friction: Friction
    preload: float
    mount_compliance: float
    output_compliance: float
    backlash: float
    nodes: RecordArray
    elements: RecordArray
    springs: RecordArray
    carriages: RecordArray


@numba.njit(cache=True)
def set_ratios(
    friction: Friction, aged: float, displacement: float, speed: float, element: Any
) -> None:
    """Set T_high/T_low of an element that has passed ``displacement`` [m] of tendon.

    ``aged`` is max(0, 1 + β t) [–], ``speed`` the sliding speed w [m/s]; ``element`` is a record.
    """
    scale = aged * max(0.0, 1.0 + friction.gradient * displacement)
    extra = 0.0
    if friction.stribeck_friction > 0.0:
        extra = friction.stribeck_friction * math.exp(-speed / friction.stribeck_velocity)
    to_input, to_output = scale * (1.0 + friction.asymmetry), scale * (1.0 - friction.asymmetry)
    static, dynamic, angle = element.static, element.dynamic, element.angle
    element.sliding_to_input = math.exp((dynamic * to_input + extra) * angle)
    element.sliding_to_output = math.exp((dynamic * to_output + extra) * angle)
    element.static_to_input = element.sliding_to_input
    element.static_to_output = element.sliding_to_output
    if static > dynamic:
        element.static_to_input = math.exp((static * to_input + extra) * angle)
        element.static_to_output = math.exp((static * to_output + extra) * angle)
    element.frictionless = (
        element.static_to_input == 1.0
        and element.static_to_output == 1.0
        and element.constant == 0.0
    )


@numba.njit(cache=True)
def set_initial_ratios(chain: EffectChain) -> None:
    """Set the ratios of all elements at time 0 and at rest."""
    for i in range(chain.elements.size):
        set_ratios(chain.friction, 1.0, 0.0, 0.0, chain.elements[i])


@numba.njit(cache=True)
def predict_ratios(chain: EffectChain, time: float, h: float) -> None:
    """Set the ratios for ``time`` [s], as if the step h [s] repeated the increments before it."""
    friction = chain.friction
    aged = max(0.0, 1.0 + friction.drift * time)
    fade = -math.expm1(-h / friction.memory)
    for i in range(chain.elements.size):
        node, element = chain.nodes[i], chain.elements[i]
        speed = element.sliding_speed
        speed += (abs(node.increment) / h - speed) * fade
        set_ratios(friction, aged, node.displacement + node.increment, speed, element)


@numba.njit(cache=True)
def spring_tension(
    material: Material,
    k: float,
    creep_strain: float,
    gain: float,
    shift: float,
    mount_compliance: float,
    output_compliance: float,
    guess: float,
) -> tuple[float, float, float]:
    """Return the tension of a spring [N] and its derivatives in ``gain`` and −``shift`` [N/m].

    ``gain`` is what it has lost of unstretched length on the input side less what it got on the
    output side; ``shift`` is y. ``mount_compliance`` [m/N] is that of the mount, which takes some
    of ``gain``, ``output_compliance`` [m/N] that of a massless output, which adds to ``shift``.
    ``creep_strain`` is EA ε_c [N]. Newton from ``guess``.
    """
    a, start, stiffening = material.compliance, material.initial_strain, material.stiffening
    e = 1.0 / (1.0 + a * start)
    tension = guess
    gain_slope, shift_slope = 0.0, 0.0
    for _ in range(NEWTON_STEPS):
        excess = tension - material.pretension
        g = gain - mount_compliance * excess
        bottom = e - a * k * g
        top = start * e + k * (g - shift - output_compliance * excess)
        elastic = top / bottom - creep_strain
        if elastic <= 0.0:  # slack: the compliances alone set the length
            if tension <= 0.0:
                return 0.0, 0.0, 0.0
            tension = 0.0
            continue
        tangent = 1.0 + 2.0 * stiffening * a * elastic
        shift_slope = tangent * k / bottom
        gain_slope = shift_slope + tangent * a * k * top / bottom**2
        total = 1.0 + mount_compliance * gain_slope + output_compliance * shift_slope
        change = (elastic * (1.0 + stiffening * a * elastic) - tension) / total
        tension += change
        gain_slope, shift_slope = gain_slope / total, shift_slope / total
        if abs(change) <= TENSION_TOLERANCE * (1.0 + tension):
            break
    return max(tension, 0.0), gain_slope, shift_slope


@numba.njit(cache=True)
def linearise_springs(chain: EffectChain, drum: float) -> None:
    """Set the tensions of all springs at the end of a step, and their derivatives [N/m].

    ``drum`` is the displacement of the drum [m]. Retardation acts on the tendon that elements pass;
    mount, drum and output move too slowly to matter.
    """
    material, nodes, springs = chain.material, chain.nodes, chain.springs
    n, free = chain.elements.size, chain.carriages.size == 0
    gain = drum
    for j in range(n + 1):
        spring, shift = springs[j], 0.0
        if j > 0:
            gain = nodes[j - 1].displacement + nodes[j - 1].increment
        if j < n:
            gain -= nodes[j].displacement + nodes[j].increment
        elif not free:
            shift = nodes[n].displacement + nodes[n].increment
        spring.tension, spring.input_slope, spring.output_slope = spring_tension(
            material,
            spring.stiffness,
            spring.next_creep_strain,
            gain,
            shift,
            chain.mount_compliance if j == 0 else 0.0,
            chain.output_compliance if j == n and free else 0.0,
            spring.tension,
        )
        if j < n:
            spring.output_slope = spring.input_slope
        if material.retardation_time > 0.0 and 0 < j < n:
            before, behind = nodes[j - 1], nodes[j]
            slow = material.retardation_time * spring.stiffness
            spring.tension += slow * (before.rate * before.increment + before.rate_offset)
            spring.tension -= slow * (behind.rate * behind.increment + behind.rate_offset)
            spring.input_slope += slow * before.rate
            spring.output_slope += slow * behind.rate


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
def solve_tridiagonal(
    lower: FloatArray, diagonal: FloatArray, upper: FloatArray, right: FloatArray, d: FloatArray
) -> None:
    """Solve the tridiagonal system into ``d`` (Thomas); ``upper`` and ``right`` are overwritten.

    As in `chain_integrator`, whose copy Numba's cache of this file would not follow.
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
    """Stop elements that would slide backwards, release those beyond their limit; return if any."""
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


@numba.njit(cache=True)
def march_effects(chain: EffectChain, history: History, record: FloatArray) -> int:
    """March ``chain`` through ``history``; fill ``record``; return the number of unsolved steps.

    Columns of ``record``: T_in [N], T_out [N], displacement of the drum [m], ξ_out [m], work of the
    input so far [J].
    """
    friction, time, value = chain.friction, history.time, history.value
    unsolved, supplied, drum, h_before = 0, 0.0, 0.0, 0.0
    unstretched = 1.0 / (1.0 + chain.material.compliance * chain.material.initial_strain)
    varies = friction.gradient != 0.0 or friction.drift != 0.0 or friction.stribeck_friction > 0.0
    set_initial_ratios(chain)
    for sample in range(time.size):
        steps = 0 if sample == 0 else history.steps[sample - 1]
        h = 1.0 if sample == 0 else (time[sample] - time[sample - 1]) / steps
        for k in range(steps):
            share = (k + 1.0) / steps
            drive = value[sample - 1] + share * (value[sample] - value[sample - 1])
            drum_before = drum
            drum = min(max(drum, drive - 0.5 * chain.backlash), drive + 0.5 * chain.backlash)
            if varies:
                now = max(0.0, time[sample - 1] + share * (time[sample] - time[sample - 1]))
                predict_ratios(chain, now, h)
            predict_creep(chain, h)
            set_differences(chain, h, abs(h - h_before) <= 1e-6 * h)
            unsolved += 0 if solve_step(chain, unstretched * drum) else 1
            first = chain.springs[0]
            supplied += 0.5 * (first.previous_tension + first.tension) * (drum - drum_before)
            end_step(chain, h)
            h_before = h
        row = record[sample]
        row[0], row[1] = chain.springs[0].tension, chain.springs[chain.elements.size].tension
        row[2], row[4] = drum, supplied
        if chain.carriages.size > 0:
            row[3] = chain.nodes[chain.elements.size].displacement
        else:
            row[3] = chain.output_compliance * (row[1] - chain.material.pretension)
    return unsolved


@numba.njit(cache=True)
def predict_creep(chain: EffectChain, h: float) -> None:
    """Keep the tensions, and extrapolate them for the creep strain at the end of a step h [s]."""
    creep = chain.material.creep
    share = -math.expm1(-h / chain.material.creep_time) if creep > 0.0 else 0.0
    for j in range(chain.springs.size):
        spring = chain.springs[j]
        if creep > 0.0:
            guess = 2.0 * spring.tension - spring.previous_tension
            mean = 0.5 * (spring.tension + guess)
            change = (creep * mean - spring.creep_strain) * share
            spring.next_creep_strain = spring.creep_strain + change
        spring.previous_tension = spring.tension


@numba.njit(cache=True)
def set_differences(chain: EffectChain, h: float, even: bool) -> None:
    """Set velocity and inertia force as functions of the increment of a step h [s].

    BDF2 where the node has moved on smoothly for two steps and these were as long (``even``).
    """
    for i in range(chain.nodes.size):
        node = chain.nodes[i]
        if node.smooth_steps >= 2 and even:
            node.rate, node.rate_offset = 1.5 / h, -0.5 * node.increment / h
            node.inertia = node.mass * 1.5 / h * node.rate
            rise = 1.5 * node.rate_offset - 2.0 * node.velocity + 0.5 * node.previous_velocity
            node.inertia_offset = node.mass / h * rise
        else:
            node.rate, node.rate_offset = 1.0 / h, 0.0
            node.inertia = node.mass / h**2
            node.inertia_offset = -node.mass * node.velocity / h


@numba.njit(cache=True)
def end_step(chain: EffectChain, h: float) -> None:
    """Carry displacement, velocity, direction, sliding speed and creep over a step h [s]."""
    fade = -math.expm1(-h / chain.friction.memory)
    for i in range(chain.nodes.size):
        node = chain.nodes[i]
        node.previous_velocity = node.velocity
        node.velocity = node.rate * node.increment + node.rate_offset
        node.displacement += node.increment
        node.smooth_steps += 1
        if i < chain.elements.size:
            element = chain.elements[i]
            if node.increment == 0.0:
                element.direction, node.velocity = 0, 0.0
            if element.direction != element.previous_direction:
                node.smooth_steps = 0
            element.previous_direction = element.direction
            element.sliding_speed += (abs(node.increment) / h - element.sliding_speed) * fade
    creep = chain.material.creep
    if creep > 0.0:
        share = -math.expm1(-h / chain.material.creep_time)
        for j in range(chain.springs.size):
            spring = chain.springs[j]
            mean = 0.5 * (spring.tension + spring.previous_tension)
            spring.creep_strain += (creep * mean - spring.creep_strain) * share
