"""Statistics of judged cases: rates beside the wanted ones, calibration, confusion; tables."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from experiments.hidden_effects.hidden import DRAWN
from experiments.hidden_effects.verdicts import PREDICTION, JudgedCase

Row = tuple[str, str, str, int]  # quantity, wanted figure, figure, cases
STRONG = 5.0  # ratio of residual to noise from which an effect is to be named nearly always
LEFT = "error left on held-out data, as stated, median / worst decile [noise]"
SECONDS = "seconds per diagnosis, as stated, median / longest"
ANY_TOOL = (LEFT, SECONDS)  # quantities of every suite: a dash says that the tool states none


def of_kind(judged: Sequence[JudgedCase], kind: str) -> list[JudgedCase]:
    """Cases of one kind."""
    return [j for j in judged if j.kind == kind]


def share(
    quantity: str, wanted: str, cases: Sequence[JudgedCase], right: Callable[[JudgedCase], float]
) -> Row:
    """Mean of ``right`` over the cases, a share [-]."""
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


def markdown(header: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    """A Markdown table; floats to three digits."""
    lines = [header, ["---"] * len(header), *rows]
    cells = [[f"{c:.3g}" if isinstance(c, float) else str(c) for c in line] for line in lines]
    return "\n".join("| " + " | ".join(line) + " |" for line in cells) + "\n"


def write_csv(path: Path, header: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    """Write a table as CSV."""
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([header, *rows])


def table(judged: Sequence[JudgedCase]) -> list[Row]:
    """Figures that a diagnosis has to show, without cases whose strength was not reached.

    Of a tool that only predicts, those on names are left out.
    """
    verdicts = {j.verdict for j in judged}
    if PREDICTION in verdicts and verdicts <= {PREDICTION, "failed"}:
        return _of_any_tool(judged)
    alone, pairs = _reached(judged, "effect", "joint"), _reached(judged, "pair")
    closed = [j.closed for j in [*alone, *pairs] if j.closed is not None]
    strong = [j for j in alone if j.key["target"] >= STRONG]
    errors = [e for j in strong if j.hit > 0.0 for e in j.errors()]
    return [
        *_one_effect(alone),
        share("two effects: both named", "≥ 85 %", pairs, lambda j: j.named_effect and j.contains),
        _false("two effects", pairs),
        *_no_effect(judged),
        quantile("reducible error removed on held-out, as stated, median", "≥ 95 %", closed, 0.5),
        quantile("… worst decile", "≥ 80 %", closed, 0.1),
        quantile("parameter error, ≥ 5 noise, median", "≤ 10 %", [e[1] for e in errors], 0.5),
        quantile("… 95 % interval covers", "≥ 90 %", [float(e[2]) for e in errors], None),
        *reality(judged),
        *_drawn(judged),
        *_of_any_tool(judged),
    ]


def _reached(judged: Sequence[JudgedCase], *kinds: str) -> list[JudgedCase]:
    """Cases of some kinds whose strength was reached."""
    return [j for j in judged if j.kind in kinds and j.key["reached"]]


def _one_effect(alone: Sequence[JudgedCase]) -> list[Row]:
    strong = [j for j in alone if j.key["target"] >= STRONG]
    weak = [j for j in alone if j.key["target"] < STRONG]
    return [
        share(
            "one effect, residual ≥ 5 noise: first (tie: half)", "≥ 97 %", strong, lambda j: j.hit
        ),
        share("… contained in the verdict", "≥ 99 %", strong, lambda j: j.contains),
        share("one effect, 2 noise: first (tie: half)", "≥ 90 %", weak, lambda j: j.hit),
        _false("one effect", alone),
        share("one effect: abstained", "", alone, lambda j: not j.named),
    ]


def _no_effect(judged: Sequence[JudgedCase]) -> list[Row]:
    """Cases in which no effect of the catalogue is hidden."""
    nothing, outside = of_kind(judged, "nothing"), of_kind(judged, "outside")
    parameter = of_kind(judged, "parameter")
    return [
        share("nothing hidden: false name", "≤ 3 %", nothing, lambda j: bool(j.false_names)),
        share(
            "outside the catalogue: unknown or a tie",
            "≥ 90 %",
            outside,
            lambda j: j.verdict == "unknown" or (j.named_effect and not j.confident),
        ),
        share(
            "outside the catalogue: confident wrong name", "≤ 5 %", outside, lambda j: j.confident
        ),
        share(
            "wrong parameter: no effect named",
            "≥ 95 %",
            parameter,
            lambda j: j.result is not None and not j.effects,
        ),
        share("wrong parameter: called so", "", parameter, lambda j: j.verdict == "parameter"),
        _false("wrong parameter", parameter),
    ]


def _drawn(judged: Sequence[JudgedCase]) -> list[Row]:
    """Figures of the effects whose strength is as on a rig."""
    drawn = of_kind(judged, "drawn")
    alone = {name: [j for j in drawn if j.hidden[0] == name] for name in DRAWN}
    return [
        *(
            share(f"{name}, as on a rig: first", "≥ 90 %", cases, lambda j: j.first)
            for name, cases in alone.items()
        ),
        share("… of two effects", "", [j for j in drawn if len(j.hidden) > 1], lambda j: j.first),
        _false("as on a rig", drawn),
    ]


def _false(cases: str, judged: Sequence[JudgedCase]) -> Row:
    """Share of cases in which an effect is named, or a number called wrong, that is not hidden."""
    quantity = f"{cases}: something named that is not there"
    return share(quantity, "", judged, lambda j: bool(j.false_names))


def _of_any_tool(judged: Sequence[JudgedCase]) -> list[Row]:
    """Figures that do not ask for names; "as stated" are those that only the tool knows."""
    left = [j.left for j in judged if j.left is not None]
    seconds = [j.seconds for j in judged if j.seconds is not None]
    missing = sum(j.missing for j in judged)
    return [
        spread(LEFT, left, 0.9, 2),
        spread(SECONDS, seconds, 1.0, 1),
        share("failed", "0", judged, lambda j: j.result is None),
        ("cases without a result, which count as failed", "0", str(missing), len(judged)),
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
        row = j.hidden[0] if j.kind in ("effect", "joint", "drawn") else j.kind
        if j.kind in ("parameter", "outside", "session", "remainder", "too_high"):
            row = f"{j.kind}: {j.hidden[0] if j.hidden else 'nothing'}"
        rows.setdefault(row, Counter())[j.column] += 1
    words = ["A or B", "unknown", "nothing missing", "parameter", "failed"]
    seen = {column for row in rows.values() for column in row} - set(words)
    return [*sorted(seen), *words], dict(sorted(rows.items()))


def reality(judged: Sequence[JudgedCase]) -> list[Row]:
    """Rows of the table; cases whose strength was not reached count in none."""
    sessions, remainders, too_high = (
        _reached(judged, kind) for kind in ("session", "remainder", "too_high")
    )
    effects = [j for j in (*sessions, *remainders) if j.hidden]
    return [
        share(
            "one effect, 5 × what remains: first (tie: half)", "≥ 90 %", effects, lambda j: j.leads
        ),
        share("… sessions", "", [j for j in sessions if j.hidden], lambda j: j.leads),
        share("… remainders", "", remainders, lambda j: j.leads),
        share(
            "sessions and remainders: something named that is not there",
            "≤ 3 %",
            [*sessions, *remainders],
            lambda j: bool(j.false_names),
        ),
        share(
            "… sessions with nothing hidden",
            "",
            [j for j in sessions if not j.hidden],
            lambda j: bool(j.false_names),
        ),
        share("remainders: verdict partly", "", remainders, lambda j: j.verdict == "partly"),
        share(
            "number too high: called wrong, that one alone, true value in its interval",
            "≥ 95 %",
            too_high,
            lambda j: j.right_number,
        ),
        share("… called a wrong parameter", "", too_high, lambda j: j.verdict == "parameter"),
    ]
