"""Parameters of the tendon of the paper's figures, with the reason for each that was chosen.

Equations: docs/theory.md, sections 1, 3.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from tendon_mj import theory
from tendon_mj.errors import InvalidValueError
from tendon_mj.sheath import Law

# Written into numbers.md. The paper gives μ, the frequencies and T_m < T_0, nothing else.
REASONS = {
    "length": "0.5 m: forearm to fingertip; 1 m in Fig. 5, for millimetres of travel",
    "bend": "π rad: with μ = 0.1 the loop shows both branches and a backlash for T_m < T_0",
    "axial_stiffness": "20 kN: steel rope of 0.5 mm; 10 kN in Fig. 5, for the same reason",
    "pretension": "20 N: the smallest reference tension of the paper's Fig. 7",
    "amplitude": "T_m = 15 N in Fig. 4: the largest round number for which μ_s = 0.3 still lets "
    "both branches be reached",
}


@dataclass(frozen=True, kw_only=True)
class PaperTendon:
    """Tendon in a uniformly bent sheath, its output end held by a spring.

    Args:
        friction: μ_d [-].
        static_friction: μ_s ≥ μ_d [-]; None means μ_s = μ_d.
        constant_friction: F_c, tension-independent friction of the whole sheath [N].
        length: L [m].
        bend: L/R, total bend angle [rad].
        axial_stiffness: EA [N].
        pretension: T_0 [N].
        output_stiffness: k_se [N/m]; inf fixes the output end, as in Fig. 4.
    """

    friction: float
    static_friction: float | None = None
    constant_friction: float = 0.0
    length: float = 0.5
    bend: float = np.pi
    axial_stiffness: float = 20e3
    pretension: float = 20.0
    output_stiffness: float = math.inf

    @property
    def exponent(self) -> float:
        """|λ| = μ_d L/R, the paper's ν [-]."""
        return self.friction * self.bend

    @property
    def law(self) -> Law:
        """Friction law of `tendon_mj.sheath` with these values."""
        return Law(
            axial_stiffness=self.axial_stiffness,
            friction=self.friction,
            static_friction=self.static_friction,
            constant_friction=self.constant_friction,
            pretension=self.pretension,
        )

    @property
    def tension_offset(self) -> float:
        """F_c/λ [N]: with T + F_c/λ in the place of T, F_c disappears from every equation.

        Raises:
            InvalidValueError: F_c > 0 in a straight or frictionless sheath.
        """
        if self.constant_friction == 0.0:
            return 0.0
        if self.exponent == 0.0:
            raise InvalidValueError(
                f"constant_friction = {self.constant_friction:g} [N] needs friction × bend > 0 "
                "here, not 0"
            )
        return self.constant_friction / self.exponent

    @property
    def slack_displacement(self) -> float:
        """ξ_in at which a tendon that slides throughout has lost all tension but −F_c/λ [m]."""
        compliance = self.length / self.axial_stiffness + 1.0 / self.output_stiffness
        return -(self.pretension + self.tension_offset) * compliance

    def transmission_stiffness(self, direction: float) -> float:
        """K_t = dT_out/dξ_in outside the backlash, pulling for direction > 0 [N/m]; eq. (17)."""
        lam = math.copysign(self.exponent, direction)
        return float(
            theory.transmission_stiffness(
                lam, self.axial_stiffness, self.length, self.output_stiffness
            )
        )

    def without_static_excess(self) -> PaperTendon:
        """Tendon with μ_s = μ_d and all else equal."""
        return dataclasses.replace(self, static_friction=None)

    def stiffened(self, factor: float) -> PaperTendon:
        """Tendon with EA and k_se times ``factor``, whose strain and travel shrink by it."""
        return dataclasses.replace(
            self,
            axial_stiffness=self.axial_stiffness * factor,
            output_stiffness=self.output_stiffness * factor,
        )

    def caption(self) -> str:
        """Parameters in one line of text."""
        output = (
            "output held (k_e, k_s → ∞)"
            if math.isinf(self.output_stiffness)
            else f"k_se = {self.output_stiffness / 1e3:g} kN/m"
        )
        static = "" if self.static_friction is None else f", μ_s = {self.static_friction:g}"
        constant = f", F_c = {self.constant_friction:g} N" if self.constant_friction else ""
        return (
            f"L = {self.length:g} m, L/R = {self.bend:.4g} rad, EA = {self.axial_stiffness / 1e3:g}"
            f" kN, T_0 = {self.pretension:g} N, μ_d = {self.friction:g}{static}{constant} "
            f"(ν = {self.exponent:.3f}), {output}"
        )
