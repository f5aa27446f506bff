"""A rig in the formats of others is the CSV of it, or a sentence says what to write."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

pytest.importorskip("rosbags")
pytest.importorskip("mcap")
pytest.importorskip("pyarrow")

from experiments.formats import FORMATS, agrees, compared
from tendon_mj import example_rig

SAID = {
    "dashes": "the row is left out (and 8 more rows)",
    "started twice": "make it the first row of another recording",
    "-100 to 100, not said": 'unit = "unit?"',
    "ms that are s": "name the column so: 'time_s'",
}


def test_each_format_is_the_csv_or_says_what_to_write(tmp_path: Path) -> None:
    shutil.copy(Path(example_rig()) / "rig.xml", tmp_path)
    plain, *others = compared(tmp_path, 60, tuple(FORMATS))
    assert [one.format for one in others if agrees(one, plain)] == [
        name for name in FORMATS if name not in (*SAID, "CSV")
    ]
    for one in others:
        assert bool(one.said) == (one.format in SAID)
        assert SAID.get(one.format, "") in "\n".join(one.said)
