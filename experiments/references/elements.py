"""The paper's lumped elements (section 2.2, Fig. 3), and a sheath cut into n of them.

Element i (i = 1 … n) carries mass m_i and damping c_i, bends by φ_i = ΔL/R_i and hangs between the
tension T_i on its input side and T_{i+1} on its output side:

    m_i ξ̈_i + c_i ξ̇_i = a_i T_i − T_{i+1} − f_i sgn ξ̇_i                       eqs. (21), (22), (25)
    T_{i+1} = T_0 + k_i (ξ_i − ξ_{i+1}),   T_{n+1} = T_0 + k′_n ξ_n            eqs. (23), (24)

with 1/k′_n = 1/k_n + 1/k_e + 1/k_s, and no tension below zero (a tendon does not push). Two laws:

* ``"exponential"`` (default): a_i = exp(−μ_i φ_i sgn ξ̇_i), the capstan ratio of one element, exact
  for any bend angle. n elements then have the ratio e^{∓λ} exactly and the rest converges as 1/n².
* ``"linear"``: a_i = 1 − μ_i φ_i sgn ξ̇_i, eq. (22) to the letter. Its ratio (1 ∓ λ/n)^n is short of
  e^{∓λ} by λ²/2n: 0.8 % at λ = 1 and 64 elements, which is why it is not the default.

Equations: docs/theory.md, section 5.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np
import numpy.typing as npt

from experiments.references.checks import series, vector
from tendon_mj.typing import FloatArray

Law = Literal["exponential", "linear"]
_FRICTION = ("static_friction", "dynamic_friction", "friction_force")


@dataclass(frozen=True, eq=False, kw_only=True)
class ElementChain:
    """A tendon in a sheath as n masses on springs with friction; eqs. (21)–(25) of the paper.

    Arrays are in order from the input to the output; a number stands for n equal values, n being
    the size of ``bend_angle``.

    Args:
        bend_angle: φ_i = ΔL/R_i, angle by which each element turns [rad], ≥ 0. Shape (n,).
        mass: m_i [kg], > 0. Number or shape (n,).
        damping: c_i [N s/m], ≥ 0. Number or shape (n,).
        stiffness: k_i, spring from element i to i + 1, the last one to the tendon's output end
            [N/m], > 0. Number or shape (n,).
        static_friction: μ_s of each element, eq. (1) [–], ≥ μ_d. Number or shape (n,).
        dynamic_friction: μ_d of each element, eq. (1) [–], ≥ 0. Number or shape (n,).
        friction_force: f_i, tension-independent friction, at rest and in motion [N], ≥ 0. Not in
            eq. (22); section 2.3 suspects it behind Fig. 5. Number or shape (n,).
        pretension: T_0, tension along the tendon at ξ = 0 [N], > 0.
        input_stiffness: k_0, spring between the input end and element 1 [N/m]; inf puts T_in on
            element 1 itself as eq. (24) does, and then only T_in can be prescribed.
        environment_stiffness: k_e [N/m]; inf is a fixed output end.
        sensor_stiffness: k_s [N/m]; inf is a rigid sensor.
        law: friction law of one element, "exponential" or "linear" (see the module).
    """

    bend_angle: FloatArray
    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    static_friction: FloatArray
    dynamic_friction: FloatArray
    friction_force: FloatArray = field(default_factory=lambda: np.array(0.0))
    pretension: float
    input_stiffness: float = np.inf
    environment_stiffness: float = np.inf
    sensor_stiffness: float = np.inf
    law: Law = "exponential"

    def __post_init__(self) -> None:
        object.__setattr__(self, "bend_angle", np.atleast_1d(vector(self.bend_angle)))
        for name in ("mass", "stiffness", "damping", *_FRICTION):
            object.__setattr__(self, name, vector(getattr(self, name), self.n))

    @property
    def n(self) -> int:
        """Number of elements [–]."""
        return int(self.bend_angle.size)

    @property
    def output_stiffness(self) -> float:
        """k_se of environment and sensor in series [N/m]; eq. (15)."""
        return series(self.environment_stiffness, self.sensor_stiffness)

    @cached_property
    def spring_stiffness(self) -> FloatArray:
        """k_0, k_1 … k_{n−1}, k′_n: every spring from input to output [N/m]; eq. (24). (n + 1,)."""
        springs = np.concatenate(([self.input_stiffness], self.stiffness))
        springs[-1] = series(springs[-1], self.output_stiffness)
        return springs

    @property
    def exponent(self) -> float:
        """λ > 0 of the whole chain in motion, Σ μ_d φ_i [–]; eq. (12)."""
        return float(self.dynamic_friction @ self.bend_angle)

    @property
    def time_step(self) -> float:
        """Step that resolves the fastest element [s]: min of ½ √(m_i/(k_{i−1} + k_i)), m_i/c_i."""
        springs = self.spring_stiffness.copy()
        if np.isinf(springs[0]):
            springs[0] = 0.0  # a prescribed tension adds no stiffness
        fastest = 0.5 * np.sqrt(self.mass / (springs[:-1] + springs[1:]))
        damped = self.mass[self.damping > 0.0] / self.damping[self.damping > 0.0]
        return float(min(fastest.min(), damped.min(initial=np.inf)))

    def friction_weights(self, friction: npt.ArrayLike) -> FloatArray:
        """Friction of each element per unit of T_i when pulled (row 0) and loosened (row 1) [–].

        1 − e^{−μφ} and e^{μφ} − 1 in the exponential law, μφ twice in the linear one. Shape (2, n).
        """
        turn = np.asarray(friction) * self.bend_angle
        if self.law == "linear":
            return np.stack((turn, turn))
        return np.stack((-np.expm1(-turn), np.expm1(turn)))


Ends = Literal["half", "paper"]


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
    """
    sliding = static_friction if dynamic_friction is None else dynamic_friction
    input_stiffness, stiffness = _springs(n, length, axial_stiffness, ends)
    angle = vector(bend_angle, n)
    if np.ndim(bend_angle) == 0:
        angle = angle / n
    return ElementChain(
        bend_angle=angle,
        mass=np.full(n, mass / n),
        damping=np.full(n, damping / n),
        stiffness=stiffness,
        static_friction=np.full(n, static_friction),
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
    cut = axial_stiffness * n / length
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
    ω_1 = 2π · slowness / time_scale, and c_i = 2 ζ m_i ω_1. The residue of inertia and damping in
    T_out was measured against the continuum at λ = 1 and ζ = 0.1: up to 0.12/slowness of its range
    with ξ_in prescribed, up to 4/slowness with T_in prescribed (in a loosening, when the front
    reaches the output).

    Args:
        chain: its masses and dampings are replaced.
        time_scale: shortest time in which the input runs through its range, a period [s], > 0.
        slowness: by how much the chain is faster than ``time_scale`` [–], > 0. The steps needed
            grow with slowness × n.
        damping_ratio: ζ of the lowest mode [–], ≥ 0.
    """
    omega = 2.0 * math.pi * slowness / time_scale
    springs = chain.spring_stiffness[1:]
    matrix = np.diag(springs + np.concatenate(([0.0], springs[:-1])))
    matrix -= np.diag(springs[:-1], 1) + np.diag(springs[:-1], -1)
    lowest = float(np.linalg.eigvalsh(matrix)[0])
    mass = lowest / omega**2
    return dataclasses.replace(
        chain,
        mass=np.full(chain.n, mass),
        damping=np.full(chain.n, 2.0 * damping_ratio * mass * omega),
    )
