"""Effects of a transmission beyond Coulomb friction and Hooke's law: one number each.

Every number is 0 by default, and the effect absent. Friction of element i of n, sliding with
speed |v_i| toward the input (dir = +1) or the output (−1), with T_high on the side it moves to:

    T_high = T_low e^{μ_i φ_i} + F_c/n + (c_v/n) |v_i|,
    μ_i = μ max(0, 1 + γ u_i) max(0, 1 + β t) (1 + α dir) + Δμ e^{−w_i/v_s},
    0.02 s · dw_i/dt = |v_i| − w_i,

u_i the tendon that has passed the element; at rest the same with μ_s for μ and no c_v. Tendon:

    T = EA ε (1 + κ ε),   strain = ε + ε_c,   τ_c dε_c/dt = χ T/EA − ε_c.

Equations: docs/theory.md, section 5.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from experiments.references.checks import number
from tendon_mj.errors import InvalidValueError

MEMORY = 0.02  # of the sliding speed that velocity weakening sees [s]
_SIGNED = ("friction_gradient", "friction_drift", "extra_bend", "direction_asymmetry")


@dataclass(frozen=True, kw_only=True)
class Effects:
    """Effects on a chain of elements; the defaults are inert.

    Args:
        stribeck_friction: Δμ, friction at rest above that of fast sliding [–], ≥ 0.
        stribeck_velocity: v_s, speed over which it fades [m/s]; > 0 where Δμ > 0.
        viscous_friction: c_v, of the whole tendon [N s/m], ≥ 0.
        constant_friction: F_c, of the whole tendon besides the chain's own [N], ≥ 0.
        direction_asymmetry: α, −1 < α < 1 [–].
        friction_gradient: γ, share by which μ grows per metre of tendon passed [1/m].
        friction_drift: β, share by which μ grows per second from time 0 on [1/s].
        backlash: b, width of the play between drive and drum; starts centred [m], ≥ 0.
        stiffening: κ, share by which EA grows per unit strain [–], ≥ 0.
        creep: χ, delayed strain over elastic strain [–], ≥ 0.
        creep_time: τ_c [s]; > 0 where χ > 0.
        sheath_compliance: C_s, compliance of the sheath's mount at the input [m/N], ≥ 0.
        tendon_mass: m, of the whole tendon besides the chain's own [kg], ≥ 0.
        extra_bend: φ_x, bend of the whole sheath besides the chain's own [rad].
        retardation_time: τ_r of T = EA (ε + τ_r dε/dt) between elements [s], ≥ 0: the loss in the
            tendon that ends its own ringing where it has mass.
        axial_stiffness: EA [N], > 0: what strain a tension is, for finite strain and for
            stiffening. inf: strain is infinitesimal, nothing stiffens.

    Raises:
        InvalidValueError: a value out of its range.
    """

    stribeck_friction: float = 0.0
    stribeck_velocity: float = 0.0
    viscous_friction: float = 0.0
    constant_friction: float = 0.0
    direction_asymmetry: float = 0.0
    friction_gradient: float = 0.0
    friction_drift: float = 0.0
    backlash: float = 0.0
    stiffening: float = 0.0
    creep: float = 0.0
    creep_time: float = 0.0
    sheath_compliance: float = 0.0
    tendon_mass: float = 0.0
    extra_bend: float = 0.0
    retardation_time: float = 0.0
    axial_stiffness: float = math.inf

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name == "axial_stiffness":
                number(field.name, value, above=0.0, infinite=True)
            else:
                number(field.name, value, least=-math.inf if field.name in _SIGNED else 0.0)
        if not abs(self.direction_asymmetry) < 1.0:
            raise InvalidValueError(
                f"direction_asymmetry is {self.direction_asymmetry:g}; it must be > -1 and < 1"
            )
        for strength, scale in (
            ("stribeck_friction", "stribeck_velocity"),
            ("creep", "creep_time"),
        ):
            if getattr(self, strength) > 0.0 and not getattr(self, scale) > 0.0:
                raise InvalidValueError(
                    f"{scale} is {getattr(self, scale):g}; with {strength} > 0 it must be > 0"
                )


@dataclass(frozen=True, kw_only=True)
class Carriage:
    """A mass behind the tendon's output, on a spring and a damper to the next one or the ground.

    Args:
        mass: [kg], ≥ 0.
        stiffness: of the spring behind it [N/m], > 0; it is unstrained under T_0.
        damping: of the damper beside that spring [N s/m], ≥ 0.

    Raises:
        InvalidValueError: a value out of its range.
    """

    mass: float
    stiffness: float
    damping: float

    def __post_init__(self) -> None:
        number("mass", self.mass, least=0.0)
        number("stiffness", self.stiffness, above=0.0)
        number("damping", self.damping, least=0.0)
