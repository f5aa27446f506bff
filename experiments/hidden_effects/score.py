"""Scores verdicts against the keys; `python -m experiments.hidden_effects.score --help`."""

from __future__ import annotations

import json
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

from experiments.command import run_experiment
from experiments.hidden_effects.scoring.judged_case import JudgedCase
from experiments.hidden_effects.scoring.suite_statistics import (
    ANY_TOOL,
    confidence,
    confusion,
    table,
)
from experiments.hidden_effects.scoring.tables import markdown, write_csv
from experiments.hidden_effects.scoring.verdicts import judge
from tendon_mj.errors import InvalidValueError


def score(
    verdicts: tuple[Path, ...], keys: tuple[Path, ...], out: Path, partial: bool = False
) -> None:
    """Score the verdicts on one or more suites together; write and print tables and misses.

    Args:
        verdicts: folders with a folder per case, as `diagnose_suite` and rivals write them.
        keys: for each of them, the folder with its keys.json.
        out: folder for score.json, score.md, confusion.csv and misses.csv.
        partial: leave out the cases without a result, which else count as failed.
    """
    if not verdicts or len(verdicts) != len(keys):
        raise InvalidValueError(
            f"--verdicts names {len(verdicts)} folders and --keys {len(keys)}; give one of keys for"
            " each of verdicts, in the same order"
        )
    every = [
        replace(case, name=f"{folder.name}/{case.name}")
        for folder, key in zip(verdicts, keys, strict=True)
        for case in judge(folder, key)
    ]
    judged = [j for j in every if not (partial and j.missing)]
    out.mkdir(parents=True, exist_ok=True)
    rows = [row for row in table(judged) if row[3] or row[0] in ANY_TOOL]
    bins = confidence(judged)
    columns, matrix = confusion(judged)
    text = markdown(["quantity", "wanted", "figure", "cases"], rows)
    text += _of_missing([j.name for j in every if j.missing], len(every), partial)
    text += "\n" + markdown(["confidence", "cases", "stated", "right"], bins)
    text += "\n" + markdown(["hidden", *columns], _matrix_rows(columns, matrix))
    misses = [_miss(j) for j in judged if not _right(j)]
    text += f"\n{_UNREACHED}\n\n" + markdown(MISS, misses)
    (out / "score.md").write_text(text, encoding="utf-8")
    figures = {q: {"wanted": w, "figure": f, "cases": n} for q, w, f, n in rows}
    (out / "score.json").write_text(
        json.dumps(figures, indent=1, ensure_ascii=False) + "\n", encoding="utf-8"
    )
    write_csv(out / "confusion.csv", ["hidden", *columns], _matrix_rows(columns, matrix))
    write_csv(out / "misses.csv", MISS, misses)
    print(text)


MISS = [
    *("case", "kind", "hidden", "target", "reached", "noise"),
    *("verdict", "effects", "ties", "closed"),
]
_UNREACHED = "Misses. Cases whose strength was not reached count in no figure above."


def _of_missing(missing: list[str], cases: int, partial: bool) -> str:
    """Line that says which cases have no result; empty where all have one."""
    if not missing:
        return ""
    if partial:
        return (
            f"\nScored are the {cases - len(missing)} of {cases} cases with a result (--partial).\n"
        )
    shown = ", ".join(missing[:10]) + (", …" if len(missing) > 10 else "")
    return (
        f"\nCases without a result: {len(missing)} of {cases} ({shown}). They count as failed;"
        " where the others alone were run on purpose, --partial leaves them out.\n"
    )


def _right(j: JudgedCase) -> bool:
    if j.result is None:
        return False
    if j.kind == "nothing":
        return j.verdict == "nothing missing"
    if j.kind == "outside":
        return j.verdict == "unknown" or (j.named_effect and not j.confident)
    if j.kind == "parameter":
        return not j.effects and not j.false_names
    if j.kind == "drawn":
        return j.first and not j.false_names
    if j.kind == "too_high":
        return j.right_number
    if j.kind in ("session", "remainder"):
        return not j.false_names and (j.leads > 0.0 or not j.hidden)
    return j.contains and not j.false_names and (j.closed is None or j.closed >= 0.8)


def _miss(j: JudgedCase) -> list[Any]:
    return [
        j.name,
        j.kind,
        "+".join(j.hidden),
        j.key["target"],
        "yes" if j.key["reached"] else "no",
        j.key["noise"],
        "no result" if j.missing else j.verdict,
        "+".join(j.named),
        "; ".join(" or ".join(tie) for tie in j.ties),
        "" if j.closed is None else f"{j.closed:.3f}",
    ]


def _matrix_rows(columns: list[str], matrix: dict[str, Counter[str]]) -> list[list[Any]]:
    return [[name, *(counts[c] or "" for c in columns)] for name, counts in matrix.items()]


if __name__ == "__main__":
    sys.exit(run_experiment(score, "hidden_effects.score"))
