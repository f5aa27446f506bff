"""Scores verdicts against the keys; `python -m experiments.hidden_effects.score --help`."""

from __future__ import annotations

import csv
import json
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import tyro

from experiments.hidden_effects.verdict import Judged

STRONG = 5.0  # ratio of gap to noise from which an effect is to be named nearly always
Row = tuple[str, str, str, int]  # what, wanted, figure, cases


@dataclass(frozen=True, kw_only=True)
class Score:
    """What verdicts on suites are worth, all together.

    Attributes:
        verdicts: folders that `diagnose_suite` wrote.
        keys: for each of them, the folder with its keys.json.
        out: folder for score.json, score.md, confusion.csv and misses.csv.
    """

    verdicts: tuple[Path, ...]
    keys: tuple[Path, ...]
    out: Path


def judge(verdicts: Path, keys: Path) -> list[Judged]:
    """Every case of a suite that was run, beside its key."""
    cases = json.loads((keys / "keys.json").read_text(encoding="utf-8"))["cases"]
    judged = []
    for name, key in cases.items():
        folder = verdicts / name
        if not (folder / "run.json").exists():
            continue
        about = json.loads((folder / "run.json").read_text(encoding="utf-8"))
        result = None
        if not about["error"]:
            result = json.loads((folder / "result.json").read_text(encoding="utf-8"))
        judged.append(Judged(name, key, result, float(about["seconds"])))
    return judged


def table(judged: Sequence[Judged]) -> list[Row]:
    """The figures that the diagnosis has to show; a strength not reached counts nowhere."""
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
        _share("one effect, gap ≥ 5 noise: first (tie: half)", "≥ 97 %", strong, lambda j: j.hit),
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
        _quantile("reducible gap closed on held-out, median", "≥ 95 %", closed, 0.5),
        _quantile("… worst decile", "≥ 80 %", closed, 0.1),
        _quantile("parameter error, ≥ 5 noise, median", "≤ 10 %", [e[1] for e in errors], 0.5),
        _quantile("… 95 % interval covers", "≥ 90 %", [float(e[2]) for e in errors], None),
        ("seconds per diagnosis, median / longest", "", _seconds(judged), len(judged)),
        _share("failed", "0", judged, lambda j: j.result is None),
    ]


def confidence(judged: Sequence[Judged]) -> list[tuple[str, int, float, float]]:
    """Stated confidence by bins: range, cases, mean stated, share that was right."""
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


def confusion(judged: Sequence[Judged]) -> tuple[list[str], dict[str, Counter[str]]]:
    """Columns, and for what was hidden how often each of them was the verdict."""
    rows: dict[str, Counter[str]] = {}
    for j in judged:
        row = j.hidden[0] if j.kind in ("effect", "joint") else j.kind
        if j.kind in ("parameter", "outside"):
            row = f"{j.kind}: {j.hidden[0]}"
        rows.setdefault(row, Counter())[j.column] += 1
    words = ["A or B", "unknown", "nothing missing", "parameter", "failed"]
    seen = {column for row in rows.values() for column in row} - set(words)
    return [*sorted(seen), *words], dict(sorted(rows.items()))


def score(settings: Score) -> None:
    """Write and print the table, the confusion matrix and the misses."""
    judged = [
        replace(case, name=f"{verdicts.name}/{case.name}")
        for verdicts, keys in zip(settings.verdicts, settings.keys, strict=True)
        for case in judge(verdicts, keys)
    ]
    settings.out.mkdir(parents=True, exist_ok=True)
    rows, bins = table(judged), confidence(judged)
    columns, matrix = confusion(judged)
    text = _markdown(["what", "wanted", "figure", "cases"], rows)
    text += "\n" + _markdown(["confidence", "cases", "stated", "right"], bins)
    text += "\n" + _markdown(["hidden", *columns], _matrix_rows(columns, matrix))
    misses = [_miss(j) for j in judged if not _right(j)]
    text += f"\n{_UNREACHED}\n\n" + _markdown(MISS, misses)
    (settings.out / "score.md").write_text(text, encoding="utf-8")
    figures = {what: {"wanted": w, "figure": f, "cases": n} for what, w, f, n in rows}
    (settings.out / "score.json").write_text(
        json.dumps(figures, indent=1, ensure_ascii=False) + "\n", encoding="utf-8"
    )
    _write_csv(settings.out / "confusion.csv", ["hidden", *columns], _matrix_rows(columns, matrix))
    _write_csv(settings.out / "misses.csv", MISS, misses)
    print(text)


MISS = [
    *("case", "kind", "hidden", "target", "reached", "noise"),
    *("verdict", "effects", "ties", "closed"),
]
_UNREACHED = "What went wrong; a strength that was not reached counts nowhere above."


def _right(j: Judged) -> bool:
    if j.kind == "nothing":
        return j.verdict == "nothing missing"
    if j.kind == "outside":
        return not j.confident
    if j.kind == "parameter":
        return not j.effects
    return j.contains and not j.extra and (j.closed or 0.0) >= 0.8


def _miss(j: Judged) -> list[Any]:
    return [
        j.name,
        j.kind,
        "+".join(j.hidden),
        j.key["target"],
        "yes" if j.key["reached"] else "no",
        j.key["noise"],
        j.verdict,
        "+".join(j.effects),
        "; ".join(" or ".join(tie) for tie in j.ties),
        "" if j.closed is None else f"{j.closed:.3f}",
    ]


def _kind(judged: Sequence[Judged], kind: str) -> list[Judged]:
    return [j for j in judged if j.kind == kind]


def _share(
    what: str, wanted: str, cases: Sequence[Judged], right: Callable[[Judged], float]
) -> Row:
    mean = f"{100.0 * np.mean([float(right(j)) for j in cases]):.1f} %" if cases else "–"
    return what, wanted, mean, len(cases)


def _quantile(what: str, wanted: str, values: Sequence[float], at: float | None) -> Row:
    """Quantile of some shares, or their mean where ``at`` is None."""
    if not values:
        return what, wanted, "–", 0
    figure = np.mean(values) if at is None else np.quantile(values, at)
    return what, wanted, f"{100.0 * figure:.1f} %", len(values)


def _seconds(judged: Sequence[Judged]) -> str:
    spent = [j.seconds for j in judged]
    return f"{np.median(spent):.1f} / {max(spent):.1f}" if spent else "–"


def _matrix_rows(columns: list[str], matrix: dict[str, Counter[str]]) -> list[list[Any]]:
    return [[name, *(counts[c] or "" for c in columns)] for name, counts in matrix.items()]


def _markdown(header: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    lines = [header, ["---"] * len(header), *rows]
    cells = [[f"{c:.3g}" if isinstance(c, float) else str(c) for c in line] for line in lines]
    return "\n".join("| " + " | ".join(line) + " |" for line in cells) + "\n"


def _write_csv(path: Path, header: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([header, *rows])


if __name__ == "__main__":
    score(tyro.cli(Score))
