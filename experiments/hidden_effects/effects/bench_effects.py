"""Effects that can be hidden in the bench, each with its largest strength."""

from __future__ import annotations

import dataclasses

import numpy as np

from experiments.hidden_effects.effects.draws import (
    Draw,
    on_attribute,
    on_sensor,
    on_transmission,
)
from experiments.hidden_effects.effects.hidden_effect import HiddenEffect
from experiments.hidden_effects.references.bench import COLUMNS, ReferenceBench
from experiments.hidden_effects.references.excitation import DURATION
from experiments.hidden_effects.references.sensor import Sensor


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


def with_imitators(effect: str) -> set[str]:
    """The effect and all that can imitate it."""
    return {effect}.union(*(group for group in INTERCHANGEABLE if effect in group))
