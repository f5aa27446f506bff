"""Rates and quantiles of judged cases, as rows of a table."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from experiments.hidden_effects.scoring.judged_case import JudgedCase

Row = tuple[str, str, str, int]  # quantity, wanted figure, figure, cases


def of_kind(judged: Sequence[JudgedCase], kind: str) -> list[JudgedCase]:
    """Cases of one kind."""
    return [j for j in judged if j.kind == kind]


def share(
    quantity: str, wanted: str, cases: Sequence[JudgedCase], right: Callable[[JudgedCase], float]
) -> Row:
    """Mean of what ``right`` says of each case, a share [-]."""
    mean = f"{100.0 * np.mean([float(right(j)) for j in cases]):.1f} %" if cases else "–"
    return quantity, wanted, mean, len(cases)


def quantile(quantity: str, wanted: str, values: Sequence[float], at: float | None) -> Row:
    """Quantile of some shares, or their mean where ``at`` is None."""
    if not values:
        return quantity, wanted, "–", 0
    figure = np.mean(values) if at is None else np.quantile(values, at)
    return quantity, wanted, f"{100.0 * figure:.1f} %", len(values)


def spread(quantity: str, values: Sequence[float], upper: float, digits: int) -> Row:
    """Median and an ``upper`` quantile."""
    if not values:
        return quantity, "", "–", 0
    median, high = np.quantile(values, [0.5, upper])
    return quantity, "", f"{median:.{digits}f} / {high:.{digits}f}", len(values)
