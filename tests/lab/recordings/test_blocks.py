"""A table is read in blocks, of which neither a number nor a refusal depends."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings import csv_table, read_table
from tendon_mj.lab.recordings.csv_table import write_csv

ROWS = "".join(f"{0.1 * k:.1f},{k}\n" for k in range(40))
FAULTS = {
    "a word": (ROWS.replace("\n3.0,30", "\n3.0,x"), "row 32, column 'a_N': 'x' is not a number"),
    "going back": (ROWS.replace("\n3.5,", "\n0.5,"), "row 37, column 'time_s': 0.5 does not"),
    "a cell too many": (ROWS.replace("\n3.5,35", "\n3.5,35,1"), "row 37, column 3: '1' is one"),
    "blank rows before the first": (40 * "\n" + "0.0,1\n", "missing; at least 2 rows"),
    "one row": ("0.0,1\n", "row 3: missing"),
    "no row": ("", "row 2: missing"),
}
SIZES = [1, 5, 30, 10_000]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("end", ["", "\n", "\n\n\n\n\n\n\n\n\n"])
@pytest.mark.parametrize("line_end", ["\n", "\r\n"])
def test_a_table_is_the_same(size, end, line_end, tmp_path, monkeypatch):
    monkeypatch.setattr(csv_table, "_CHUNK", size)
    path = tmp_path / "r.csv"
    path.write_bytes(("\ufefftime_s,a_N\n" + ROWS[:-1] + end).replace("\n", line_end).encode())
    table = read_table(path)
    assert_array_equal(table["time_s"], [float(f"{0.1 * k:.1f}") for k in range(40)])
    assert_array_equal(table["a_N"], np.arange(40.0))


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_told_at_its_row(size, fault, tmp_path, monkeypatch):
    monkeypatch.setattr(csv_table, "_CHUNK", size)
    text, message = FAULTS[fault]
    path = tmp_path / "r.csv"
    path.write_text("time_s,a_N\n" + text)
    with pytest.raises(RecordingError, match=message):
        read_table(path)


@given(
    st.lists(st.floats(-1e30, 1e30), min_size=2, max_size=30),
    st.integers(1, 200),
)
def test_what_is_written_reads_back_from_any_blocks(tmp_path_factory, values, size):
    path = tmp_path_factory.mktemp("blocks") / "r.csv"
    write_csv({"time_s": np.arange(float(len(values))), "a_N": np.array(values)}, path)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(csv_table, "_CHUNK", size)
        assert_array_equal(read_table(path)["a_N"], values)


@pytest.mark.parametrize("size", SIZES)
def test_a_row_that_is_far_too_long_is_refused_before_it_is_taken_apart(
    size, tmp_path, monkeypatch
):
    monkeypatch.setattr(csv_table, "_CHUNK", size)
    path = tmp_path / "r.csv"
    path.write_text("time_s,a_N\n0.0,1.0\n" + "," * 2**21 + "\n0.2,1.0\n")
    with pytest.raises(RecordingError, match=r"row 3: 1048576 characters or more; a row has fewer"):
        read_table(path)


@pytest.mark.parametrize("size", SIZES)
def test_more_numbers_than_a_recording_may_have_are_refused_where_they_are(
    size, tmp_path, monkeypatch
):
    monkeypatch.setattr(csv_table, "_CHUNK", size)
    monkeypatch.setattr(csv_table, "LARGEST", 320)  # bytes: twenty rows of two numbers
    path = tmp_path / "r.csv"
    rows = [f"{k},{k % 7}\n" for k in range(40)]
    path.write_text("time_s,a_N\n" + "".join(rows[:20]))
    assert read_table(path)["a_N"].size == 20
    path.write_text("time_s,a_N\n" + "".join(rows))
    with pytest.raises(RecordingError, match=r"row \d+: its numbers are more than 320 bytes"):
        read_table(path)
