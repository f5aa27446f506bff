"""Dates in names: a day with separators first, a time of day only where it is one."""

from datetime import datetime

import pytest

from tendon_mj.errors import RecordingError
from tendon_mj.lab.fleet.date_in_name import date_in_name

DAY = datetime(2026, 3, 1)
HALF = datetime(2026, 3, 1, 14, 30)
FULL = datetime(2026, 3, 1, 14, 30, 5)


@pytest.mark.parametrize(
    ("name", "date"),
    [
        ("2026-03-01", DAY),
        ("2026-03-01a", DAY),
        ("2026-03-01 (2)", DAY),
        ("20260301", DAY),
        ("SN20231105_2026-03-01", DAY),
        ("20260301_20260301", DAY),
        ("2026-03-01_0042", DAY),
        ("2026-03-01_9999", DAY),
        ("2026-03-01_001", DAY),
        ("2026-03-01_100001", DAY),
        ("2026-03-01_Trial3", DAY),
        ("20260301_9999", DAY),
        ("2026-03-01T14", HALF.replace(minute=0)),
        ("2026-03-01T14-30", HALF),
        ("2026-03-01 14:30", HALF),
        ("2026-03-01 1430", HALF),
        ("2026-03-01_14-30_002", HALF),
        ("20260301T1430", HALF),
        ("20260301_1430", HALF),
        ("2026_03_01-14h30m05", FULL),
        ("take_20260301143005", FULL),
        ("2026-03-01T14:30:05", FULL),
        ("2026-03-01T14-30-05.250", FULL.replace(microsecond=250000)),
        ("2026-03-01T14-30Z", HALF),
        ("2026-03-01T16-30+02:00", HALF),
        ("2026-03-01T16-30+02-00", HALF),
        ("2026-03-01T23:30:05+0900", FULL),
        ("2026-03-01T12:30:05-02:00", FULL),
        ("2026-02-28T22-30-0000", datetime(2026, 2, 28, 22, 30)),
    ],
)
def test_a_date_is_read_as_it_is_written(name, date):
    assert date_in_name(name) == date


@pytest.mark.parametrize(
    "name", ["press", "20261303", "run_10001231", "00010101", "1772323200", "2026-060", "17760704"]
)
def test_other_digits_are_no_date(name):
    assert date_in_name(name) is None


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("2026-03-01_2026-03-02", "two days, 2026-03-01 and 2026-03-02"),
        ("SN20231105_20260301", "two days"),
        ("2026-03-01T9999", "'T9999' is no time of day"),
        ("2026-03-01 10-30 pm", "24 hours"),
        ("2026-03-01T10-30+99:00", "no time zone"),
    ],
)
def test_what_may_be_read_in_two_ways_is_refused_by_name(name, says):
    with pytest.raises(RecordingError, match=says) as refusal:
        date_in_name(name)
    assert name in str(refusal.value)
