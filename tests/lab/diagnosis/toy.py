"""A rig without physics: what it measures is a sum of known waveforms, one for each parameter.

It stands in for a simulator, as a user's own would, and makes every answer computable by hand.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

import numpy as np
import pytest

from tendon_mj.lab.recordings import Measured, Recording, Uncertain
from tendon_mj.lab.replay import Parameter, Simulates
from tendon_mj.typing import FloatArray

NOISE = 0.05
COLUMNS = {"input_tension_N": "input_tension", "output_tension_N": "output_tension"}
# parameter → value of the model, and shares of its waveform in the two tensions
WEIGHTS = {
    "sheath.friction": (0.15, (40.0, -30.0)),
    "sheath.constant_friction": (0.0, (1.0, -0.6)),
    "sheath.backlash": (0.0, (4e4, 3e4)),
    "sheath.direction_asymmetry": (0.0, (8.0, 5.0)),
    "sheath.friction_drift": (0.0, (20.0, -20.0)),
    "output_tension.offset": (0.0, (0.0, 1.0)),
}


def waveform(parameter: str, recording: Recording) -> FloatArray:
    """Shape of a parameter's influence on a recording: smooth, and unlike any other's."""
    place = recording.columns["input_displacement_m"] / 1e-3
    time = recording.time
    if parameter.endswith("offset"):
        return np.ones(time.size)
    if parameter.endswith("drift"):
        return place * time / 6.0
    order = list(WEIGHTS).index(parameter)
    return np.sin((order + 1.0) * place + 0.3 * order)


class Toy(Simulates):
    """Simulator of the toy rig, which knows neither joints nor steps."""

    def __init__(self, recordings: Sequence[Recording]) -> None:
        self.recordings = list(recordings)
        self.calls = 0
        self.parameters = {name: Parameter(v, "SI", "live") for name, (v, _) in WEIGHTS.items()}

    def __call__(
        self, parameter_sets: Sequence[Mapping[str, float]]
    ) -> list[list[dict[str, FloatArray]]]:
        """Series for every set and recording."""
        self.calls += len(parameter_sets)
        return [[self._one(s, r) for r in self.recordings] for s in parameter_sets]

    def _one(self, changed: Mapping[str, float], recording: Recording) -> dict[str, FloatArray]:
        values = {**{name: value for name, (value, _) in WEIGHTS.items()}, **changed}
        series = {}
        for k, column in enumerate(COLUMNS):
            series[column] = 20.0 + sum(
                value * WEIGHTS[name][1][k] * waveform(name, recording)
                for name, value in values.items()
            )
        return series


def recording(
    name: str, seed: int, truth: Mapping[str, float], extra: float = 0.0, noise: float = NOISE
) -> Recording:
    """Six seconds of the rig with ``truth``; ``extra`` adds what no parameter explains [N]."""
    random = np.random.default_rng(seed)
    time = np.arange(0.0, 6.0, 0.01)
    place = 1e-3 * np.sin(2.0 * np.pi * random.uniform(0.3, 0.5) * time + random.uniform(0.0, 6.0))

    def made(columns: Mapping[str, FloatArray]) -> Recording:
        return Recording(
            name=name,
            model="bench",
            source="toy",
            time=time,
            columns={"input_displacement_m": place, **columns},
            drive={"input_displacement_m": "reel"},
            measured={c: Measured(s, noise) for c, s in COLUMNS.items()},
            uncertain={"sheath.friction": Uncertain(0.15, 0.05, 0.4)},
        )

    blank = made({column: np.zeros(time.size) for column in COLUMNS})
    series = Toy([blank])([truth])[0][0]
    strange = extra * np.sin(2.0 * np.pi * 7.3 * time)
    return made({c: s + strange + random.normal(0.0, noise, time.size) for c, s in series.items()})


def rig(
    seed: int, truth: Mapping[str, float], extra: float = 0.0
) -> tuple[list[Recording], list[Recording]]:
    """Three recordings to learn from and two for the proof."""
    made = [recording(f"r{k}", 10 * seed + k, truth, extra) for k in range(5)]
    return made[:3], made[3:]


@contextmanager
def refused(error: type[Exception], *facts: str) -> Iterator[None]:
    """Expect an error whose message contains the facts."""
    with pytest.raises(error) as refusal:
        yield
    for fact in facts:
        assert fact in str(refusal.value)
