"""What is said of a rig beyond its verdict, and of a fleet that is small or badly described."""

from dataclasses import replace
from datetime import datetime, timedelta

import numpy as np
import pytest

from tendon_mj.lab.fleet import FleetFound, RigFound
from tendon_mj.lab.fleet.remarks import left_over, odd_day, odd_times, unlike
from tendon_mj.lab.recordings import Recording

DATES = tuple(datetime(2026, 3, 1) + timedelta(days=k) for k in range(6))
RIG = RigFound(name="hand", dates=DATES, values={}, errors={}, misfit=1.1, left=1.1, fellows=5)


def test_a_rig_of_another_model_or_description_is_told_so():
    usual = {"model": "a", "[known]": "[]", "[uncertain]": "x"}
    kinds = {f"rig_{k}": usual for k in range(4)}
    kinds |= {"other": {**usual, "model": "b"}, "both": {**usual, "[known]": "y", "model": "b"}}
    found = unlike(kinds)
    assert set(found) == {"other", "both"}
    assert found["other"].startswith("its model is not as on most rigs")
    assert found["both"].startswith("its model and [known] are not as on most rigs")
    assert not unlike({"rig_0": usual})


def test_a_misfit_that_lies_in_one_recording_is_told_with_its_day():
    told = odd_day(DATES, [1.0, 1.2, 0.9, 1.0, 1.1, 64.0], 1.1)
    assert told == "most of its misfit is on 2026-03-06, 8 noise"
    assert not odd_day(DATES, [9.0, 8.0, 9.0, 9.0, 9.0, 64.0 / 4], 1.1)
    assert not odd_day(DATES, [0.1, 0.1, 0.1, 0.1, 0.1, 3.0], 1.1)
    assert not odd_day(DATES[:2], [1.0, 64.0], 1.1)


def test_what_a_change_leaves_is_told_where_it_is_well_above_the_usual():
    assert left_over(4.1, 1.2).startswith("4.1 noise is left")
    assert not left_over(1.5, 1.2)


@pytest.mark.parametrize(
    ("days", "fellows", "verdict", "says"),
    [
        (6, 5, "as its fellows", []),
        (6, 4, "unchanged", ["5 or more could be fitted, here 4"]),
        (3, 5, "as its fellows", ["4 recordings or more, here 3"]),
        (3, 1, "not judged", ["4 recordings or more, here 3", "here 1"]),
    ],
)
def test_what_was_not_judged_is_told_with_what_it_takes(days, fellows, verdict, says):
    rig = replace(RIG, dates=DATES[:days], fellows=fellows)
    assert rig.verdict == verdict
    assert rig.sentence({}).startswith(f"hand: {verdict}")
    assert all(part in rig.sentence({}) for part in says)


def test_a_rig_with_a_remark_is_told_and_a_plain_one_not():
    fleet = FleetFound([RIG, replace(RIG, name="odd", remarks=("its model is another",))], {}, {})
    assert [rig.name for rig in fleet.told] == ["odd"]
    assert fleet.told[0].sentence({}) == "odd: as its fellows; its model is another."


def test_a_fleet_whose_model_does_not_describe_it_is_warned_of():
    ill = replace(RIG, left=40.0)
    assert "40 times the noise" in FleetFound([ill, ill, RIG], {}, {}).warning
    assert not FleetFound([ill, RIG, RIG], {}, {}).warning
    assert not FleetFound([replace(RIG, error="no recordings")], {}, {}).warning


def test_numbers_agree():
    assert FleetFound([RIG], {}, {}).sentence == "Of 1 rig 0 changed."
    failed = replace(RIG, error="x", dates=())
    assert FleetFound([failed, RIG], {}, {}).table()[0]["first"] == ""


def test_odd_times_are_told_once_a_kind():
    time = np.concatenate([np.arange(200) * 0.01, 7.0 + np.arange(200) * 0.01])
    recordings = [
        Recording(name=f"day_{k}", model="m", source="s", time=time, columns={"a_m": 0.0 * time})
        for k in range(3)
    ]
    (told,) = odd_times(recordings)
    assert told.startswith("day_0, column 'time_s': 1 gap")
    assert told.endswith("so in 3 recordings")
    assert not odd_times([replace(recordings[0], time=np.arange(400) * 0.01)])
