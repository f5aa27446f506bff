"""Statistics of judged cases: rates beside the wanted ones, calibration, confusion."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

import numpy as np

from experiments.hidden_effects.scoring.judged_case import JudgedCase

STRONG = 5.0  # ratio of residual to noise from which an effect is to be named nearly always
Row = tuple[str, str, str, int]  # quantity, wanted figure, figure, cases


def table(judged: Sequence[JudgedCase]) -> list[Row]:
    """Figures that the diagnosis has to show, without cases whose strength was not reached."""
    alone = [j for j in judged if j.kind in ("effect", "joint") and j.key["reached"]]
    strong = [j for j in alone if j.key["target"] >= STRONG]
    weak = [j for j in alone if j.key["target"] < STRONG]
    pairs = _kind(judged, "pair")
    pairs = [j for j in pairs if j.key["reached"]]
    nothing, outside = _kind(judged, "nothing"), _kind(judged, "outside")
    parameter = _kind(judged, "parameter")
    closed = [j.closed for j in [*alone, *pairs] if j.closed is not None]
    errors = [e for j in strong if j.hit > 0.0 for e in j.errors()]
    return [
        _share(
            "one effect, residual ≥ 5 noise: first (tie: half)", "≥ 97 %", strong, lambda j: j.hit
        ),
        _share("… contained in the verdict", "≥ 99 %", strong, lambda j: j.contains),
        _share("one effect, 2 noise: first (tie: half)", "≥ 90 %", weak, lambda j: j.hit),
        _share("one effect: something named that is not there", "", alone, lambda j: bool(j.extra)),
        _share("one effect: abstained", "", alone, lambda j: not j.named_effect),
        _share(
            "two effects: both named",
            "≥ 85 %",
            pairs,
            lambda j: set(j.hidden) <= set(j.effects) or (j.named_effect and j.contains),
        ),
        _share("nothing hidden: false name", "≤ 3 %", nothing, lambda j: j.named_effect),
        _share(
            "outside the catalogue: unknown or a tie",
            "≥ 90 %",
            outside,
            lambda j: j.verdict == "unknown" or (j.named_effect and not j.confident),
        ),
        _share(
            "outside the catalogue: confident wrong name", "≤ 5 %", outside, lambda j: j.confident
        ),
        _share("wrong parameter: no effect named", "≥ 95 %", parameter, lambda j: not j.effects),
        _share("wrong parameter: called so", "", parameter, lambda j: j.verdict == "parameter"),
        _quantile("reducible error removed on held-out, median", "≥ 95 %", closed, 0.5),
        _quantile("… worst decile", "≥ 80 %", closed, 0.1),
        _quantile("parameter error, ≥ 5 noise, median", "≤ 10 %", [e[1] for e in errors], 0.5),
        _quantile("… 95 % interval covers", "≥ 90 %", [float(e[2]) for e in errors], None),
        ("seconds per diagnosis, median / longest", "", _seconds(judged), len(judged)),
        _share("failed", "0", judged, lambda j: j.result is None),
    ]


def confidence(judged: Sequence[JudgedCase]) -> list[tuple[str, int, float, float]]:
    """Calibration of the stated confidence: range, cases, mean stated, share that was right."""
    said = [
        (float(j.result["confidence"]), j.hit > 0.0 or (len(j.hidden) > 1 and j.contains))
        for j in judged
        if j.result is not None and j.named_effect and j.result.get("confidence") is not None
    ]
    rows = []
    for low, high in ((0.0, 0.5), (0.5, 0.8), (0.8, 0.95), (0.95, 0.99), (0.99, 1.01)):
        part = [(c, right) for c, right in said if low <= c < high]
        if part:
            stated, right = np.mean(part, axis=0)
            rows.append((f"{low:g} … {min(high, 1.0):g}", len(part), float(stated), float(right)))
    return rows


def confusion(judged: Sequence[JudgedCase]) -> tuple[list[str], dict[str, Counter[str]]]:
    """Confusion matrix: its columns, and for each hidden effect the number of cases in each."""
    rows: dict[str, Counter[str]] = {}
    for j in judged:
        row = j.hidden[0] if j.kind in ("effect", "joint") else j.kind
        if j.kind in ("parameter", "outside"):
            row = f"{j.kind}: {j.hidden[0]}"
        rows.setdefault(row, Counter())[j.column] += 1
    words = ["A or B", "unknown", "nothing missing", "parameter", "failed"]
    seen = {column for row in rows.values() for column in row} - set(words)
    return [*sorted(seen), *words], dict(sorted(rows.items()))


def _kind(judged: Sequence[JudgedCase], kind: str) -> list[JudgedCase]:
    return [j for j in judged if j.kind == kind]


def _share(
    quantity: str, wanted: str, cases: Sequence[JudgedCase], right: Callable[[JudgedCase], float]
) -> Row:
    mean = f"{100.0 * np.mean([float(right(j)) for j in cases]):.1f} %" if cases else "–"
    return quantity, wanted, mean, len(cases)


def _quantile(quantity: str, wanted: str, values: Sequence[float], at: float | None) -> Row:
    """Quantile of some shares, or their mean where ``at`` is None."""
    if not values:
        return quantity, wanted, "–", 0
    figure = np.mean(values) if at is None else np.quantile(values, at)
    return quantity, wanted, f"{100.0 * figure:.1f} %", len(values)


def _seconds(judged: Sequence[JudgedCase]) -> str:
    spent = [j.seconds for j in judged]
    return f"{np.median(spent):.1f} / {max(spent):.1f}" if spent else "–"
