"""What can be hidden in the bench: how it enters the truth, and how strong it may be."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np

from experiments.hidden_effects.hidden import Hidden, hidden
from experiments.hidden_effects.rig import COLUMNS, Rig
from experiments.hidden_effects.sensor import Sensor

Numbers = dict[str, float]
Draw = Callable[[np.random.Generator], Hidden[Rig]]


def _transmission(
    name: str, attribute: str, high: float, *, signed: bool = False, **second: tuple[float, float]
) -> Draw:
    """An effect of `tendon_mj.reference.Effects`; ``second`` is a further attribute's range."""

    def draw(rng: np.random.Generator) -> Hidden[Rig]:
        sign = rng.choice([-1.0, 1.0]) if signed else 1.0
        fixed: Numbers = {
            k: float(np.exp(rng.uniform(*np.log(span)))) for k, span in second.items()
        }

        def apply(rig: Rig, strength: float) -> Rig:
            given: dict[str, Any] = {**fixed, attribute: sign * strength}
            return dataclasses.replace(rig, effects=dataclasses.replace(rig.effects, **given))

        def numbers(_: Rig, strength: float) -> Numbers:
            return {f"sheath.{k}": v for k, v in {**fixed, attribute: sign * strength}.items()}

        return hidden(name, apply, numbers, high)

    return draw


def _sensor(
    name: str, attribute: str, high: float, *, signed: bool = False, parameter: str = ""
) -> Draw:
    """An effect of `Sensor` on one of the two tensions."""

    def draw(rng: np.random.Generator) -> Hidden[Rig]:
        sign = rng.choice([-1.0, 1.0]) if signed else 1.0
        column = str(rng.choice(COLUMNS))
        shift = 1.0 if attribute == "gain" else 0.0

        def apply(rig: Rig, strength: float) -> Rig:
            before = rig.sensors.get(column, Sensor())
            after = dataclasses.replace(before, **{attribute: sign * strength})
            return dataclasses.replace(rig, sensors={**rig.sensors, column: after})

        def numbers(_: Rig, strength: float) -> Numbers:
            sensor = column.removesuffix("_N")
            return {f"{sensor}.{parameter or attribute}": shift + sign * strength}

        return hidden(name, apply, numbers, high)

    return draw


def _number(
    name: str,
    attribute: str,
    parameter: str,
    value: Callable[[float], float],
    high: float,
    *,
    signed: bool = True,
    less: float = 0.0,
) -> Draw:
    """A number of the rig itself; ``value`` gives it for a signed strength.

    The model's own parameter is that ``less`` a fixed number.
    """

    def draw(rng: np.random.Generator) -> Hidden[Rig]:
        sign = rng.choice([-1.0, 1.0]) if signed else 1.0

        def apply(rig: Rig, strength: float) -> Rig:
            given: dict[str, Any] = {attribute: value(sign * strength)}
            return dataclasses.replace(rig, **given)

        return hidden(name, apply, lambda _, s: {parameter: value(sign * s) - less}, high)

    return draw


def _static_friction(rng: np.random.Generator) -> Hidden[Rig]:
    def apply(rig: Rig, strength: float) -> Rig:
        return dataclasses.replace(rig, static_excess=strength)

    return hidden(
        "static_friction",
        apply,
        lambda rig, s: {"sheath.static_friction": rig.friction * (1.0 + s)},
        1.5,
    )


def _warmth(rng: np.random.Generator) -> Hidden[Rig]:
    period = rng.uniform(5.0, 20.0)

    def apply(rig: Rig, strength: float) -> Rig:
        return dataclasses.replace(rig, warmth=(strength, period))

    return hidden("warmth", apply, lambda _, s: {"amplitude_m": s, "period_s": period}, 0.5e-3)


def _saturation(rng: np.random.Generator) -> Hidden[Rig]:
    column = str(rng.choice(COLUMNS))

    def apply(rig: Rig, strength: float) -> Rig:
        limit = rig.pretension * (3.0 - strength)
        return dataclasses.replace(rig, sensors={**rig.sensors, column: Sensor(limit=limit)})

    return hidden("sensor_saturation", apply, lambda _, s: {"below_3_T_0": s}, 1.9)


