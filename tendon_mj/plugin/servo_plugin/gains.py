"""Gains and limits of the servo, as a value."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final, SupportsFloat, TypedDict

from tendon_mj.sheath import POSITIVE, Parameter, check_in_range, described, parameters_of


@dataclass(frozen=True)
class Gains:
    """Parameters of a servo, in the order of its state and of the plugin's attributes.

    None: taken from elsewhere. A limit or a stiffness of 0 is none, that is without end.
    """

    tension_gain: float = field(metadata=described("G_t", "-", "gain of the tension", POSITIVE))
    velocity_gain: float = field(
        metadata=described("G_v", "N m s/rad", "damping of the motor's speed")
    )
    loosening_tension_gain: float | None = field(
        default=None,
        metadata=described("G_t", "-", "gain while paying out, default tension_gain", POSITIVE),
    )
    loosening_velocity_gain: float | None = field(
        default=None,
        metadata=described("G_v", "N m s/rad", "damping while paying out, default velocity_gain"),
    )
    motor_inertia: float | None = field(
        default=None,
        metadata=described("J_m", "kg m²", "inertia, default the joint's armature", POSITIVE),
    )
    torque_limit: float = field(
        default=0.0, metadata=described("τ_max", "N m", "largest torque, 0: no limit")
    )
    speed_limit: float = field(
        default=0.0, metadata=described("ω_max", "rad/s", "largest speed, 0: no limit")
    )
    period: float = field(
        default=0.0,
        metadata=described("Δ", "s", "time between samples of the controller, 0: every time step"),
    )
    delay: float = field(
        default=0.0, metadata=described("d", "s", "time from a sample to its torque")
    )
    observer_friction: float | None = field(
        default=None,
        metadata=described("μ", "-", "friction of observer and feed-forward, default the sheath's"),
    )
    output_stiffness: float = field(
        default=0.0, metadata=described("k_se", "N/m", "stiffness of the feed-forward, 0: rigid")
    )
    backlash_feedforward: float = field(
        default=0.0,
        metadata=described("f_b", "-", "1 crosses the backlash at once when T_r turns back"),
    )
    rate_feedforward: float = field(
        default=0.0,
        metadata=described("f_r", "-", "1 adds the speed that a changing T_r asks for"),
    )
    reversal_band: float = field(
        default=0.0,
        metadata=described("B", "N", "change of T_r that counts as turning back"),
    )


class OptionalGains(TypedDict, total=False):
    """Parameters of `Gains` that a call may leave out, for type checkers: they read no metadata."""

    loosening_tension_gain: SupportsFloat | None
    loosening_velocity_gain: SupportsFloat | None
    motor_inertia: SupportsFloat | None
    torque_limit: SupportsFloat | None
    speed_limit: SupportsFloat | None
    period: SupportsFloat | None
    delay: SupportsFloat | None
    observer_friction: SupportsFloat | None
    output_stiffness: SupportsFloat | None
    backlash_feedforward: SupportsFloat | None
    rate_feedforward: SupportsFloat | None
    reversal_band: SupportsFloat | None


GAINS: Final[dict[str, Parameter]] = parameters_of(Gains)


def check_gain(name: str, value: float, where: str) -> None:
    """Refuse a servo's parameter outside its range.

    Raises:
        InvalidValueError: names the parameter, the value, its range and unit.
    """
    check_in_range(GAINS, name, value, where)
