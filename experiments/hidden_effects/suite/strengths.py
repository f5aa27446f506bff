"""Strengths of what a case hides, found on its training recordings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic

import numpy as np

from experiments.hidden_effects.effects.hidden_effect import HiddenEffect
from experiments.hidden_effects.suite.case_draws import CaseDraw
from experiments.hidden_effects.suite.case_plan import CasePlan
from experiments.hidden_effects.suite.rig_state import R
from experiments.hidden_effects.suite.strength_search import FoundStrength, find_strength
from experiments.hidden_effects.suite.trial import Trial

SMALL = (1.0, 4.0)  # of each effect that leaves the remainder, once calibrated [noise]


@dataclass(frozen=True, kw_only=True)
class Strengths(Generic[R]):
    """Strengths of a case, and the reference with its effects.

    Attributes:
        hidden, small: as in `CaseDraw`, with the strength found for each.
        unit: what the plan's target is a multiple of [noise].
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
        trial: its training recordings without what is hidden.
        unit: what the plan's target is a multiple of [noise].
        rng: of the ratios of small effects; with these, the unit is what they and noise leave.
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
    for effect, found in effects:
        reference = effect.apply(reference, found.strength)
    return reference
