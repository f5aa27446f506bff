"""Correlations of the parameters that a diagnosis fitted: which of them compensate each other."""

from __future__ import annotations

from dataclasses import dataclass

from tendon_mj.lab.diagnosis.model_selection.intervals import correlation_matrix
from tendon_mj.lab.diagnosis.result.diagnosis import Diagnosis

HIGH = 0.9  # |ρ| from which two values are said to compensate each other


@dataclass(frozen=True)
class Correlations:
    """Correlations of estimates.

    Attributes:
        names: of the parameters; of those that share one number, the first.
        matrix: (n, n) correlation coefficients [-].
    """

    names: tuple[str, ...]
    matrix: tuple[tuple[float, ...], ...]

    @property
    def high(self) -> list[tuple[str, str, float]]:
        """Pairs that are correlated by more than 0.9, and the coefficient."""
        return [
            (one, other, self.matrix[j][k])
            for j, one in enumerate(self.names)
            for k, other in enumerate(self.names[:j])
            if abs(self.matrix[j][k]) > HIGH
        ]


def parameter_correlations(diagnosis: Diagnosis) -> Correlations | None:
    """Correlations of the values that hold in all recordings and that the data determine.

    None where a diagnosis was not made by `diagnose`, or there are fewer than two such values.
    """
    if diagnosis.search is None:
        return None
    context, selection = diagnosis.search
    fit = selection.final.fit
    chosen = fit.free & fit.shared
    if int(chosen.sum()) < 2:
        return None
    matrix = correlation_matrix(context.problem, fit, chosen)
    names = tuple(t.targets[0] for t, used in zip(fit.terms, chosen, strict=True) if used)
    return Correlations(names, tuple(tuple(map(float, row)) for row in matrix))
