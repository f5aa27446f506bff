"""Chains ready to run: a sheath cut into n elements, and the inertia for a slow run.

Equations: docs/theory.md, section 5.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Literal

import numpy as np
import numpy.typing as npt

from experiments.references.checks import number, vector, whole
from experiments.references.elements import ElementChain, Law
from tendon_mj.errors import UnknownNameError
from tendon_mj.typing import FloatArray

Ends = Literal["half", "paper"]
ENDS: tuple[Ends, ...] = ("half", "paper")


def uniform_chain(
    n: int,
    *,
    length: float,
    bend_angle: npt.ArrayLike,
    axial_stiffness: float,
    pretension: float,
    static_friction: float,
    dynamic_friction: float | None = None,
    friction_force: float = 0.0,
    mass: float = 1.0,
    damping: float = 0.0,
    environment_stiffness: float = math.inf,
    sensor_stiffness: float = math.inf,
    law: Law = "exponential",
    ends: Ends = "half",
) -> ElementChain:
    """Cut a sheath into ``n`` elements of equal length ΔL = L/n; Fig. 3 of the paper.

    Args:
        n: number of elements, ≥ 1.
        length: L [m], > 0.
        bend_angle: total bend angle L/R [rad], or that of each element, shape (n,).
        axial_stiffness: EA, force per unit strain [N], > 0; k_i = EA/ΔL.
        pretension: T_0 [N], > 0.
        static_friction: μ_s [–].
        dynamic_friction: μ_d [–]; None means μ_s.
        friction_force: tension-independent friction of the whole tendon [N], shared evenly.
        mass: of the whole tendon [kg], shared evenly. The default of 1 kg is a placeholder for
            `quasi_static`, which replaces it.
        damping: of the whole tendon [N s/m], shared evenly.
        environment_stiffness: k_e [N/m].
        sensor_stiffness: k_s [N/m].
        law: see `ElementChain`.
        ends: "half" puts each element in the middle of its length, so that the springs at the two
            ends are half as long (k_0 = k_n = 2 EA/ΔL): the elongation converges as 1/n².
            "paper" is eq. (24): T_in on element 1, every spring EA/ΔL; it converges as 1/n.

    Raises:
        InvalidValueError: a value out of its range, or a list where one number is due (a chain
            whose elements differ is an `ElementChain`).
        UnknownNameError: an unknown ``law`` or ``ends``.
    """
    n = whole("n", n)
    mass = number("mass", mass, above=0.0)
    damping = number("damping", damping, least=0.0)
    friction_force = number("friction_force", friction_force, least=0.0)
    resting = number("static_friction", static_friction, least=0.0)
    sliding = resting
    if dynamic_friction is not None:
        sliding = number("dynamic_friction", dynamic_friction, least=0.0)
    input_stiffness, stiffness = _springs(n, length, axial_stiffness, ends)
    angle = vector("bend_angle", bend_angle, n, least=0.0)
    if np.ndim(bend_angle) == 0:
        angle = angle / n
    return ElementChain(
        bend_angle=angle,
        mass=np.full(n, mass / n),
        damping=np.full(n, damping / n),
        stiffness=stiffness,
        static_friction=np.full(n, resting),
        dynamic_friction=np.full(n, sliding),
        friction_force=np.full(n, friction_force / n),
        pretension=pretension,
        input_stiffness=input_stiffness,
        environment_stiffness=environment_stiffness,
        sensor_stiffness=sensor_stiffness,
        law=law,
    )


def _springs(n: int, length: float, axial_stiffness: float, ends: Ends) -> tuple[float, FloatArray]:
    """Stiffness of the spring before the elements and of those behind each [N/m]."""
    if ends not in ENDS:
        raise UnknownNameError("placement of the ends", ends, ENDS)
    cut = number("axial_stiffness", axial_stiffness, above=0.0)
    cut *= n / number("length", length, above=0.0)
    stiffness = np.full(n, cut)
    if ends == "half":
        stiffness[-1] = 2.0 * cut
    return 2.0 * cut if ends == "half" else math.inf, stiffness


def quasi_static(
    chain: ElementChain,
    time_scale: float,
    *,
    slowness: float = 1000.0,
    damping_ratio: float = 0.1,
) -> ElementChain:
    """Give a chain equal masses and dampings for which inertia is small at ``time_scale``.

    The lowest frequency of the chain without friction, input end free, becomes
    ω_1 = 2π · slowness / time_scale, and c_i = 2 ζ m_i ω_1. What inertia and damping leave in
    T_out was measured against the continuum at λ = 1 and ζ = 0.1: up to 0.12/slowness of its range
    with ξ_in prescribed, up to 4/slowness with T_in prescribed (in a loosening, when the front
    reaches the output).

    Args:
        chain: its masses and dampings are replaced.
        time_scale: shortest time in which the input runs through its range, a period [s], > 0.
        slowness: by how much the chain is faster than ``time_scale`` [–], > 0. The steps needed
            grow with slowness × n.
        damping_ratio: ζ of the lowest mode [–], ≥ 0.

    Raises:
        InvalidValueError: a value out of its range.
    """
    scale = number("time_scale", time_scale, above=0.0)
    omega = 2.0 * math.pi * number("slowness", slowness, above=0.0) / scale
    zeta = number("damping_ratio", damping_ratio, least=0.0)
    springs = chain.spring_stiffness[1:]
    matrix = np.diag(springs + np.concatenate(([0.0], springs[:-1])))
    matrix -= np.diag(springs[:-1], 1) + np.diag(springs[:-1], -1)
    lowest = float(np.linalg.eigvalsh(matrix)[0])
    mass = lowest / omega**2
    return dataclasses.replace(
        chain,
        mass=np.full(chain.n, mass),
        damping=np.full(chain.n, 2.0 * zeta * mass * omega),
    )
