"""Disturbances that no catalogue of a diagnosis contains."""

from __future__ import annotations

import dataclasses

import numpy as np

from experiments.hidden_effects.effects.draws import Draw, on_sensor
from experiments.hidden_effects.effects.hidden_effect import HiddenEffect
from experiments.hidden_effects.references.bench import COLUMNS, ReferenceBench
from experiments.hidden_effects.references.sensor import Sensor


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
