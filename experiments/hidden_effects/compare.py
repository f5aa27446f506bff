"""Scores of several tools beside each other; `python -m experiments.hidden_effects.compare --help`.

All are scored on the cases on which each of them has a verdict.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import tyro

from experiments.hidden_effects.scoring.suite_statistics import table
from experiments.hidden_effects.scoring.tables import markdown
from experiments.hidden_effects.scoring.verdicts import judge


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Scores of several tools on one suite.

    Attributes:
        verdicts: folders with a folder per case, one for each tool; their names head the columns.
        keys: folder with keys.json.
        out: Markdown file for the table, which is printed in any case.
    """

    verdicts: tuple[Path, ...]
    keys: Path
    out: Path | None = None


def compare(settings: Comparison) -> None:
    """Print a table with a column for each tool; "–" where a tool names nothing at all."""
    tools = [{j.name: j for j in judge(folder, settings.keys)} for folder in settings.verdicts]
    common = [name for name in tools[0] if all(name in cases for cases in tools)]
    tables = [{row[0]: row for row in table([cases[name] for name in common])} for cases in tools]
    rows = [
        [quantity, wanted, *(t[quantity][2] if quantity in t else "–" for t in tables), cases]
        for quantity, wanted, _, cases in max(tables, key=len).values()
        if cases
    ]
    names = [folder.name for folder in settings.verdicts]
    text = markdown(["quantity", "wanted", *names, "cases"], rows)
    if settings.out is not None:
        settings.out.write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    compare(tyro.cli(Comparison))
