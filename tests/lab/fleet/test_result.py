"""Text of a fleet's result: changes with their values and days, remarks, verdicts."""

from dataclasses import replace
from datetime import datetime, timedelta

import numpy as np
import pytest

from tendon_mj.lab.fleet import FleetResult, RigResult
from tendon_mj.lab.fleet.changes import find_change
from tendon_mj.lab.fleet.observation import Number, NumberSeries
from tendon_mj.lab.fleet.result import (
    change_sentence,
    other_kind,
    unlike,
)

DATES = tuple(datetime(2026, 3, 1) + timedelta(days=k) for k in range(8))
RIG = RigResult(name="hand", dates=DATES, misfit=1.1, left=1.1, compared=5)


def sentence(values, dates=DATES):
    """The sentence on a change of a friction."""
    values = np.array(values)
    series = NumberSeries(
        number=Number("sheath.friction", "", "-", 0.01),
        parameter="sheath.friction",
        unit="-",
        probe=0.01,
        values=values,
        errors=np.full(values.size, 1e-3),
        apart=values,
        errors_apart=np.full(values.size, 1e-3),
        square=np.ones(values.size),
        range=np.array([0.0, 1.0]),
        others={},
    )
    change = find_change(dates, values, np.full(values.size, 2e-3))
    return change_sentence(change, series, [], dates)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ([0.15] * 4 + [0.25] * 4, "0.15 → 0.25 since 2026-03-05"),
        ([0.15] * 2 + [0.25] * 4 + [0.15] * 2,
         "0.15 → 0.25 from 2026-03-03 to 2026-03-06, 0.15 since"),
        ([0.15] * 3 + [0.25] * 2 + [0.18] * 3,
         "0.15 → 0.25 from 2026-03-04 to 2026-03-05, 0.18 since"),
        ([0.15] * 4 + [0.25] * 3 + [0.6], "0.15 → 0.25 since 2026-03-05, except 2026-03-08"),
        ([0.1, 0.1, 0.3, 0.15, 0.4, 0.2, 0.5, 0.3],
         "varies from 0.1 to 0.5, with no single change"),
        (0.15 + 0.02 * np.maximum(np.arange(8) - 2, 0), "0.15 → 0.25 growing since 2026-03-04"),
    ],
)  # fmt: skip
def test_a_course_is_stated_with_its_values_and_days(values, words):
    assert sentence(values) == f"sheath.friction {words}"


def test_after_a_gap_the_change_is_between_two_days():
    def gap(days):
        return [*DATES[:4], *(date + timedelta(days=days) for date in DATES[4:])]

    values = [0.15] * 4 + [0.22] * 4
    words = "sheath.friction 0.15 → 0.22 between 2026-03-04 and 2026-05-04"
    assert sentence(values, gap(60)) == words
    assert "between" not in sentence(values, gap(0.7))
    assert "between" in sentence(values, gap(1.4))


def test_a_rig_of_another_model_or_description_has_a_remark():
    usual = {"model": "a", "[known]": "[]", "[uncertain]": "x"}
    kinds = {f"rig_{k}": usual for k in range(4)}
    kinds |= {"other": {**usual, "model": "b"}, "both": {**usual, "[known]": "y", "model": "b"}}
    parts = unlike(kinds)
    assert parts == {"other": ["model"], "both": ["model", "[known]"]}
    assert other_kind(parts["other"]).startswith("its model differs")
    assert other_kind(parts["both"]).startswith("its model and [known] differ")
    assert not other_kind(())
    assert not unlike({"rig_0": usual})


@pytest.mark.parametrize(
    ("days", "compared", "verdict", "needs"),
    [
        (6, 5, "consistent with the fleet", []),
        (6, 4, "unchanged", ["5 fitted rigs or more, and there are 4"]),
        (3, 5, "consistent with the fleet", ["4 recordings or more, and there are 3"]),
        (3, 1, "not judged", ["4 recordings or more, and there are 3", "there are 1"]),
    ],
)
def test_a_missing_judgement_is_reported_with_what_it_needs(days, compared, verdict, needs):
    rig = replace(RIG, dates=DATES[:days], compared=compared)
    assert rig.verdict == verdict
    assert rig.sentence({}).startswith(f"hand: {verdict}")
    assert all(part in rig.sentence({}) for part in needs)


def test_a_fleet_that_its_model_does_not_describe_has_a_warning():
    ill, nearly = replace(RIG, left=3.4), replace(RIG, left=2.6)
    assert "3.4 times the noise" in FleetResult([ill, ill, RIG], {}, {}).warning
    assert not FleetResult([nearly, nearly, RIG], {}, {}).warning
    assert not FleetResult([ill, RIG, RIG], {}, {}).warning
    assert not FleetResult([replace(RIG, error="no recordings")], {}, {}).warning
