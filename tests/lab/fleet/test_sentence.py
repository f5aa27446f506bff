"""What is said of a change: its values in one unit, and the days between which it was."""

from datetime import datetime, timedelta

import numpy as np
import pytest

from tendon_mj.lab.fleet.number import Number
from tendon_mj.lab.fleet.sentence import change_sentence
from tendon_mj.lab.fleet.series import Series
from tendon_mj.lab.fleet.since import find_change

DATES = [datetime(2026, 3, 1) + timedelta(days=k) for k in range(8)]


def said(values, dates=DATES):
    """The sentence of what is found in a friction's values."""
    values = np.array(values)
    series = Series(
        number=Number("sheath.friction", "", "-", 0.01),
        parameter="sheath.friction",
        unit="-",
        probe=0.01,
        values=values,
        errors=np.full(values.size, 1e-3),
        square=np.ones(values.size),
        before=np.ones(values.size),
        range=np.array([0.0, 1.0]),
        others={},
    )
    found = find_change(dates, values, np.full(values.size, 2e-3))
    return change_sentence(found, series, [], dates)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ([0.15] * 4 + [0.25] * 4, "0.15 → 0.25 since 2026-03-05"),
        ([0.15] * 2 + [0.25] * 4 + [0.15] * 2,
         "0.15 → 0.25 from 2026-03-03 to 2026-03-06, 0.15 since"),
        ([0.15] * 3 + [0.25] * 2 + [0.18] * 3,
         "0.15 → 0.25 from 2026-03-04 to 2026-03-05, 0.18 since"),
        ([0.15] * 4 + [0.25] * 3 + [0.6], "0.15 → 0.25 since 2026-03-05, 2026-03-08 apart"),
        ([0.1, 0.1, 0.3, 0.15, 0.4, 0.2, 0.5, 0.3],
         "varies from 0.1 to 0.5, with no single change"),
        (0.15 + 0.02 * np.maximum(np.arange(8) - 2, 0), "0.15 → 0.25 growing since 2026-03-04"),
    ],
)  # fmt: skip
def test_a_course_is_told_with_the_values_that_the_rig_had(values, words):
    assert said(values) == f"sheath.friction {words}"


def test_after_a_gap_the_change_is_between_two_days():
    gap = [*DATES[:4], *(date + timedelta(days=60) for date in DATES[4:])]
    values = [0.15] * 4 + [0.22] * 4
    assert said(values, gap) == ("sheath.friction 0.15 → 0.22 between 2026-03-04 and 2026-05-04")
