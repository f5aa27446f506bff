"""Catalogue of effects that can be hidden in the bench, each with its largest strength."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np

from experiments.hidden_effects.hidden_effect import HiddenEffect
from experiments.hidden_effects.reference_bench import COLUMNS, ReferenceBench
from experiments.hidden_effects.sensor import Sensor

Parameters = dict[str, float]
Draw = Callable[[np.random.Generator], HiddenEffect[ReferenceBench]]


def _transmission(
    name: str, attribute: str, high: float, *, signed: bool = False, **second: tuple[float, float]
) -> Draw:
    """An effect of `tendon_mj.reference.Effects`; ``second`` is a further attribute's range."""

    def draw(rng: np.random.Generator) -> HiddenEffect[ReferenceBench]:
        sign = rng.choice([-1.0, 1.0]) if signed else 1.0
        fixed: Parameters = {
            k: float(np.exp(rng.uniform(*np.log(span)))) for k, span in second.items()
        }

        def apply(bench: ReferenceBench, strength: float) -> ReferenceBench:
            given: dict[str, Any] = {**fixed, attribute: sign * strength}
            return dataclasses.replace(bench, effects=dataclasses.replace(bench.effects, **given))

        def parameters(_: ReferenceBench, strength: float) -> Parameters:
            return {f"sheath.{k}": v for k, v in {**fixed, attribute: sign * strength}.items()}

        return HiddenEffect(name=name, apply=apply, parameters=parameters, high=high)

    return draw


def _sensor(
    name: str, attribute: str, high: float, *, signed: bool = False, parameter: str = ""
) -> Draw:
    """An effect of `Sensor` on one of the two tensions."""

    def draw(rng: np.random.Generator) -> HiddenEffect[ReferenceBench]:
        sign = rng.choice([-1.0, 1.0]) if signed else 1.0
        column = str(rng.choice(COLUMNS))
        shift = 1.0 if attribute == "gain" else 0.0

        def apply(bench: ReferenceBench, strength: float) -> ReferenceBench:
            before = bench.sensors.get(column, Sensor())
            after = dataclasses.replace(before, **{attribute: sign * strength})
            return dataclasses.replace(bench, sensors={**bench.sensors, column: after})

        def parameters(_: ReferenceBench, strength: float) -> Parameters:
            sensor = column.removesuffix("_N")
            return {f"{sensor}.{parameter or attribute}": shift + sign * strength}

        return HiddenEffect(name=name, apply=apply, parameters=parameters, high=high)

    return draw


def _parameter(
    name: str,
    attribute: str,
    parameter: str,
    value: Callable[[float], float],
    high: float,
    *,
    signed: bool = True,
    less: float = 0.0,
) -> Draw:
    """A parameter of the bench, which is ``value`` of the signed strength.

    The model's parameter of this effect is ``value`` minus ``less``.
    """

    def draw(rng: np.random.Generator) -> HiddenEffect[ReferenceBench]:
        sign = rng.choice([-1.0, 1.0]) if signed else 1.0

        def apply(bench: ReferenceBench, strength: float) -> ReferenceBench:
            given: dict[str, Any] = {attribute: value(sign * strength)}
            return dataclasses.replace(bench, **given)

        return HiddenEffect(
            name=name,
            apply=apply,
            parameters=lambda _, s: {parameter: value(sign * s) - less},
            high=high,
        )

    return draw


def _static_friction(rng: np.random.Generator) -> HiddenEffect[ReferenceBench]:
    def apply(bench: ReferenceBench, strength: float) -> ReferenceBench:
        return dataclasses.replace(bench, static_excess=strength)

    return HiddenEffect(
        name="static_friction",
        apply=apply,
        parameters=lambda bench, s: {"sheath.static_friction": bench.friction * (1.0 + s)},
        high=1.5,
    )


def _thermal_shortening(rng: np.random.Generator) -> HiddenEffect[ReferenceBench]:
    period = rng.uniform(5.0, 20.0)

    def apply(bench: ReferenceBench, strength: float) -> ReferenceBench:
        return dataclasses.replace(bench, thermal_shortening=(strength, period))

    return HiddenEffect(
        name="warmth",
        apply=apply,
        parameters=lambda _, s: {"amplitude_m": s, "period_s": period},
        high=0.5e-3,
    )


def _saturation(rng: np.random.Generator) -> HiddenEffect[ReferenceBench]:
    column = str(rng.choice(COLUMNS))

    def apply(bench: ReferenceBench, strength: float) -> ReferenceBench:
        limit = bench.pretension * (3.0 - strength)
        return dataclasses.replace(bench, sensors={**bench.sensors, column: Sensor(limit=limit)})

    return HiddenEffect(
        name="sensor_saturation",
        apply=apply,
        parameters=lambda _, s: {"below_3_T_0": s},
        high=1.9,
    )


# Each with the largest strength that is still physical, in the unit beside it.
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
# Friction as the hidden effect: the model and its recordings state none.
SHEATH_FRICTION = _parameter(
    "sheath_friction", "friction", "sheath.friction", lambda s: s, 0.4, signed=False
)
# Wrong parameters of the model, which the recording states neither as known nor as uncertain.
PARAMETERS: dict[str, Draw] = {
    "friction": _parameter(
        "friction", "friction", "sheath.friction", lambda s: 0.15 * (1.0 + s), 0.8
    ),
    "axial_stiffness": _parameter(
        "axial_stiffness", "axial_stiffness", "sheath.axial_stiffness", lambda s: 2e4 * (1 + s), 0.6
    ),
    "pretension": _parameter(
        "pretension", "pretension", "sheath.pretension", lambda s: 20.0 * (1.0 + s), 0.6
    ),
    "bend_angle": _parameter(
        "bend_angle", "bend", "sheath.extra_bend", lambda s: np.pi * (1.0 + s), 0.5, less=np.pi
    ),
    "moment_arm": _parameter(
        "moment_arm", "reel_scale", "reel.command_scale", lambda s: 1.0 + s, 0.25
    ),
}
# Disturbances that no catalogue of a diagnosis contains.
DISTURBANCES: dict[str, Draw] = {
    "sensor_hum": _sensor("sensor_hum", "hum", 5.0),  # N
    "warmth": _thermal_shortening,  # 0.5e-3 m
    "sensor_saturation": _saturation,  # 1.9 [-], of T_0
}
# Groups of effects of which one can imitate the other.
INTERCHANGEABLE = ({"sensor_delay", "sensor_lag"}, {"sensor_bias", "sensor_gain"})
# Effects that some cases take out of the catalogue, so that the diagnosis has to abstain.
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
