"""A rig without physics: what it measures is a sum of known waveforms, one for each parameter.

It stands in for a simulator, as a user's own would, and makes every answer computable by hand.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tendon_mj.lab.diagnosis import MakeSimulator, Problem, SystemDescription, all_samples
from tendon_mj.lab.recordings import Recording, Uncertain
from tendon_mj.lab.replay import Parameter, Simulates
from tendon_mj.typing import FloatArray
from tests.lab.recorded import recorded

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


class Added(Simulates):
    """Simulator of a rig that adds the waveforms of its parameters, without joints or steps."""

    rest = 0.0  # of every column

    def __init__(self, recordings: Sequence[Recording], values: Mapping[str, float]) -> None:
        self.recordings = list(recordings)
        self.parameters = {name: Parameter(value, "SI", "live") for name, value in values.items()}

    def __call__(
        self, parameter_sets: Sequence[Mapping[str, float]]
    ) -> list[list[dict[str, FloatArray]]]:
        return [[self._one(s, r) for r in self.recordings] for s in parameter_sets]

    def _one(self, changed: Mapping[str, float], recording: Recording) -> dict[str, FloatArray]:
        values = {**{name: p.value for name, p in self.parameters.items()}, **changed}
        acting = {name: value for name, value in values.items() if value != 0.0}
        series = {}
        for column in recording.measured:
            series[column] = np.full(recording.time.size, self.rest)
            for name, value in acting.items():
                series[column] += value * self.waveform(name, column, recording)
        return series

    def waveform(self, parameter: str, column: str, recording: Recording) -> FloatArray:
        """(n,) reading that a parameter of 1 adds to a column."""
        raise NotImplementedError


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


class Toy(Added):
    """Simulator of the toy rig."""

    rest = 20.0  # [N]

    def __init__(self, recordings: Sequence[Recording]) -> None:
        super().__init__(recordings, {name: value for name, (value, _) in WEIGHTS.items()})

    def waveform(self, parameter: str, column: str, recording: Recording) -> FloatArray:
        share = WEIGHTS[parameter][1][list(COLUMNS).index(column)]
        return share * waveform(parameter, recording)


def recording(
    name: str, seed: int, truth: Mapping[str, float], extra: float = 0.0, noise: float = NOISE
) -> Recording:
    """Six seconds of the rig with ``truth``; ``extra`` adds what no parameter explains [N]."""
    random = np.random.default_rng(seed)
    time = np.arange(0.0, 6.0, 0.01)
    place = 1e-3 * np.sin(2.0 * np.pi * random.uniform(0.3, 0.5) * time + random.uniform(0.0, 6.0))

    uncertain = {"sheath.friction": Uncertain(0.15, 0.05, 0.4)}
    blank = bench_recording(name, time, place, noise, list(COLUMNS), uncertain=uncertain)
    series = Toy([blank])([truth])[0][0]
    strange = extra * np.sin(2.0 * np.pi * 7.3 * time)
    noisy = {c: s + strange + random.normal(0.0, noise, time.size) for c, s in series.items()}
    return replace(blank, columns={**blank.columns, **noisy})


def rig(
    seed: int, truth: Mapping[str, float], extra: float = 0.0
) -> tuple[list[Recording], list[Recording]]:
    """Three recordings to learn from and two for the proof."""
    made = [recording(f"r{k}", 10 * seed + k, truth, extra) for k in range(5)]
    return made[:3], made[3:]


class Stepped(Toy):
    """The toy rig with an error, proportional to its step, that looks like less friction."""

    steps = 1000

    def __init__(
        self, recordings: Sequence[Recording], step: float = 1.0, error: float = 0.01
    ) -> None:
        super().__init__(recordings)
        self.step, self.error, self.steps = step, error, round(1000.0 / step)

    def in_steps(self, factor: float) -> Stepped:
        return type(self)(self.recordings, factor * self.step, self.error)

    def _one(self, changed: Mapping[str, float], recording: Recording) -> dict[str, FloatArray]:
        friction = changed.get("sheath.friction", 0.15)
        error = -self.error * self.step * friction * waveform("sheath.friction", recording)
        shares = WEIGHTS["sheath.friction"][1]
        series = super()._one(changed, recording)
        return {c: s + w * error for (c, s), w in zip(series.items(), shares, strict=True)}


def ringing(
    series: Mapping[str, FloatArray], changed: Mapping[str, float], size: float
) -> dict[str, FloatArray]:
    """Series of a simulation that rings: rounding of the changed values moves samples by a size."""
    random = np.random.default_rng(abs(hash(tuple(changed.values()))))
    return {c: s + random.normal(0.0, size, s.size) for c, s in series.items()}


def measured_by(
    make: MakeSimulator, blank: Recording, truth: Mapping[str, float], random: np.random.Generator
) -> Recording:
    """A recording as a rig with ``truth`` measures it, with the noise that it states."""
    (series,) = make([blank])([truth])[0]
    noisy = {
        c: s + random.normal(0.0, blank.measured[c].noise or 0.0, s.size) for c, s in series.items()
    }
    return replace(blank, columns={**blank.columns, **noisy})


def bench_recording(
    name: str,
    time: FloatArray,
    drive: FloatArray,
    noise: float,
    columns: Sequence[str],
    **more: object,
) -> Recording:
    """The model `bench` driven at its reel, with nothing measured yet."""
    return recorded(
        time,
        {"input_displacement_m": ("reel", drive)},
        {c: (c.removesuffix("_N"), noise) for c in columns},
        name=name,
        **more,
    )


def problem_of(make: MakeSimulator, recordings: Sequence[Recording]) -> Problem:
    """All samples of recordings, and a simulator of them."""
    return Problem(tuple(recordings), make(recordings), all_samples(recordings))


def system(values: Mapping[str, float], **more: object) -> SystemDescription:
    """Description of a model with these parameters, of which nothing is known or uncertain."""
    nothing = {"known": frozenset(), "uncertain": frozenset(), "spans": {}}
    bare = {**nothing, "inputs": (), "free_joints": ()}
    return SystemDescription(values, **{**bare, **more})  # type: ignore[arg-type]
