"""Effects, wrong parameters and disturbances that can be hidden in bench and joint."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np

from experiments.hidden_effects.excitation import DURATION, Sensor
from experiments.hidden_effects.references import COLUMNS, ReferenceBench, ReferenceJoint
from tendon_mj.models import Joint

R = TypeVar("R")
Parameters = dict[str, float]
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
# Effects that scale the friction, and so leave nothing where the model and the reference have none.
OF_FRICTION = ("direction_asymmetry", "position_dependent_friction", "friction_drift")


@dataclass(frozen=True, kw_only=True)
class HiddenEffect(Generic[R]):
    """Change of a reference of type ``R``, with every number drawn but its strength.

    Attributes:
        name: identifier of the effect, parameter or disturbance.
        apply: (reference, strength > 0) → reference with the effect.
        parameters: (true reference, strength) → true values of the model's parameters.
        high: largest strength that is physical.
        usual: range of strengths of rigs, from which those of kind "drawn" are drawn.
    """

    name: str
    apply: Callable[[R, float], R]
    parameters: Callable[[R, float], dict[str, float]]
    high: float
    usual: tuple[float, float] = (0.0, 0.0)

    @property
    def low(self) -> float:
        """Smallest strength that the search considers."""
        return 1e-4 * self.high

    @property
    def start(self) -> float:
        """Strength at which the search begins."""
        return 0.1 * self.high


Draw = Callable[[np.random.Generator], HiddenEffect[ReferenceBench]]


def on_transmission(
    name: str, attribute: str, high: float, *, signed: bool = False, **second: tuple[float, float]
) -> Draw:
    """An effect of `experiments.references.Effects`; ``second`` is a further attribute's range."""

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


