"""Scores verdicts against the keys; `python -m experiments.hidden_effects.score --help`."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import tyro

from experiments.hidden_effects.scoring.judged_case import JudgedCase
from experiments.hidden_effects.scoring.suite_statistics import confidence, confusion, table
from experiments.hidden_effects.scoring.tables import markdown, write_csv
from experiments.hidden_effects.scoring.verdicts import judge


@dataclass(frozen=True, kw_only=True)
class Score:
    """Score of the verdicts on one or more suites together.

    Attributes:
        verdicts: folders with a folder per case, as `diagnose_suite` and rivals write them.
        keys: for each of them, the folder with its keys.json.
        out: folder for score.json, score.md, confusion.csv and misses.csv.
    """

    verdicts: tuple[Path, ...]
    keys: tuple[Path, ...]
    out: Path


def score(settings: Score) -> None:
    """Write and print the table, the confusion matrix and the misses."""
    judged = [
        replace(case, name=f"{verdicts.name}/{case.name}")
        for verdicts, keys in zip(settings.verdicts, settings.keys, strict=True)
        for case in judge(verdicts, keys)
    ]
    settings.out.mkdir(parents=True, exist_ok=True)
    rows, bins = [row for row in table(judged) if row[3]], confidence(judged)
    columns, matrix = confusion(judged)
    text = markdown(["quantity", "wanted", "figure", "cases"], rows)
    text += "\n" + markdown(["confidence", "cases", "stated", "right"], bins)
    text += "\n" + markdown(["hidden", *columns], _matrix_rows(columns, matrix))
    misses = [_miss(j) for j in judged if not _right(j)]
    text += f"\n{_UNREACHED}\n\n" + markdown(MISS, misses)
    (settings.out / "score.md").write_text(text, encoding="utf-8")
    figures = {q: {"wanted": w, "figure": f, "cases": n} for q, w, f, n in rows}
    (settings.out / "score.json").write_text(
        json.dumps(figures, indent=1, ensure_ascii=False) + "\n", encoding="utf-8"
    )
    write_csv(settings.out / "confusion.csv", ["hidden", *columns], _matrix_rows(columns, matrix))
    write_csv(settings.out / "misses.csv", MISS, misses)
    print(text)


MISS = [
    *("case", "kind", "hidden", "target", "reached", "noise"),
    *("verdict", "effects", "ties", "closed"),
]
_UNREACHED = "Misses. Cases whose strength was not reached count in no figure above."


def _right(j: JudgedCase) -> bool:
    if j.kind == "nothing":
        return j.verdict == "nothing missing"
    if j.kind == "outside":
        return not j.confident
    if j.kind == "parameter":
        return not j.effects
    if j.kind == "too_high":
        return j.right_number
    if j.kind in ("session", "remainder"):
        return not j.false_names and (j.leads > 0.0 or not j.hidden)
    return j.contains and not j.extra and (j.closed or 0.0) >= 0.8


def _miss(j: JudgedCase) -> list[Any]:
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


def _matrix_rows(columns: list[str], matrix: dict[str, Counter[str]]) -> list[list[Any]]:
    return [[name, *(counts[c] or "" for c in columns)] for name, counts in matrix.items()]


if __name__ == "__main__":
    score(tyro.cli(Score))
