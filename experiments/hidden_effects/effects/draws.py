"""Draws of effects on the bench: every number but the strength, from a random generator."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np

from experiments.hidden_effects.effects.hidden_effect import HiddenEffect
from experiments.hidden_effects.references.bench import COLUMNS, ReferenceBench
from experiments.hidden_effects.references.sensor import Sensor

Parameters = dict[str, float]
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
