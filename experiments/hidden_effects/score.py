"""Scores verdicts against the keys; `python -m experiments.hidden_effects.score --help`."""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from experiments.command import run_experiment
from experiments.hidden_effects.statistics import (
    ANY_TOOL,
    confidence,
    confusion,
    markdown,
    table,
    write_csv,
)
from experiments.hidden_effects.verdicts import JudgedCase, judge
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
    every = _judge_all(verdicts, keys)
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


def _judge_all(verdicts: tuple[Path, ...], keys: tuple[Path, ...]) -> list[JudgedCase]:
    if not verdicts or len(verdicts) != len(keys):
        raise InvalidValueError(
            f"--verdicts names {len(verdicts)} folders and --keys {len(keys)}; give one of keys for"
            " each of verdicts, in the same order"
        )
    return [
        replace(case, name=f"{folder.name}/{case.name}")
        for folder, key in zip(verdicts, keys, strict=True)
        for case in judge(folder, key)
    ]


MISS = [
    *("case", "kind", "hidden", "target", "reached", "noise"),
    *("verdict", "effects", "ties", "closed"),
]
_UNREACHED = "Misses. Cases whose strength was not reached count in no figure above."


def _of_missing(missing: list[str], cases: int, partial: bool) -> str:
    """Line that says which cases have no result; empty if all have one."""
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
    return j.result is not None and _RIGHT.get(j.kind, _names_all)(j)


def _names_all(j: JudgedCase) -> bool:
    return j.contains and not j.false_names and (j.closed is None or j.closed >= 0.8)


def _leads(j: JudgedCase) -> bool:
    return not j.false_names and (j.leads > 0.0 or not j.hidden)


_RIGHT: dict[str, Callable[[JudgedCase], bool]] = {
    "nothing": lambda j: j.verdict == "nothing missing",
    "outside": lambda j: j.verdict == "unknown" or (j.named_effect and not j.confident),
    "parameter": lambda j: not j.effects and not j.false_names,
    "drawn": lambda j: j.first and not j.false_names,
    "too_high": lambda j: j.right_number,
    "session": _leads,
    "remainder": _leads,
}


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
