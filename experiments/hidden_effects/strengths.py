"""Strengths of hidden effects, found on the training recordings: residuals in units of noise."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Generic

import numpy as np

from experiments.hidden_effects.draws import CaseDraw
from experiments.hidden_effects.hidden import HiddenEffect
from experiments.hidden_effects.plan import CasePlan
from experiments.hidden_effects.references import R
from tendon_mj.typing import FloatArray

TOLERANCE = 0.05  # relative, of the ratio at which the search ends
MAX_EVALUATIONS = 10
PERTURBATION = 1.01  # factor on a parameter, to find the sensitivity of the readings to it
SMALL = (1.0, 4.0)  # of each effect that leaves the remainder, once calibrated [noise]


@dataclass(frozen=True)
class FoundStrength:
    """Result of a search.

    Attributes:
        strength: of the effect, in its own unit.
        ratio: of residual to noise at this strength [-].
        reached: whether the ratio is within about 10 % of its target.
    """

    strength: float
    ratio: float
    reached: bool


def calibration_projector(
    sensitivities: list[FloatArray],
) -> Callable[[FloatArray], FloatArray]:
    """Projector onto the residuals that a linear calibration of parameters cannot remove.

    Args:
        sensitivities: of the whitened signal, (samples,) for each calibrated parameter.

    Returns:
        Function of a whitened residual r: r − Q Qᵀ r, with Q a basis of the sensitivities.
    """
    if not sensitivities:
        return lambda residual: residual
    basis, _ = np.linalg.qr(np.stack(sensitivities, axis=1))
    return lambda residual: residual - basis @ (basis.T @ residual)


def find_strength(
    ratio: Callable[[float], float], target: float, low: float, high: float, start: float
) -> FoundStrength:
    """Find a strength by the secant method in log ratio over log strength.

    Args:
        ratio: of residual to noise, increasing in the strength.
        target: wanted ratio [-].
        low: smallest strength.
        high: largest strength.
        start: strength of the first evaluation.

    Returns:
        The best strength evaluated, which need not reach the target. Steps stay inside the
        bracket of earlier evaluations.
    """
    below, above = math.log(low), math.log(high)
    at = min(max(math.log(start), below), above)
    points: list[tuple[float, float]] = []
    best = FoundStrength(start, 0.0, False)
    for _ in range(MAX_EVALUATIONS):
        value = ratio(math.exp(at))
        miss = math.log(max(value, 1e-12) / target)
        if not points or abs(miss) < abs(math.log(max(best.ratio, 1e-12) / target)):
            best = FoundStrength(math.exp(at), value, False)
        if abs(miss) <= math.log1p(TOLERANCE):
            break
        points.append((at, miss))
        if miss < 0.0:
            below = max(below, at)
        else:
            above = min(above, at)
        if above - below < 1e-6:
            break
        guess = _secant(points)
        edge = at in (math.log(low), math.log(high))
        if not below < guess < above:
            open_end = (miss < 0.0 and above == math.log(high)) and not edge
            open_start = (miss > 0.0 and below == math.log(low)) and not edge
            guess = above if open_end else below if open_start else 0.5 * (below + above)
        at = guess
    return FoundStrength(
        best.strength, best.ratio, abs(math.log(max(best.ratio, 1e-12) / target)) <= 0.1
    )


def _secant(points: list[tuple[float, float]]) -> float:
    """Where the last two points say that the miss is 0; a slope of 1 without two."""
    at, miss = points[-1]
    if len(points) > 1 and abs(miss - points[-2][1]) > 1e-9:
        before, missed = points[-2]
        return at - miss * (at - before) / (miss - missed)
    return at - miss


def simulate_each(
    references: Sequence[R], drives: Sequence[FloatArray], fine: bool = True
) -> list[FloatArray]:
    """Readings (sensors, samples) of each reference under its own drive, without noise."""
    pairs = zip(references, drives, strict=True)
    return [reference.simulate([drive], fine)[0] for reference, drive in pairs]


def rms(residual: FloatArray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(residual**2)))


@dataclass(frozen=True, kw_only=True, eq=False)
class Trial(Generic[R]):
    """Training recordings of a rig without the hidden effects.

    Attributes:
        references: the rig in the bend of each recording.
        drives: of each [the drive's unit].
        readings: (sensors, samples) of each, in long steps and without noise.
        noise: (sensors,) standard deviations in the sensors' units.
        uncertain: attributes that are calibrated for all recordings together.
        session: whether pretension and zeros are calibrated for each recording by itself.
    """

    references: Sequence[R]
    drives: Sequence[FloatArray]
    readings: Sequence[FloatArray]
    noise: FloatArray
    uncertain: tuple[str, ...]
    session: bool = False

    def residuals(self, change: Callable[[R], R]) -> FloatArray:
        """(m,) by which a change of the references changes their readings [noise]."""
        return self.of(simulate_each([change(r) for r in self.references], self.drives, fine=False))

    def of(self, readings: Sequence[FloatArray]) -> FloatArray:
        """(m,) residuals of readings, by recording, sensor and sample [noise]."""
        return np.concatenate(
            [
                ((a - b) / self.noise[:, None]).ravel()
                for a, b in zip(readings, self.readings, strict=True)
            ]
        )

    def sensitivity(self, attribute: str) -> FloatArray:
        """(m,) by which readings change when an attribute grows by a hundredth [noise]."""
        return self.residuals(
            lambda reference: dataclasses.replace(
                reference, **{attribute: PERTURBATION * getattr(reference, attribute)}
            )
        )

    @cached_property
    def of_recordings(self) -> list[FloatArray]:
        """For each recording (m,), 1 on its residuals and 0 elsewhere."""
        sizes = [reading.size for reading in self.readings]
        owner = np.repeat(np.arange(len(sizes)), sizes)
        return [(owner == k).astype(float) for k in range(len(sizes))]

    @cached_property
    def pretension_sensitivity(self) -> FloatArray:
        """`sensitivity` to the pretension."""
        return self.sensitivity("pretension")

    @cached_property
    def uncalibrated(self) -> Callable[[FloatArray], FloatArray]:
        """Projector onto the residuals that calibration cannot remove."""
        columns = [self.sensitivity(name) for name in self.uncertain]
        if self.session:
            columns += [own * self.pretension_sensitivity for own in self.of_recordings]
            columns += self._zeros()
        return calibration_projector(columns)

    def _zeros(self) -> list[FloatArray]:
        """Sensitivity to the zero of each sensor in each recording."""
        columns = []
        for k, reading in enumerate(self.readings):
            for sensor in range(len(reading)):
                shifted = [r.copy() for r in self.readings]
                shifted[k][sensor] += self.noise[sensor]
                columns.append(self.of(shifted))
        return columns

    def ratio(self, change: Callable[[R], R]) -> float:
        """Rms left by a change of the references after calibration [noise]."""
        return rms(self.uncalibrated(self.residuals(change)))


@dataclass(frozen=True, kw_only=True)
class Strengths(Generic[R]):
    """Strengths of a case, and the reference with its effects.

    Attributes:
        hidden, small: as in `CaseDraw`, with the strength found for each.
        unit: of the plan's target [noise].
    """

    hidden: tuple[tuple[HiddenEffect[R], FoundStrength], ...]
    small: tuple[tuple[HiddenEffect[R], FoundStrength], ...]
    unit: float

    def applied(self, reference: R) -> R:
        """The reference with all effects."""
        return _apply(self.hidden + self.small, reference)


def find_strengths(
    plan: CasePlan, draw: CaseDraw[R], trial: Trial[R], unit: float, rng: np.random.Generator
) -> Strengths[R]:
    """Find strengths that leave the plan's ratio once uncertain parameters are calibrated.

    Args:
        plan, draw: the case.
        trial: its training recordings without the hidden effects.
        unit: of the plan's target [noise].
        rng: of the ratios of small effects; with these, the unit is the rms of them and noise.
    """
    small = tuple((one, _find(trial, one, rng.uniform(*SMALL))) for one in draw.small)
    if small:
        unit = float(np.hypot(1.0, trial.ratio(lambda reference: _apply(small, reference))))
    hidden = tuple(
        (one, _drawn(trial, one, rng))
        if plan.kind == "drawn" and one is draw.hidden[0]
        else (one, _find(trial, one, plan.target * unit))
        for one in draw.hidden
    )
    return Strengths(hidden=hidden, small=small, unit=unit)


def _find(trial: Trial[R], effect: HiddenEffect[R], target: float) -> FoundStrength:
    def ratio(strength: float) -> float:
        return trial.ratio(lambda reference: effect.apply(reference, strength))

    return find_strength(ratio, target, effect.low, effect.high, effect.start)


def _drawn(trial: Trial[R], effect: HiddenEffect[R], rng: np.random.Generator) -> FoundStrength:
    """A strength as it is on rigs, whatever it leaves."""
    strength = float(rng.uniform(*effect.usual))
    ratio = trial.ratio(lambda reference: effect.apply(reference, strength))
    return FoundStrength(strength, ratio, True)


def _apply(effects: tuple[tuple[HiddenEffect[R], FoundStrength], ...], reference: R) -> R:
    for effect, result in effects:
        reference = effect.apply(reference, result.strength)
    return reference
