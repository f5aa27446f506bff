"""Changes of a rig over time, to first order.

A number x that is x_0 before a day and x_0 + δ after it (a step), or grows from that day on to
x_0 + δ on the last (a ramp), or is x_0 + δ between two days (there and back), changes the residual
of recording k by J_k δ w_k with w_k in 0…1.
With A_k and b_k of `Observation`, and everything shared fitted beside it, the best δ and the χ²
that it explains are

    δ = −β/α,   gain = β²/α,   α = Σ w_k² A_k − c C⁻¹ cᵀ,   β = Σ w_k b_k − c C⁻¹ Σ b_k,

where C = Σ A_k of what is shared and c = Σ w_k A_k of the number with it.

How much a number differs from day to day where nothing changed, its reproducibility, is estimated
from the differences between successive days of all rigs (their median is blind to a few changes).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import combinations
from typing import Literal

import numpy as np

from tendon_mj.lab.fleet.number import Label
from tendon_mj.lab.fleet.observation import SINGULAR, Observation, inverse
from tendon_mj.typing import FloatArray

Course = Literal["step", "ramp", "there and back"]

SIGNIFICANT = 5.0  # standard deviations; among 10⁴ numbers and days one of 4.5 is to be expected
LEAST_DAYS = 2  # recordings on either side of a change
_GAUSS = 0.6744897501960817  # median |x| of a standard normal variable
_NEAR = 0.6  # of the best gain, for a number to be looked at more closely
_MOST = 6  # numbers looked at more closely


@dataclass(frozen=True)
class Template:
    """A course of a change: its kind, the recording at which it begins, and the share w_k there."""

    course: Course
    first: int
    weights: FloatArray


@dataclass(frozen=True)
class Suspect:
    """A number that may have changed.

    Attributes:
        index: of the watched number.
        template: course that explains most.
        change: δ [probes].
        gain: of χ² [noise²].
        significance: change over what is to be expected from its reproducibility [-].
    """

    index: int
    template: Template
    change: float
    gain: float
    significance: float


def templates(dates: Sequence[datetime]) -> list[Template]:
    """Every course of a lasting change with enough recordings on either side of its beginning."""
    seconds = np.array([(date - dates[0]).total_seconds() for date in dates])
    found = list[Template]()
    for k in range(LEAST_DAYS, len(dates) - LEAST_DAYS + 1):
        found.append(Template("step", k, (np.arange(len(dates)) >= k).astype(float)))
        before = k - 1  # the last without a change
        if k < len(dates) - LEAST_DAYS and seconds[-1] > seconds[before]:
            share = (seconds - seconds[before]) / (seconds[-1] - seconds[before])
            found.append(Template("ramp", k, np.clip(share, 0.0, 1.0)))
    return found


def excursions(dates: Sequence[datetime]) -> list[Template]:
    """Every change that is undone later, with enough recordings before, between and after."""
    steps = [template for template in templates(dates) if template.course == "step"]
    return [
        Template("there and back", one.first, one.weights - other.weights)
        for one, other in combinations(steps, 2)
        if other.first - one.first >= LEAST_DAYS
    ]


def daily(observation: Observation) -> FloatArray:
    """(n, w) change of each number that would explain a recording by itself best [probes]."""
    diagonal = np.einsum("kii->ki", observation.normal)
    with np.errstate(divide="ignore", invalid="ignore"):
        found: FloatArray = -observation.gradient / diagonal
    return np.where(diagonal > 0.0, found, np.nan)


def reproducibility(observations: Sequence[Observation]) -> dict[Label, float]:
    """Number → standard deviation from day to day [its unit], of all rigs together."""
    differences: dict[Label, list[FloatArray]] = {}
    floors: dict[Label, list[float]] = {}
    for one in observations:
        probes = np.array([number.probe for number in one.numbers])
        steps = probes * np.diff(daily(one), axis=0) / np.sqrt(2.0)
        information = np.einsum("kii->ki", one.normal)
        noise = np.sqrt(np.maximum(one.square, 1.0))[:, None]
        with np.errstate(divide="ignore"):
            floor = probes * np.median(noise / np.sqrt(information), axis=0)
        for k, number in enumerate(one.numbers):
            differences.setdefault(number.label, []).append(steps[:, k])
            floors.setdefault(number.label, []).append(float(floor[k]))
    found = {}
    for label, parts in differences.items():
        every = np.concatenate(parts)
        every = np.abs(every[np.isfinite(every)])
        spread = float(np.median(every)) / _GAUSS if every.size else np.inf
        found[label] = max(spread, float(np.median(floors[label])))
    return found


def suspects(
    observation: Observation, dates: Sequence[datetime], spreads: Mapping[Label, float]
) -> list[Suspect]:
    """Numbers that may have changed, those that explain most first; none where nothing did.

    A change that is undone later is sought where no lasting one stands out.
    """
    return _standing_out(observation, templates(dates), spreads) or _standing_out(
        observation, excursions(dates), spreads
    )


def _standing_out(
    observation: Observation, courses: Sequence[Template], spreads: Mapping[Label, float]
) -> list[Suspect]:
    best = dict[int, Suspect]()
    for template in courses:
        change, gain = _explained(observation, template.weights)
        lever = float(np.sqrt(((template.weights - template.weights.mean()) ** 2).sum()))
        for k, number in enumerate(observation.numbers):
            if k not in best or gain[k] > best[k].gain:
                significance = float(abs(change[k])) * number.probe * lever / spreads[number.label]
                best[k] = Suspect(k, template, float(change[k]), float(gain[k]), significance)
    ranked = sorted(best.values(), key=lambda s: -s.gain)
    if not ranked or ranked[0].significance < SIGNIFICANT:
        return []
    near = [s for s in ranked if s.gain >= _NEAR * ranked[0].gain]
    return _one_each(observation, near)[:_MOST]


def _one_each(observation: Observation, ranked: Sequence[Suspect]) -> list[Suspect]:
    """The first of each name: an effect has a number for each of its shapes."""
    found: dict[tuple[str, str], Suspect] = {}
    for suspect in ranked:
        found.setdefault(observation.numbers[suspect.index].key, suspect)
    return list(found.values())


def _explained(observation: Observation, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(w,) best changes [probes] and their gains [noise²] for a course (n,)."""
    normal, gradient, count = observation.normal, observation.gradient, observation.shared
    shared = slice(0, count)
    of_shared = inverse(normal[:, shared, shared].sum(axis=0))
    cross = np.einsum("k,kws->ws", weights, normal[:, :, shared])
    alone = np.einsum("k,kww->w", weights**2, normal)
    alpha = alone - np.einsum("ws,st,wt->w", cross, of_shared, cross)
    beta = weights @ gradient - cross @ of_shared @ gradient[:, shared].sum(axis=0)
    solid = alpha > SINGULAR * alone
    with np.errstate(divide="ignore", invalid="ignore"):
        change = np.where(solid, -beta / alpha, 0.0)
        gain = np.where(solid, beta**2 / alpha, 0.0)
    return change, gain