# The third number is the largest strength that is still physical, in the unit beside it.
EFFECTS: dict[str, Draw] = {
    "static_friction": _static_friction,  # 0.5 [-], μ_s/μ − 1
    "velocity_weakening": _transmission(
        "velocity_weakening", "stribeck_friction", 0.3, stribeck_velocity=(1e-3, 10e-3)
    ),  # [-]; [m/s]
    "viscous_friction": _transmission("viscous_friction", "viscous_friction", 1000.0),  # N s/m
    "constant_friction": _transmission("constant_friction", "constant_friction", 10.0),  # N
    "direction_asymmetry": _transmission(
        "direction_asymmetry", "direction_asymmetry", 0.8, signed=True
    ),  # [-]
    "position_dependent_friction": _transmission(
        "position_dependent_friction", "friction_gradient", 700.0, signed=True
    ),  # 1/m
    "friction_drift": _transmission("friction_drift", "friction_drift", 0.12, signed=True),  # 1/s
    "backlash": _transmission("backlash", "backlash", 0.8e-3),  # m
    "stiffening": _transmission("stiffening", "stiffening", 500.0),  # [-]
    "creep": _transmission("creep", "creep", 2.0, creep_time=(0.2, 3.0)),  # [-]; [s]
    "sheath_compliance": _transmission("sheath_compliance", "sheath_compliance", 1e-4),  # m/N
    "tendon_inertia": _transmission("tendon_inertia", "tendon_mass", 1.0),  # kg
    "sensor_bias": _sensor("sensor_bias", "bias", 5.0, signed=True, parameter="offset"),  # N
    "sensor_gain": _sensor("sensor_gain", "gain", 0.3, signed=True, parameter="scale"),  # [-]
    "sensor_delay": _sensor("sensor_delay", "delay", 0.1),  # s
    "sensor_lag": _sensor("sensor_lag", "lag", 0.1),  # s
    "sensor_drift": _sensor("sensor_drift", "drift", 1.0, signed=True),  # N/s
}
# On a model that has no friction.
SHEATH_FRICTION = _number(
    "sheath_friction", "friction", "sheath.friction", lambda s: s, 0.4, signed=False
)
# The model's own number is wrong, and the recording does not call it uncertain.
PARAMETERS: dict[str, Draw] = {
    "friction": _number("friction", "friction", "sheath.friction", lambda s: 0.15 * (1.0 + s), 0.8),
    "axial_stiffness": _number(
        "axial_stiffness", "axial_stiffness", "sheath.axial_stiffness", lambda s: 2e4 * (1 + s), 0.6
    ),
    "pretension": _number(
        "pretension", "pretension", "sheath.pretension", lambda s: 20.0 * (1.0 + s), 0.6
    ),
    "bend_angle": _number(
        "bend_angle", "bend", "sheath.extra_bend", lambda s: np.pi * (1.0 + s), 0.5, less=np.pi
    ),
    "moment_arm": _number(
        "moment_arm", "reel_scale", "reel.command_scale", lambda s: 1.0 + s, 0.25
    ),
}
# What no catalogue holds.
STRANGE: dict[str, Draw] = {
    "sensor_hum": _sensor("sensor_hum", "hum", 5.0),  # N
    "warmth": _warmth,  # 0.5e-3 m
    "sensor_saturation": _saturation,  # 1.9 [-], of T_0
}
# Of these, one in the catalogue can pass for the other.
ALIKE = ({"sensor_delay", "sensor_lag"}, {"sensor_bias", "sensor_gain"})
EXCLUDABLE = (
    "velocity_weakening",
    "direction_asymmetry",
    "position_dependent_friction",
    "friction_drift",
    "backlash",
    "creep",
    "sensor_delay",
    "sensor_drift",
)
