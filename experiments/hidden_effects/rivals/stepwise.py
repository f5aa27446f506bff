"""Stepwise selection by BIC over the same catalogue, without held-out data.

`python -m experiments.hidden_effects.rivals.stepwise --help`. Each round adds the effect that
lowers

    BIC = n ln(RSS/n) + k ln n

most, n samples and k fitted numbers, then drops each without which it is lower still. All effects
are screened by the residual that a linear fit of their trace predicts, and the most promising ones
are fitted. It ends if no effect lowers the BIC, or at `MOST` of them.
"""

from __future__ import annotations

import math
import sys
from itertools import product
from typing import Any

import numpy as np

from experiments.hidden_effects.case_folder import Case
from experiments.hidden_effects.rivals.rig import Rig, run_rival
from experiments.hidden_effects.rivals.term_fit import TermFit, errors, fit_terms, predict, written
from tendon_mj.lab.diagnosis import CATALOGUE, Candidate, Term
from tendon_mj.typing import FloatArray

STEP = 2.0  # of the simulation, times the model's own; predictions take the model's
FITTED = 3  # candidates in each round
MOST = 6  # effects
CONFIDENCE = 1.96  # standard deviations of a 95 % interval

Model = tuple[tuple[Candidate, ...], TermFit]


class Stepwise:
    """Selection on the training recordings of one case."""

    def __init__(self, case: Case) -> None:
        self.rig = Rig(case.train, STEP)
        self.calibrated = (*self.rig.uncertain, *self.rig.sessions)
        system = self.rig.describe()
        self.candidates = [
            candidate
            for name, effect in CATALOGUE.items()
            if name not in case.exclude
            for candidate in effect.bind(system)
        ]

    def bic(self, model: Model) -> float:
        """n ln(RSS/n) + k ln n."""
        _, fit = model
        count = fit.residual.size
        return count * math.log(fit.cost / count) + len(fit.terms) * math.log(count)

    def select(self) -> Model:
        """The model at which no step lowers the BIC."""
        start = [term.inert for term in self.calibrated]
        best: Model = ((), fit_terms(self.rig, self.calibrated, start, {}))
        while len(best[0]) < MOST:
            larger = [self._fit((*best[0], c), values) for c, values in self._promising(best)]
            result = min(larger, key=self.bic, default=best)
            if self.bic(result) >= self.bic(best):
                break
            best = self._drop(result)
        return best

    def _fit(self, effects: tuple[Candidate, ...], start: FloatArray) -> Model:
        terms = (*self.calibrated, *(term for effect in effects for term in effect.terms))
        return effects, fit_terms(self.rig, terms, start, {})

    def _drop(self, model: Model) -> Model:
        """The model without effects that the BIC can do without, the last one excepted."""
        for effect in model[0][:-1]:
            rest = tuple(e for e in model[0] if e is not effect)
            kept = [term for e in rest for term in e.terms]
            values = dict(zip(model[1].terms, model[1].values, strict=True))
            smaller = self._fit(rest, np.array([values[t] for t in (*self.calibrated, *kept)]))
            if self.bic(smaller) < self.bic(model):
                return self._drop(smaller) if len(rest) > 1 else smaller
        return model

    def _promising(self, model: Model) -> list[tuple[Candidate, FloatArray]]:
        """Candidates that a linear fit predicts to leave least, each with values to begin from."""
        effects, fit = model
        taken = frozenset[str]().union(*(effect.targets for effect in effects))
        tried = [
            (candidate, np.array([*fit.values, _probe(candidate.terms[0]), *shape]))
            for candidate in self.candidates
            if not candidate.targets & taken
            for shape in product(*(term.starts for term in candidate.terms[1:]))
        ]
        sets = [written((*fit.terms, *c.terms), values, self.rig.base) for c, values in tried]
        left = [
            (self._predicted(fit, row - fit.residual), k)
            for k, row in enumerate(self.rig.residuals(sets))
        ]
        best: dict[str, int] = {}
        for _, k in sorted(left):
            best.setdefault(tried[k][0].label, k)
        return [tried[k] for k in list(best.values())[:FITTED]]

    def _predicted(self, fit: TermFit, trace: FloatArray) -> float:
        """Sum of squares that the residual and this trace of an effect would leave."""
        matrix = np.column_stack([fit.jacobian, trace])
        step, *_ = np.linalg.lstsq(matrix, -fit.residual, rcond=None)
        return float(np.sum((fit.residual + matrix @ step) ** 2))


def _probe(term: Term) -> float:
    """A strength a little off inert, where the range allows it."""
    return term.inert + (term.probe if term.high - term.inert >= term.probe else -term.probe)


def _intervals(model: Model, base: dict[str, float]) -> dict[str, dict[str, float]]:
    """Parameters of the effects with intervals as least squares state them."""
    effects, fit = model
    normal = fit.jacobian.T @ fit.jacobian
    variance = fit.cost / fit.residual.size * np.diag(np.linalg.pinv(normal))
    scaled = [term.scaled(float(v)) for term, v in zip(fit.terms, fit.values, strict=True)]
    named = frozenset(t for effect in effects for t in effect.targets)
    result: dict[str, dict[str, float]] = {}
    for k, term in enumerate(fit.terms):
        half = CONFIDENCE * math.sqrt(variance[k])
        ends = [term.natural(scaled[k] + shift) for shift in (0.0, -half, half)]
        for target in named.intersection(term.targets):
            value, *span = (_write(fit, k, end, base)[target] for end in ends)
            result[target] = {"value": value, "low": min(span), "high": max(span)}
    return result


def _write(fit: TermFit, index: int, value: float, base: dict[str, float]) -> dict[str, float]:
    values = fit.values.copy()
    values[index] = value
    return written(fit.terms, values, base)


def solve(case: Case) -> dict[str, Any]:
    """Select on a case; content of result.json."""
    stepwise = Stepwise(case)
    effects, fit = model = stepwise.select()
    kinds = {candidate.effect.kind for candidate in effects}
    verdict = "named" if "missing" in kinds else "parameter" if kinds else "nothing missing"
    parameters = fit.parameters(stepwise.rig.base)
    return {
        "verdict": verdict,
        "effects": list(dict.fromkeys(effect.identifier for effect in effects)),
        "indistinguishable": [],
        "parameters": _intervals(model, stepwise.rig.base),
        "gap": errors(case.held_out, predict(case.held_out, parameters)),
    }


if __name__ == "__main__":
    sys.exit(run_rival(solve, "stepwise"))
