"""Figures of studies beside what a README states: errors may be smaller, all else is the same."""

import pytest

from experiments.studies import Figure
from tendon_mj.errors import TendonError

PAGE = """
| model | angle | force | found |
|---|---|---|---|
| **ours** | **2.00** (9.50) | 0.50, −0.40 (0.1) | `partly`: `friction`, `creep` (or `play`) |

| model | force |
|---|---|
| ours | 3.0 N |
"""


@pytest.mark.parametrize(
    ("cell", "measured", "errors", "table", "agrees"),
    [
        (1, (2.05,), True, 0, True),
        (1, (2.2,), True, 0, False),
        (1, (1.0,), True, 0, True),
        (1, (1.0,), False, 0, False),
        (2, (0.5, -0.4), False, 0, True),
        (2, (0.5, -0.3), False, 0, False),
        (2, (0.5, -0.4, 0.1), True, 0, False),
        (1, (3.0,), False, 1, True),
        (1, (float("nan"),), True, 0, False),
        (3, "partly: friction, creep", True, 0, True),
        (3, "partly: friction", True, 0, False),
    ],
)
def test_errors_may_be_smaller_than_stated_and_all_else_is_the_same(
    cell: int, measured: tuple[float, ...] | str, errors: bool, table: int, agrees: bool
) -> None:
    assert Figure("ours", cell, measured, errors, table).agrees(PAGE) == agrees


@pytest.mark.parametrize(
    ("row", "cell", "table"), [("theirs", 1, 0), ("ours", 4, 0), ("ours", 1, 2)]
)
def test_a_figure_that_is_not_stated_is_refused(row: str, cell: int, table: int) -> None:
    with pytest.raises(TendonError, match=row):
        Figure(row, cell, (1.0,), table=table).agrees(PAGE)
