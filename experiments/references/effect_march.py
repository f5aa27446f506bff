"""Backward differences of order 2 with exact sticking, for chains with effects (Numba).

A node's velocity and acceleration at the end of a step h are BDF2's, (3d − d⁻)/2h and the like, or
backward Euler's in the first two steps after it broke loose. All forces are those at the end of
the step, so that modes too fast for h are damped out instead of ringing, and friction without
inertia is met exactly: a slow run costs no more steps for light elements.

Equations: docs/theory.md, section 5.
"""

from __future__ import annotations

import math

import numba

from experiments.references.effect_friction import predict_ratios, set_initial_ratios
from experiments.references.effect_step import solve_step
from experiments.references.effect_system import EffectChain
from experiments.references.history import History
from tendon_mj.typing import FloatArray

COLUMNS = 5  # of `record`


@numba.njit(cache=True)
def march_effects(chain: EffectChain, history: History, record: FloatArray) -> int:
    """March ``chain`` through ``history``; fill ``record``; return the number of unsolved steps.

    Columns of ``record``: T_in [N], T_out [N], displacement of the drum [m], ξ_out [m], work of the
    input so far [J].
    """
    friction, time, value = chain.friction, history.time, history.value
    unsolved, supplied, drum, h_before = 0, 0.0, 0.0, 0.0
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
            unsolved += 0 if solve_step(chain, drum) else 1
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
