"""Sheaths whose guides are too few for the data, and how many would do."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import mujoco
import numpy as np

from tendon_mj.attach import view_sheath
from tendon_mj.diagnosis.data.problem import Problem
from tendon_mj.replay.grouped_names import expand
from tendon_mj.replay.parameters import Adjustable
from tendon_mj.replay.session_names import values_for
from tendon_mj.replay.simulator import Simulator
from tendon_mj.replay.units import column_unit

# Root mean square error of a tension, in ranges of it, over the square of μφ at one guide. Measured
# on `bench` against 96 guides and the reference: 0.2 … 0.6 at its input, 0.5 over both ends.
_ERROR = 0.5


class LumpedSheath(NamedTuple):
    """A sheath in few guides.

    Attributes:
        name: of the sheath.
        guides: that it has.
        error: that lumping it into these leaves, about [noise].
        enough: guides with which about as much as the noise would be left.
    """

    name: str
    guides: int
    error: float
    enough: int


def too_few_guides(problem: Problem, values: Mapping[str, float]) -> list[LumpedSheath]:
    """Sheaths whose lumping leaves more than noise, about 0.5 (μφ/n)² of a tension's range.

    Args:
        problem: data; a simulator other than the package's has no guides.
        values: parameter → value of the model; ``<parameter> @ <recording>`` for one alone.
    """
    if not isinstance(problem.simulate, Simulator):
        return []
    tensions = [
        float(np.ptp(recording.columns[column])) / noise
        for recording, noises in zip(problem.recordings, problem.noise, strict=True)
        for column, noise in noises.items()
        if column_unit(column) == "N"
    ]
    finest = max(tensions, default=0.0)
    most: dict[str, LumpedSheath] = {}
    for name, guides, exponent in _exponents(problem.simulate, values):
        error = _ERROR * (exponent / guides) ** 2 * finest
        if error > 1.0 and (name not in most or error > most[name].error):
            most[name] = LumpedSheath(name, guides, error, math.ceil(guides * math.sqrt(error)))
    return list(most.values())


def _exponents(
    simulator: Simulator, values: Mapping[str, float]
) -> Iterator[tuple[str, int, float]]:
    """Sheath, its guides, and its μφ, at the start of every recording."""
    for recording in simulator.recordings:
        adjustable = Adjustable(copy.copy(simulator.model))
        known = expand(recording.known, simulator.parameters)
        adjustable.set({**values_for(recording.name, values), **known})
        model, data = adjustable.model, adjustable.data
        mujoco.mj_forward(model, data)
        for name in simulator.sheaths:
            view = view_sheath(model, data, name)
            bend = view.bend_angle
            total = float(bend.sum() + view.extra_bend)
            yield name, max(bend.size, 1), view.friction * total


def warn_of_guides(sheaths: Sequence[LumpedSheath]) -> str:
    """Say of sheaths how much their lumping leaves, and how many guides would do."""
    return "".join(
        f" The {sheath.guides} guides of {sheath.name!r} leave about {sheath.error:.1f} times the"
        f" noise where a smooth sheath leaves none; {sheath.enough} would leave about the noise."
        for sheath in sheaths
    )