def on_sensor(
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


def on_attribute(
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


def _gear(rng: np.random.Generator) -> HiddenEffect[ReferenceBench]:
    column, at_rest = COLUMNS[0], rng.choice([-1.0, 0.0, np.nan])

    def apply(bench: ReferenceBench, strength: float) -> ReferenceBench:
        geared = dataclasses.replace(
            bench.sensors.get(column, Sensor()),
            efficiency=1.0 - strength,
            at_rest=None if np.isnan(at_rest) else float(at_rest),
        )
        return dataclasses.replace(bench, sensors={**bench.sensors, column: geared})

    return HiddenEffect(
        name="gear_efficiency",
        apply=apply,
        parameters=lambda _, s: {f"{column.removesuffix('_N')}.efficiency": 1.0 - s},
        high=0.5,
        usual=(0.1, 0.25),
    )


def _slip(rng: np.random.Generator) -> HiddenEffect[ReferenceBench]:
    recording, sign = int(rng.integers(2)), float(rng.choice([-1.0, 1.0]))
    when = float(rng.uniform(0.15, 0.85) * 0.5 * DURATION)
    duration = float(np.exp(rng.uniform(*np.log([0.005, 0.05]))))

    def apply(bench: ReferenceBench, strength: float) -> ReferenceBench:
        return dataclasses.replace(bench, slip=(recording, sign * strength, when, duration))

    where = f"train_{recording + 1}"
    return HiddenEffect(
        name="slip",
        apply=apply,
        parameters=lambda _, s: {
            f"reel.slip @ {where}": sign * s,
            f"reel.slip_time @ {where}": when,
        },
        high=2e-3,
        usual=(0.1e-3, 1e-3),
    )


# Those of kind "drawn", whose strength is as on a rig.
DRAWN: dict[str, Draw] = {"gear_efficiency": _gear, "slip": _slip}
# Each with the largest strength that is still physical, in the unit beside it.
EFFECTS: dict[str, Draw] = {
    "static_friction": _static_friction,  # 0.5 [-], μ_s/μ − 1
    "velocity_weakening": on_transmission(
        "velocity_weakening", "stribeck_friction", 0.3, stribeck_velocity=(1e-3, 10e-3)
    ),  # [-]; [m/s]
    "viscous_friction": on_transmission("viscous_friction", "viscous_friction", 1000.0),  # N s/m
    "constant_friction": on_transmission("constant_friction", "constant_friction", 10.0),  # N
    "direction_asymmetry": on_transmission(
        "direction_asymmetry", "direction_asymmetry", 0.8, signed=True
    ),  # [-]
    "position_dependent_friction": on_transmission(
        "position_dependent_friction", "friction_gradient", 700.0, signed=True
    ),  # 1/m
    "friction_drift": on_transmission("friction_drift", "friction_drift", 0.12, signed=True),  # 1/s
    "backlash": on_transmission("backlash", "backlash", 0.8e-3),  # m
    "stiffening": on_transmission("stiffening", "stiffening", 500.0),  # [-]
    "creep": on_transmission("creep", "creep", 2.0, creep_time=(0.2, 3.0)),  # [-]; [s]
    "sheath_compliance": on_transmission("sheath_compliance", "sheath_compliance", 1e-4),  # m/N
    "tendon_inertia": on_transmission("tendon_inertia", "tendon_mass", 1.0),  # kg
    "sensor_bias": on_sensor("sensor_bias", "bias", 5.0, signed=True, parameter="offset"),  # N
    "sensor_gain": on_sensor("sensor_gain", "gain", 0.3, signed=True, parameter="scale"),  # [-]
    "sensor_delay": on_sensor("sensor_delay", "delay", 0.1),  # s
    "sensor_lag": on_sensor("sensor_lag", "lag", 0.1),  # s
    "sensor_drift": on_sensor("sensor_drift", "drift", 1.0, signed=True),  # N/s
}
# Friction as the hidden effect: the model and its recordings state none.
SHEATH_FRICTION = on_attribute(
    "sheath_friction", "friction", "sheath.friction", lambda s: s, 0.4, signed=False
)


def with_imitators(effect: str) -> set[str]:
    """The effect and all that can imitate it."""
    return {effect}.union(*(group for group in INTERCHANGEABLE if effect in group))


def _parameter(
    name: str, attribute: str, parameter: str, start: float, high: float, sign: float = 1.0
) -> Callable[[np.random.Generator], HiddenEffect[ReferenceJoint]]:
    """Effect that raises an attribute of the reference from ``start`` by its strength."""

    def draw(_: np.random.Generator) -> HiddenEffect[ReferenceJoint]:
        return HiddenEffect(
            name=name,
            apply=lambda joint, s: dataclasses.replace(joint, **{attribute: start + s}),
            parameters=lambda _, s: {parameter: start + sign * s},
            high=high,
        )

    return draw


JOINT_EFFECTS: Mapping[str, Callable[[np.random.Generator], HiddenEffect[ReferenceJoint]]] = {
    "joint_damping": _parameter("joint_damping", "damping", "joint.damping", Joint.damping, 0.02),
    "joint_friction": _parameter("joint_friction", "dry_friction", "joint.frictionloss", 0.0, 0.02),
    "joint_stiffness": _parameter(
        "joint_stiffness", "stiffness", "joint.stiffness", Joint.stiffness, 0.06
    ),
    "gravity_load": _parameter("gravity_load", "gravity", "gravity.z", 0.0, 9.81, sign=-1.0),
}  # N m s/rad, N m, N m/rad, m/s²


# Wrong parameters of the model, which the recording states neither as known nor as uncertain.
PARAMETERS: dict[str, Draw] = {
    "friction": on_attribute(
        "friction", "friction", "sheath.friction", lambda s: 0.15 * (1.0 + s), 0.8
    ),
    "axial_stiffness": on_attribute(
        "axial_stiffness", "axial_stiffness", "sheath.axial_stiffness", lambda s: 2e4 * (1 + s), 0.6
    ),
    "pretension": on_attribute(
        "pretension", "pretension", "sheath.pretension", lambda s: 20.0 * (1.0 + s), 0.6
    ),
    "bend_angle": on_attribute(
        "bend_angle", "bend", "sheath.extra_bend", lambda s: np.pi * (1.0 + s), 0.5, less=np.pi
    ),
    "moment_arm": on_attribute(
        "moment_arm", "reel_scale", "reel.command_scale", lambda s: 1.0 + s, 0.25
    ),
}


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
        limited = dataclasses.replace(bench.sensors.get(column, Sensor()), limit=limit)
        return dataclasses.replace(bench, sensors={**bench.sensors, column: limited})

    return HiddenEffect(
        name="sensor_saturation",
        apply=apply,
        parameters=lambda _, s: {"below_3_T_0": s},
        high=1.9,
    )


DISTURBANCES: dict[str, Draw] = {
    "sensor_hum": on_sensor("sensor_hum", "hum", 5.0),  # N
    "warmth": _thermal_shortening,  # 0.5e-3 m
    "sensor_saturation": _saturation,  # 1.9 [-], of T_0
}
