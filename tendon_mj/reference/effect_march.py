"""Backward differences of order 2 with exact sticking, for chains with effects (Numba).

Nodes are the elements, then the carriages; the unknowns of a step h are d, what of each passes. A
node's velocity and acceleration at the end of the step are BDF2's, (3d − d⁻)/2h and the like, or
backward Euler's in the first two steps after it broke loose. All forces are those at the end of
the step, so that modes too fast for h are damped out instead of ringing, and friction without
inertia is met exactly: a slow run costs no more steps for light elements.

Stick and slip, as unknowns of the step: a resting element stays (d = 0) while its two tensions are
within the limits, else it slides the way it is pulled; one that would slide backwards is held for
the rest of the step. All directions are revised at once after each linear solve, the springs
linearised anew, until nothing changes.

F_c and c_v act one half before and one half behind the turn of an element, which makes them those
of friction along the turn to second order in φ_i.

Equations: docs/theory.md, section 5.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tendon_mj.compilation import checked
from tendon_mj.reference.checks import FloatArray
from tendon_mj.reference.effect_law import pull, ratios
from tendon_mj.reference.stick import solve_tridiagonal

ATTEMPTS = 100
TOLERANCE = 1e-8  # of the tensions against their linearisation [N]
COLUMNS = 5


@checked
def springs(
    n: int,
    ends: int,
    drum: float,
    reached: FloatArray,
    d: FloatArray,
    rate: FloatArray,
    retardation: float,
    compliance: FloatArray,
    material: FloatArray,
    k: FloatArray,
    start: float,
    crept: FloatArray,
    tension: FloatArray,
    left: FloatArray,
    right: FloatArray,
) -> None:
    """Fill the tensions of all springs at the end of a step, and their derivatives [N/m].

    Retardation acts on what the elements pass; mount, drum and output move too slowly to matter.
    """
    pretension, alpha, stiffening = material[0], material[1], material[2]
    for j in range(n + 1):
        gain = drum if j == 0 else reached[j - 1] + d[j - 1]
        shift = 0.0
        if j < n:
            gain -= reached[j] + d[j]
        elif ends > 0:
            shift = reached[n] + d[n]
        tension[j], left[j], right[j] = pull(
            gain, shift, compliance[0] if j == 0 else 0.0,
            compliance[1] if j == n and ends == 0 else 0.0, k[j], alpha, start, crept[j],
            stiffening, pretension, tension[j],
        )  # fmt: skip
        if j < n:
            right[j] = left[j]
        if retardation > 0.0 and 0 < j < n:
            slow = retardation * k[j]
            tension[j] += slow * (rate[2, j - 1] * d[j - 1] + rate[3, j - 1])
            tension[j] -= slow * (rate[2, j] * d[j] + rate[3, j])
            left[j] += slow * rate[2, j - 1]
            right[j] += slow * rate[2, j]


@checked
def advance(
    n: int,
    drum: float,
    reached: FloatArray,
    rate: FloatArray,
    force: FloatArray,
    viscous: float,
    retardation: float,
    tail: FloatArray,
    compliance: FloatArray,
    material: FloatArray,
    k: FloatArray,
    start: float,
    crept: FloatArray,
    hold: FloatArray,
    slide: FloatArray,
    side: npt.NDArray[np.int64],
    d: FloatArray,
    tension: FloatArray,
    work: FloatArray,
) -> bool:
    """Find directions, ``d`` and ``tension`` of one step; return whether it was solved.

    ``rate`` rows: inertia force per d [N/m] and at d = 0 [N], velocity per d [1/s] and at d = 0,
    damping [N s/m]. ``tail`` rows: stiffness, damping behind each carriage.
    """
    ends = tail.shape[1]
    nodes = n + ends
    lower, diagonal = work[0, :nodes], work[1, :nodes]
    upper, load = work[2, :nodes], work[3, :nodes]
    left, right, linear = work[4], work[5], work[6]
    held = np.zeros(n, dtype=np.bool_)
    springs(n, ends, drum, reached, d, rate, retardation, compliance, material, k, start, crept,
            tension, left, right)  # fmt: skip
    for _ in range(ATTEMPTS):
        for i in range(n):
            free = hold[0, i] == 1.0 and hold[1, i] == 1.0 and force[i] == 0.0
            if side[i] == 0 and not free:
                lower[i], diagonal[i], upper[i], load[i] = 0.0, 1.0, 0.0, 0.0
                continue
            low = slide[0, i] if side[i] >= 0 else 1.0  # weight of the output side
            high = slide[1, i] if side[i] < 0 else 1.0
            mean = 0.5 * (low + high)
            rub = rate[4, i] + mean * viscous
            lower[i] = -high * left[i]
            upper[i] = -low * right[i + 1]
            diagonal[i] = rate[0, i] + rub * rate[2, i] + high * right[i] + low * left[i + 1]
            load[i] = (
                high * tension[i] - low * tension[i + 1] - side[i] * mean * force[i]
                - rate[1, i] - rub * rate[3, i]
                + high * right[i] * d[i] + low * left[i + 1] * d[i]
            )  # fmt: skip
            load[i] -= (high * left[i] * d[i - 1]) if i > 0 else 0.0
            load[i] -= (low * right[i + 1] * d[i + 1]) if i + 1 < nodes else 0.0
        for e in range(ends):
            i = n + e
            stiff = tail[0, e] + tail[1, e] * rate[2, i]
            beyond = reached[i + 1] if e + 1 < ends else 0.0
            drift = rate[3, i] - (rate[3, i + 1] if e + 1 < ends else 0.0)
            diagonal[i] = rate[0, i] + stiff
            load[i] = -rate[1, i] - tail[0, e] * (reached[i] - beyond) - tail[1, e] * drift
            upper[i] = 0.0
            if e + 1 < ends:
                upper[i] = -tail[0, e] - tail[1, e] * rate[2, i + 1]
            if e == 0:
                diagonal[i] += right[n]
                lower[i] = -left[n]
                load[i] += tension[n] - material[4] + right[n] * d[i] - left[n] * d[i - 1]
            else:
                before = tail[0, e - 1] + tail[1, e - 1] * rate[2, i]
                lower[i] = -tail[0, e - 1] - tail[1, e - 1] * rate[2, i - 1]
                diagonal[i] += before
                load[i] += tail[0, e - 1] * (reached[i - 1] - reached[i])
                load[i] += tail[1, e - 1] * (rate[3, i - 1] - rate[3, i])
        lower[0] = 0.0
        for j in range(n + 1):  # tension at the new d, were the springs linear
            linear[j] = tension[j]
            linear[j] -= left[j] * d[j - 1] if j > 0 else 0.0
            linear[j] += right[j] * d[j] if j < nodes else 0.0
        solve_tridiagonal(lower, diagonal, upper, load, d)
        for j in range(n + 1):
            linear[j] += left[j] * d[j - 1] if j > 0 else 0.0
            linear[j] -= right[j] * d[j] if j < nodes else 0.0
        springs(n, ends, drum, reached, d, rate, retardation, compliance, material, k, start, crept,
                tension, left, right)  # fmt: skip
        solved = True
        for j in range(n + 1):
            solved = solved and abs(tension[j] - linear[j]) <= TOLERANCE
        for i in range(n):
            if hold[0, i] == 1.0 and hold[1, i] == 1.0 and force[i] == 0.0:
                continue
            if side[i] != 0:
                if d[i] * side[i] < 0.0:
                    side[i], held[i], solved = 0, True, False
            elif not held[i]:
                half = 0.5 * force[i]
                if tension[i] - half > hold[0, i] * (tension[i + 1] + half):
                    side[i], solved = 1, False
                elif tension[i + 1] - half > hold[1, i] * (tension[i] + half):
                    side[i], solved = -1, False
        if solved:
            return True
    return False


@checked
def march_effects(
    time: FloatArray,
    drive: FloatArray,
    substeps: npt.NDArray[np.int64],
    k: FloatArray,
    mass: FloatArray,
    damping: FloatArray,
    tail: FloatArray,
    compliance: FloatArray,
    material: FloatArray,
    angle: FloatArray,
    resting: FloatArray,
    sliding: FloatArray,
    force: FloatArray,
    viscous: float,
    retardation: float,
    asymmetry: float,
    gradient: float,
    drift: float,
    weakening: FloatArray,
    backlash: float,
    creep: FloatArray,
    record: FloatArray,
) -> int:
    """March from rest under T_0 through ``time``; fill ``record``; count unsolved steps.

    ``material``: T_0, 1/EA, κ, τ_0, tension that the carriages balance. ``compliance``: of the
    mount, of a massless output. ``tail``: stiffness and damping behind each carriage, none for a
    massless output. ``weakening``: Δμ, v_s,
    memory. ``creep``: χ, τ_c. Columns of ``record``: T_in, T_out, what of ξ_in reached the drum,
    ξ_out, work of the input so far.
    """
    n, nodes, ends = angle.size, mass.size, tail.shape[1]
    pretension, start = material[0], material[3]
    unsolved, supplied, drum = 0, 0.0, 0.0
    reached, d, before = np.zeros(nodes), np.zeros(nodes), np.zeros(nodes)
    v, v_before = np.zeros(nodes), np.zeros(nodes)
    speed, seen, ahead = np.zeros(n), np.zeros(n), np.zeros(n)
    side, same = np.zeros(n, dtype=np.int64), np.zeros(nodes, dtype=np.int64)
    last_side = np.zeros(n, dtype=np.int64)
    tension, last = np.full(n + 1, pretension), np.full(n + 1, pretension)
    crept, crept_next = np.full(n + 1, start), np.full(n + 1, creep[0] * pretension)
    crept[:] = creep[0] * pretension
    hold, slide = np.ones((2, n)), np.ones((2, n))
    rate, work = np.zeros((5, nodes)), np.zeros((7, nodes + 1))
    rate[4] = damping
    h_before = 0.0
    varies = gradient != 0.0 or drift != 0.0 or weakening[0] > 0.0
    ratios(angle, resting, sliding, asymmetry, gradient, 1.0, weakening[0], weakening[1],
           reached, seen, hold, slide)  # fmt: skip
    for sample in range(time.size):
        steps = 0 if sample == 0 else substeps[sample - 1]
        h = 1.0 if sample == 0 else (time[sample] - time[sample - 1]) / steps
        for step in range(steps):
            share = (step + 1.0) / steps
            wound = drive[sample - 1] + share * (drive[sample] - drive[sample - 1])
            drum_before = drum
            drum = min(max(drum, wound - 0.5 * backlash), wound + 0.5 * backlash)
            if varies:
                now = max(0.0, time[sample - 1] + share * (time[sample] - time[sample - 1]))
                fade = -math.expm1(-h / weakening[2])
                for i in range(n):
                    seen[i] = speed[i] + (abs(d[i]) / h - speed[i]) * fade
                    ahead[i] = reached[i] + d[i]
                aged = max(0.0, 1.0 + drift * now)
                ratios(angle, resting, sliding, asymmetry, gradient, aged,
                       weakening[0], weakening[1], ahead, seen, hold, slide)  # fmt: skip
            if creep[0] > 0.0:
                crept_share = -math.expm1(-h / creep[1])
                for j in range(n + 1):
                    guess = 2.0 * tension[j] - last[j]
                    mean = 0.5 * (tension[j] + guess)
                    crept_next[j] = crept[j] + (creep[0] * mean - crept[j]) * crept_share
            for i in range(nodes):
                before[i] = d[i]
                if same[i] >= 2 and abs(h - h_before) <= 1e-6 * h:
                    rate[2, i], rate[3, i] = 1.5 / h, -0.5 * d[i] / h
                    rate[0, i] = mass[i] * 1.5 / h * rate[2, i]
                    rate[1, i] = mass[i] / h * (1.5 * rate[3, i] - 2.0 * v[i] + 0.5 * v_before[i])
                else:
                    rate[2, i], rate[3, i] = 1.0 / h, 0.0
                    rate[0, i] = mass[i] / h**2
                    rate[1, i] = -mass[i] * v[i] / h
            last[:] = tension
            ok = advance(n, drum, reached, rate, force, viscous, retardation, tail,
                         compliance, material, k, start, crept_next, hold, slide,
                         side, d, tension, work)  # fmt: skip
            unsolved += 0 if ok else 1
            supplied += 0.5 * (last[0] + tension[0]) * (drum - drum_before)
            for i in range(nodes):
                v_before[i] = v[i]
                v[i] = rate[2, i] * d[i] + rate[3, i]
                reached[i] += d[i]
                same[i] += 1
                if i < n:
                    if d[i] == 0.0:
                        side[i], v[i] = 0, 0.0
                    if side[i] != last_side[i]:
                        same[i] = 0
                    last_side[i] = side[i]
                    speed[i] += (abs(d[i]) / h - speed[i]) * -math.expm1(-h / weakening[2])
            if creep[0] > 0.0:
                for j in range(n + 1):
                    mean = 0.5 * (tension[j] + last[j])
                    crept[j] += (creep[0] * mean - crept[j]) * -math.expm1(-h / creep[1])
            h_before = h
        row = record[sample]
        row[0], row[1], row[2] = tension[0], tension[n], drum
        row[3] = reached[n] if ends > 0 else compliance[1] * (tension[n] - pretension)
        row[4] = supplied
    return unsolved
