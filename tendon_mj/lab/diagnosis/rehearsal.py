"""Rehearsal: a rig's own motions, simulated with an effect whose size is known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tendon_mj.errors import InvalidValueError, RecordingError, UnknownNameError
from tendon_mj.lab.diagnosis.data import Problem, all_samples, describe_system
from tendon_mj.lab.diagnosis.effects import CATALOGUE
from tendon_mj.lab.diagnosis.effects.effect import Effect, SystemDescription
from tendon_mj.lab.noise import noise_levels
from tendon_mj.lab.parameter_names import parameter_of
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Simulator, as_recording, described_values


def rehearse(
    recordings: Sequence[Recording], effects: Mapping[str, float], seed: int = 0
) -> tuple[list[Recording], dict[str, float]]:
    """Simulate the measured columns of recordings, with effects and with noise.

    Only the driven columns of the recordings count, and the noise that they state; without one it
    is estimated from what was measured.

    Args:
        recordings: of one model.
        effects: identifier of an effect of the catalogue, or parameter → value of its strength [SI
            unit of the parameter].
        seed: of the noise.

    Returns:
        The recordings with simulated readings, and the parameters that were set.

    Raises:
        InvalidValueError: an effect without a place on the rig, with several, or that is an event.
        RecordingError: a column whose noise is neither stated nor can be estimated.
        UnknownNameError: neither an effect nor a parameter.
    """
    simulator = Simulator(recordings, strict=True)
    problem = Problem(tuple(recordings), simulator, all_samples(recordings))
    system = describe_system(problem)
    values: dict[str, float] = {}
    for name, value in effects.items():
        if effect := CATALOGUE.get(name):
            values = _strength(effect, value, system) | values
        elif parameter_of(name) in simulator.parameters:
            values |= {name: value}
        else:
            names = {*CATALOGUE, *simulator.parameters}
            raise UnknownNameError("effect or parameter", name, names)
    (answers,), random = simulator([values]), np.random.default_rng(seed)
    made = []
    for recording, series in zip(recordings, answers, strict=True):
        stated = described_values(recording, simulator.parameters) | values
        simulated = as_recording(recording, series, stated)
        columns, levels = dict(recording.columns), noise_levels(recording)
        for column, measured in recording.measured.items():
            if measured.noise is None and not np.ptp(recording.columns[column]):
                raise RecordingError(
                    f"recording {recording.name!r}, [measured] {recording.written(column)!r}: its"
                    " noise is unknown; state noise = …, its standard deviation at rest"
                )
            noise = random.normal(0.0, levels[column], recording.time.size)
            columns[column] = simulated.columns[column] + noise
        listed = ", ".join(f"{name} = {value:g}" for name, value in values.items()) or "nothing"
        source = f"{simulated.source}; rehearsed with {listed}"
        made.append(replace(recording, columns=columns, source=source))
    return made, values


def _strength(effect: Effect, value: float, system: SystemDescription) -> dict[str, float]:
    """Parameter → value of an effect at its one place, or on all elements that it can share."""
    bound = effect.binding(system)
    every = {target for _, terms in bound for target in terms[0].targets}
    terms = next((terms for _, terms in bound if {*terms[0].targets} == every), ())
    if effect.event or not terms:
        places = ", ".join(sorted(every)) or "none on this rig"
        raise InvalidValueError(
            f"effect {effect.identifier!r}: its parameter has to be named; possible: {places}"
        )
    shape = {target: term.starts[0] for term in terms[1:] if term.starts for target in term.targets}
    return shape | dict.fromkeys(terms[0].targets, value)
