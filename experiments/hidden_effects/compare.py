"""Scores of several tools beside each other; `python -m experiments.hidden_effects.compare --help`.

All are scored on all cases of the suite; one without a result of a tool counts as failed for that
tool, and for no other.
"""

from __future__ import annotations

import sys
from pathlib import Path

from experiments.command import run_experiment
from experiments.hidden_effects.statistics import ANY_TOOL, Row, markdown, table
from experiments.hidden_effects.verdicts import JudgedCase, judge
from tendon_mj.errors import InvalidValueError


def compare(
    verdicts: tuple[Path, ...], keys: Path, out: Path | None = None, partial: bool = False
) -> None:
    """Print a table with a column for each tool; "–" where a tool names or states nothing.

    Args:
        verdicts: folders with a folder per case, one for each tool; their names head the columns.
        keys: folder with keys.json.
        out: Markdown file for the table, which is printed in any case.
        partial: score only the cases on which each of the tools has a result.
    """
    if not verdicts:
        raise InvalidValueError("--verdicts names no folder; give one for each tool")
    tools = [{j.name: j for j in judge(folder, keys)} for folder in verdicts]
    cases = _compared(tools) if partial else list(tools[0])
    if not cases:
        raise InvalidValueError(
            "there is no case on which each of the tools has a result; without --partial, those"
            " without one count as failed"
        )
    tables = [{row[0]: row for row in table([tool[name] for name in cases])} for tool in tools]
    header = ["quantity", "wanted", *(folder.name for folder in verdicts), "cases"]
    text = markdown(header, _rows(tables))
    if partial:
        of = f"{len(cases)} of {len(tools[0])} cases"
        text += f"\nScored are the {of} on which each tool has a result (--partial).\n"
    elif any(j.missing for tool in tools for j in tool.values()):
        text += f"\n{_OF_MISSING}\n"
    if out is not None:
        out.write_text(text, encoding="utf-8")
    print(text)


def _compared(tools: list[dict[str, JudgedCase]]) -> list[str]:
    """Cases on which each of the tools has a result."""
    return [name for name in tools[0] if not any(tool[name].missing for tool in tools)]


def _rows(tables: list[dict[str, Row]]) -> list[list[object]]:
    """Rows of the quantities that some tool has."""
    rows: list[list[object]] = []
    for quantity, wanted, _, _ in max(tables, key=len).values():
        of_tools = [of_tool.get(quantity) for of_tool in tables]
        counted = max(row[3] for row in of_tools if row is not None)
        if counted or quantity in ANY_TOOL:
            rows.append([quantity, wanted, *(_figure(row, counted) for row in of_tools), counted])
    return rows


_OF_MISSING = (
    "Cases without a result count as failed; where they were left out on purpose, --partial scores"
    " only those on which each tool has one."
)


def _figure(row: Row | None, cases: int) -> str:
    """Figure of a tool, with the number of cases where other tools have more."""
    if row is None:
        return "–"
    return row[2] if row[3] in (0, cases) else f"{row[2]} (of {row[3]})"


if __name__ == "__main__":
    sys.exit(run_experiment(compare, "hidden_effects.compare"))
