"""Laws of tables as others write them: a map of columns, any clock, and what is left alone."""

from __future__ import annotations

import pickle
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from tendon_mj.cli.recordings import check
from tendon_mj.errors import RecordingError, TendonWarning
from tendon_mj.lab.recordings import Recording, files, read_recording, read_table
from tendon_mj.lab.units import proposed_name
from tests.lab.recordings import tables
from tests.lab.recordings.tables import log
from tests.refusals import refusing, silent

TIME = np.arange(60) * 0.02
REEL = 1e-3 * np.sin(2.0 * TIME)  # [m]
PULL = 20.0 + 3.0 * np.cos(5.0 * TIME)  # [N]
START = 1_766_147_454_233_218_000  # [ns] since 1970
DATES = np.datetime64(START, "ns") + (TIME * 1e9).astype("m8[ns]")
TOML = """model = "bench"
source = "made up"
[drive]
reel_m = "reel"
[measured]
pull_N = { sensor = "input_tension", noise = 0.05 }
"""
PLAIN = {"time_s": TIME, "reel_m": REEL, "pull_N": PULL}


def csv(rows: dict[str, object]) -> str:
    cells = [[str(cell) for cell in column] for column in rows.values()]
    return ",".join(rows) + "\n" + "".join(",".join(row) + "\n" for row in zip(*cells, strict=True))


def read(
    folder: Path, table: str, toml: str = "", above: str = "", name: str = "r.csv"
) -> Recording:
    (folder / name).write_text(table, encoding="utf-8")
    (folder / "r.toml").write_text(above + TOML + toml, encoding="utf-8")
    return read_recording(folder / name)


def is_plain(recording: Recording, within: float = 1e-12) -> None:
    assert list(recording.columns) == ["reel_m", "pull_N"]
    has_the_columns(recording, within)


def has_the_columns(recording: Recording, within: float = 1e-12) -> None:
    assert_allclose(recording.time - recording.time[0], TIME, atol=max(within, 1e-12))
    assert_allclose(recording.columns["reel_m"], REEL, atol=1e-12)
    assert_allclose(recording.columns["pull_N"], PULL, atol=1e-9)


def parquet(path: Path, toml: str = "", **columns: object) -> Path:
    path.with_suffix(".toml").write_text(TOML + toml)
    return tables.parquet(path, **columns)


# --- one map for all formats

COUNTS = np.mod(np.rint(REEL / 1e-3 / 0.01) + 4090.0, 4096.0)  # of 0.01 mm, begins again at 4096
ENTRY = 'factor = 0.01, offset = -40.9, unit = "mm", period = 4096'
MAP = f"""[columns]
reel_m = {{ column = "present_position", topic = "/servo", field = "position.1", {ENTRY} }}
pull_N = {{ column = "load", topic = "/cell", field = "adc", factor = -0.5, offset = 1.0 }}
"""
MAPPED = {"present_position": COUNTS, "load": (PULL - 1.0) / -0.5}


def is_mapped(recording: Recording) -> None:
    assert np.ptp(COUNTS) > 4000.0  # it does begin again
    assert_allclose(recording.time, TIME, atol=1e-9)
    assert_allclose(recording.columns["reel_m"], REEL, atol=0.51e-5)
    assert_allclose(recording.columns["pull_N"], PULL, atol=1e-9)
    assert recording.measured["pull_N"].noise == 0.05


def test_factor_offset_unit_and_period_are_the_same_in_csv_parquet_and_a_log(
    tmp_path: Path,
) -> None:
    is_mapped(read(tmp_path, csv({"time_s": TIME} | MAPPED), MAP))
    path = parquet(tmp_path / "p.parquet", time_s=TIME, **MAPPED)
    path.with_suffix(".toml").write_text(TOML + MAP)
    is_mapped(read_recording(path))
    messages = []
    for time, reel, pull in zip(TIME, *MAPPED.values(), strict=True):
        stamp = START + round(time * 1e9)
        messages.append(("/servo", stamp, {"position": [0.0, reel]}))
        messages.append(("/cell", stamp, {"adc": pull}))
    is_mapped(read_recording(log(tmp_path / "p.mcap", *messages)))


def test_elements_of_lists_and_fields_of_structs_of_parquet(tmp_path: Path) -> None:
    wrench = [{"force": {"x": f, "y": 0.0}} for f in PULL]
    position = [[0.0, r] for r in REEL]
    path = parquet(tmp_path / "r.parquet", time_s=TIME, position=position, wrench=wrench)
    text = '[columns]\nreel_m = "position.1"\npull_N = "wrench.force.x"\n'
    path.with_suffix(".toml").write_text(TOML + text)
    is_plain(read_recording(path))
    path.with_suffix(".toml").write_text(TOML + text.replace("force.x", "force.z"))
    with refusing(RecordingError, "[columns] 'pull_N': unknown column"):
        read_recording(path)
    path.with_suffix(".toml").write_text(TOML + text.replace("position.1", "position.2"))
    with refusing(RecordingError, "r.parquet, column 'position.2'"):
        read_recording(path)


def test_a_unit_in_the_file_s_own_name_is_heeded_or_asked_for(tmp_path: Path) -> None:
    table = csv({"t_ms": TIME * 1e3, "reel_mm": REEL * 1e3, "pull_N": PULL})
    columns = '[columns]\ntime_s = "t_ms"\nreel_m = "reel_mm"\n'
    is_plain(read(tmp_path, table, columns))
    said = '{ column = "reel_mm", factor = 0.001, unit = "m" }'
    is_plain(read(tmp_path, table, columns.replace('"reel_mm"', said)))
    for entry in ('{ column = "reel_mm", factor = 0.001 }', '"pull_N"'):
        with refusing(RecordingError, "[columns] 'reel_m':", "say unit = 'm'"):
            read(tmp_path, table, columns.replace('"reel_mm"', entry))


def test_another_unit_than_the_file_says_is_taken_and_told(tmp_path: Path) -> None:
    table = (
        "t_s,reel,pull\ns,inch,N\n"
        + csv({"t_s": TIME, "reel": REEL, "pull": PULL}).partition("\n")[2]
    )
    columns = '[columns]\ntime_s = "t"\nreel_m = { column = "reel", unit = "m" }\npull_N = "pull"\n'
    with pytest.warns(TendonWarning, match="unit = 'm' is taken, where .* says 'inch'"):
        is_plain(read(tmp_path, table.replace("t_s", "t", 1), columns))


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ('{ column = "a", factr = 1 }', "did you mean 'factor'?"),
        ('{ column = "a", factor = 0 }', "factor = 0.0 is outside"),
        ('{ column = "a", offset = inf }', "offset = inf is outside"),
        ('{ column = "a", period = -1 }', "period = -1.0 is outside"),
        ('{ column = "a", unit = "N" }', "unit: unknown unit 'N'"),
        ("{ factor = 2 }", "'topic' is missing"),
        ("3", "got 3"),
        ('"b"', "unknown column 'b'"),
    ],
)
def test_an_entry_of_the_map_is_refused_by_its_name(tmp_path: Path, entry: str, said: str) -> None:
    table = csv({"time_s": TIME, "a": REEL, "pull_N": PULL})
    with refusing(RecordingError, "r.toml, [columns] 'reel_m'", said):
        read(tmp_path, table, f"[columns]\nreel_m = {entry}\n")


# --- what is left alone


def test_columns_that_are_not_named_are_left_alone_whatever_is_in_them(tmp_path: Path) -> None:
    odd = {
        "": range(60),
        "state": ["PULLING", 'a "quoted, one"'.replace(",", ";")] * 30,
        "peak_n": ["nan"] * 60,
        "room_rad": ["", "1.0"] * 30,
        "spare_N": ["0.1"] * 59 + ["ERR"],
        "big_m": ["1e300"] * 60,
        "Größe": ["é"] * 60,
    }
    is_plain(read(tmp_path, csv(odd | PLAIN)))
    kept = read(tmp_path, csv(PLAIN | {"room_rad": TIME}))
    assert_array_equal(kept.columns["room_rad"], TIME)  # as context, as ever
    columns = {name: list(values) for name, values in odd.items() if name} | PLAIN
    is_plain(read_recording(parquet(tmp_path / "q.parquet", **columns)))


def test_rows_of_events_are_passed_over(tmp_path: Path) -> None:
    lines = csv(PLAIN | {"event": [""] * 60}).splitlines()
    lines.insert(20, f"{TIME[19]},,,contact")  # at the time of a sample
    lines[5:5] = ["", ",,,pause"]
    recording = read(tmp_path, "\n".join([*lines, "", ""]))
    is_plain(recording)
    assert [recording.row(k) for k in (0, 3, 4, 59)] == [2, 5, 8, 64]


@pytest.mark.parametrize("column", PLAIN)
@pytest.mark.parametrize("cell", ["", "nan", "-"])
def test_a_row_with_a_gap_is_left_out_and_said_and_no_number_is_made_up(
    tmp_path: Path, column: str, cell: str
) -> None:
    gaps = [7, 30]
    texts = {name: [str(value) for value in values] for name, values in PLAIN.items()}
    for gap in gaps:
        texts[column][gap] = cell
    said = rf"row 9, column '{column}': empty cell or nan; the row is left out \(and 1 more row\)"
    with pytest.warns(TendonWarning, match=said):
        recording = read(tmp_path, csv(texts))
    assert_array_equal(recording.time, np.delete(TIME, gaps))
    assert_array_equal(recording.columns["pull_N"], np.delete(PULL, gaps))
    assert recording.row(7) == 10
    if column != "time_s":  # friction remembers each rest
        with refusing(RecordingError, f"row 9, column '{column}'", "begin another recording"):
            read(tmp_path, csv(texts), "[timing]\nquasi_static = true\n")


@pytest.mark.parametrize(
    "footer", ["End of test", "# 60 rows, end", "Mean,0.1,20", "Max,1,2\nMin,,\n", "sum,,,1200,x"]
)
@pytest.mark.parametrize("preamble", ["", "Specimen,A,B,7\n\nby,me\n"])
def test_a_footer_is_left_out_and_said(tmp_path: Path, footer: str, preamble: str) -> None:
    row = 62 + preamble.count("\n")
    with pytest.warns(TendonWarning, match=f"row {row}, column 'time_s': .* is not a time; rows"):
        is_plain(read(tmp_path, f"{preamble}{csv(PLAIN)}{footer}\n"))


@pytest.mark.parametrize(
    ("separator", "decimal", "suffix"),
    [
        (";", ".", "csv"),
        (";", ",", "csv"),
        ("\t", ".", "tsv"),
        (" ", ".", "txt"),
        ("   ", ".", "dat"),
    ],
)
def test_other_separators_are_read(
    tmp_path: Path, separator: str, decimal: str, suffix: str
) -> None:
    lines = csv(PLAIN).replace(".", decimal).replace(",", separator)
    if decimal == ",":
        lines = csv(PLAIN).replace(",", ";").replace(".", ",")
    plain = read(tmp_path, csv(PLAIN))
    assert read(tmp_path, lines, name=f"r.{suffix}") == plain


@pytest.mark.parametrize("more", ["5", "5,6", "5,6,7"])
def test_rows_that_are_all_too_long_are_refused_and_not_shifted(tmp_path: Path, more: str) -> None:
    rows = "".join(f"{t},{t},20,{more}\n" for t in range(5))
    with refusing(RecordingError, "row 2, column 4: '5' is one cell too many"):
        read(tmp_path, f"time_s,reel_m,pull_N\n{rows}")
    with refusing(RecordingError, "row 4, column 4: '5'"):  # a decimal comma
        read(tmp_path, "time_s,reel_m,pull_N\n0,0,20\n1,0,20\n2,0,20,5\n")


# --- names


def test_a_table_without_names_takes_them_from_the_description(tmp_path: Path) -> None:
    body = csv({"frame": range(60)} | PLAIN).partition("\n")[2]
    header = 'header = ["frame", "time_s", "reel_m", "pull_N"]\n'
    recording = read(tmp_path, body, above=header)
    is_plain(recording)
    assert recording.row(0) == 1
    with refusing(RecordingError, "row 1:", "header =", "all 4 columns"):
        read(tmp_path, body)
    with refusing(RecordingError, "row 1: holds names, 'time_s'"):
        read(tmp_path, csv(PLAIN), above=header)
    with refusing(RecordingError, "row 1, column 4:", "one cell too many"):
        read(tmp_path, body, above='header = ["time_s", "reel_m", "pull_N"]\n')


def test_the_header_of_savetxt_is_read(tmp_path: Path) -> None:
    table = np.column_stack(list(PLAIN.values()))
    for header in (",".join(PLAIN), "logged by hand\n" + ",".join(PLAIN)):
        np.savetxt(tmp_path / "r.csv", table, delimiter=",", header=header)
        is_plain(read(tmp_path, (tmp_path / "r.csv").read_text()))
    np.savetxt(tmp_path / "r.txt", table, header=" ".join(PLAIN), fmt="%25.17e")
    is_plain(read(tmp_path, (tmp_path / "r.txt").read_text(), name="r.txt"))
    is_plain(read(tmp_path, "# made by hand\n\n" + csv(PLAIN)))


# --- clocks


@pytest.mark.parametrize(
    ("stamps", "entry", "within"),
    [
        (np.datetime_as_string(DATES), "time_s", 0),
        ([f"2026-03-02 10:15:{2 + t:05.2f}" for t in TIME], "time_s", 0),
        ([f"2026-03-02T10:15:{2 + t:05.2f}Z" for t in TIME], "time_ms", 0),
        ([f"2026-03-02T10:15:{2 + t:05.2f}+01:00" for t in TIME], "time_s", 0),
        ([f"0 days 00:00:{2 + t:09.6f}" for t in TIME], "time_s", 0),
        ([f"10:15:{2 + t:06.3f}" for t in TIME], "time_us", 0),
        ([START + round(t * 1e9) for t in TIME], "time_ns", 0),
        ([(START + round(t * 1e9)) // 1000 for t in TIME], "time_us", 0),
        ([1_766_147_454_233 + round(t * 1e3) for t in TIME], "time_ms", 1e-6),
        ([1_766_147_454 + t for t in TIME], "time_s", 3e-7),
    ],
)  # fmt: skip
def test_dates_and_times_since_1970_count_from_the_first_row(
    tmp_path: Path, stamps: list[object], entry: str, within: float
) -> None:
    table = {"timestamp": stamps, "reel_m": REEL, "pull_N": PULL}
    recording = read(tmp_path, csv(table), f'[columns]\n{entry} = "timestamp"\n')
    is_plain(recording, within or 2e-9)
    assert recording.time[0] == 0.0


def test_a_clock_of_three_years_is_a_date(tmp_path: Path) -> None:
    for first, dated in ((0.8e8, False), (1.2e8, True)):
        table = {"t": first + TIME, "reel_m": REEL, "pull_N": PULL}
        recording = read(tmp_path, csv(table), '[columns]\ntime_s = "t"\n')
        assert (recording.time[0] == 0.0) == dated


def test_dates_of_parquet_are_read_as_those_of_a_csv(tmp_path: Path) -> None:
    for dates in (DATES, DATES.astype("M8[us]"), DATES - DATES[0], [str(date) for date in DATES]):
        path = parquet(tmp_path / "r.parquet", when=dates, reel_m=REEL, pull_N=PULL)
        path.with_suffix(".toml").write_text(TOML + '[columns]\ntime_s = "when"\n')
        is_plain(read_recording(path), 1e-6)


def test_a_time_need_not_be_first_and_may_be_of_ticks(tmp_path: Path) -> None:
    is_plain(read(tmp_path, csv({"reel_m": REEL, "time_s": TIME, "pull_N": PULL})))
    ticks = csv({"tick": range(7, 67), "reel_m": REEL, "pull_N": PULL})
    recording = read(tmp_path, ticks, '[columns]\ntime_s = { column = "tick", factor = 0.02 }\n')
    is_plain(recording)
    assert recording.time[0] == pytest.approx(0.14)  # no date: the file's own zero is kept


@pytest.mark.parametrize("text", ["02.03.2026 10:15:02", "yesterday", "2026-13-45"])
def test_a_time_that_is_none_is_refused_at_its_row(tmp_path: Path, text: str) -> None:
    stamps = [f"2026-03-02T10:15:{2 + t:05.2f}" for t in TIME]
    stamps[3] = text
    table = csv({"when": stamps, "reel_m": REEL, "pull_N": PULL})
    with refusing(RecordingError, "row 5, column 'when':", "nor a time of ISO 8601"):
        read(tmp_path, table, '[columns]\ntime_s = "when"\n')
    numbers = [str(t) for t in TIME]
    numbers[3] = text
    with refusing(RecordingError, f"row 5, column 'time_s': {text!r} is neither a number"):
        read(tmp_path, csv(PLAIN | {"time_s": numbers}))


def test_a_clock_that_goes_back_is_refused_and_shown_as_written(tmp_path: Path) -> None:
    stamps = [f"2026-03-02T10:15:{2 + t:05.2f}" for t in TIME]
    stamps[3], stamps[4] = stamps[4], stamps[3]
    table = csv({"when": stamps, "reel_m": REEL, "pull_N": PULL})
    with refusing(RecordingError, "row 6,", ": 2026-03-02T10:15:02.06", "come after 2026"):
        read(tmp_path, table, '[columns]\ntime_s = "when"\n')


@pytest.mark.parametrize(("step", "resolution"), [(0.007, 0.01), (0.004, 0.01), (0.0099, 0.01)])
def test_equal_stamps_of_a_coarse_clock_are_spread_evenly_and_said(
    tmp_path: Path, step: float, resolution: float
) -> None:
    true = np.arange(60) * step
    shown = np.floor(true / resolution + 1e-9) * resolution
    with pytest.warns(TendonWarning, match=r"r\.csv, column 'time_s', row \d+: .* clock steps by"):
        recording = read(tmp_path, csv(PLAIN | {"time_s": shown}))
    steps = np.diff(recording.time)
    assert (steps > 0.0).all()
    assert_allclose(recording.time, true, atol=resolution)
    if step < 0.009:
        assert_allclose(steps, step, rtol=0.03)


def test_one_double_row_moves_no_other_time(tmp_path: Path) -> None:
    time = np.insert(TIME, 30, TIME[30])
    table = {"time_s": time, "reel_m": np.insert(REEL, 30, REEL[30]), "pull_N": [20.0] * 61}
    with pytest.warns(TendonWarning, match="row 33: 0.6 is the time of the row before;"):
        recording = read(tmp_path, csv(table))
    others = np.delete(np.arange(61), 31)
    assert_array_equal(recording.time[others], TIME)
    assert TIME[30] < recording.time[31] < TIME[31]
    with refusing(RecordingError, "column 'time_s': all times are 1.0"):
        read(tmp_path, csv(PLAIN | {"time_s": [1.0] * 60}))


# --- a row a message


def messages(drive: list[int], cell: list[int]) -> list[tuple[str, int, float]]:
    """(topic, stamp [ns], value), in order of time."""
    reel = [("/reel", START + t, 1e-3 * np.sin(1e-8 * t)) for t in drive]
    pull = [("/cell", START + t, 20.0 + 3e-9 * t) for t in cell]
    return sorted([*reel, *pull], key=lambda message: message[1])


RATES = {
    "turns": ([20_000_000 * k for k in range(50)], [7_000_000 + 20_000_000 * k for k in range(50)]),
    "fast and slow": ([1_000_000 * k for k in range(400)], [10**7 * k + 500 for k in range(41)]),
    "at common times": ([10**7 * k for k in range(80)], [2 * 10**7 * k for k in range(40)]),
    "two at one time": ([10**7 * k for k in range(40)] * 2, [3 * 10**6 * k for k in range(130)]),
}


@pytest.mark.parametrize("hold", [False, True])
@pytest.mark.parametrize("rates", RATES)
@pytest.mark.filterwarnings("ignore:.*have the time of a later one:tendon_mj.TendonWarning")
def test_a_table_of_messages_is_the_log_of_these_messages(
    tmp_path: Path, rates: str, hold: bool
) -> None:
    sent = messages(*RATES[rates])
    log(tmp_path / "r.mcap", *((topic, stamp, {"data": x}) for topic, stamp, x in sent))
    merged: dict[tuple[int, int], dict[str, float]] = {}
    for count, (topic, stamp, x) in enumerate(sent):
        same = rates == "at common times"
        merged.setdefault((stamp, 0 if same else count), {})[topic] = x
    rows = {
        "stamp": [stamp for stamp, _ in merged],
        "/reel/data": [row.get("/reel", "") for row in merged.values()],
        "/cell/data": [row.get("/cell", "") for row in merged.values()],
        "note": ["x"] * len(merged),
    }
    toml = """[columns]
time_ns = "stamp"
pull_N = { column = "/cell/data", topic = "/cell", field = "data" }
reel_m = { column = "/reel/data", topic = "/reel", field = "data" }
"""
    drive = 'reel_m = { actuator = "reel", hold = true }' if hold else 'reel_m = "reel"'
    text = TOML.replace('reel_m = "reel"', drive) + toml
    (tmp_path / "r.toml").write_text(text)
    (tmp_path / "r.csv").write_text(csv(rows))
    of_log, of_table = (read_recording(tmp_path / f"r.{suffix}") for suffix in ("mcap", "csv"))
    assert_allclose(of_table.time, of_log.time, atol=1e-12)
    for column in ("reel_m", "pull_N"):
        assert_allclose(of_table.columns[column], of_log.columns[column], rtol=1e-12)
    stamps = np.array(rows["stamp"])[[of_table.row(k) - 2 for k in range(of_table.time.size)]]
    assert_allclose((stamps - stamps[0]) * 1e-9, of_table.time, atol=1e-12)


def test_a_long_silence_is_said_and_a_column_without_a_value_refused(tmp_path: Path) -> None:
    cell = [t for t in RATES["turns"][1] if not 2 * 10**8 < t < 7 * 10**8]
    sent = messages(RATES["turns"][0], cell)
    rows = {
        "time_ns": [stamp for _, stamp, _ in sent],
        "reel_m": [x if topic == "/reel" else "" for topic, _, x in sent],
        "pull_N": [x if topic == "/cell" else "" for topic, _, x in sent],
    }
    with pytest.warns(TendonWarning, match=r"r\.csv: 'pull_N' has no value for"):
        read(tmp_path, csv(rows))
    dead = rows["pull_N"][:40] + [""] * (len(sent) - 40)
    with pytest.warns(TendonWarning, match="rows are left out: .* or 'pull_N' ends earlier"):
        assert read(tmp_path, csv(rows | {"pull_N": dead})).time[-1] < 0.5
    with refusing(RecordingError, "column 'pull_N': empty cell"):
        read(tmp_path, csv(rows | {"pull_N": [""] * len(sent)}))


# --- refusals


def cells_of(rows: dict[str, object], mark: str = ",", decimal: str = ".") -> str:
    return csv(rows).replace(",", mark).replace(".", decimal)


MICROS = (2**32 - 300_000 + TIME * 1e6).astype(int) % 2**32
# a table of an instrument, and the map with which it is read
INSTRUMENTS = {
    "units below the names": (
        csv({"time,reel,pull\ns": TIME, "mm": REEL / 1e-3, "N": PULL}),
        'reel_m = "reel"',
    ),
    "brackets, and other letters": (
        csv({"time,reel,pull\n[sec]": TIME, "(MM)": REEL / 1e-3, "": PULL}),
        'reel_m = "reel"\npull_N = "pull"',
    ),
    "a preamble": (
        '"Specimen","1"\n"Rate","10.00 mm/min"\n\n"t","reel_m","pull_N","no"\n'
        + csv({'"(s)"': TIME, '""': REEL, '"N"': PULL, "": PULL}),
        'time_s = "t"',
    ),
    "tabs and decimal commas": (
        cells_of({"Zeit [s]": TIME, "Weg [mm]": REEL / 1e-3, "Kraft [N]": PULL}, "\t", ","),
        'time_s = "Zeit [s]"\nreel_m = "Weg [mm]"\npull_N = "Kraft [N]"',
    ),
    "no clock": (csv({"reel_m": REEL, "pull_N": PULL}), "period"),
    "a counter of 32 bits": (
        csv({"n": MICROS, "reel_m": REEL, "pull_N": PULL}),
        'time_us = { column = "n", period = 4294967296 }',
    ),
}


@pytest.mark.parametrize("kind", INSTRUMENTS)
def test_tables_of_instruments_are_the_plain_table(tmp_path: Path, kind: str) -> None:
    table, columns = INSTRUMENTS[kind]
    if columns == "period":
        has_the_columns(read(tmp_path, table, above="period = 0.02\n"))
        return
    has_the_columns(read(tmp_path, table, f"[columns]\n{columns}\n"), 1e-6)


def test_micro_is_a_unit_and_mega_is_not_milli(tmp_path: Path) -> None:
    for micro in "µμu":
        table = csv(
            {f"time [{micro}s]": TIME / 1e-6, f"reel [{micro}m]": REEL / 1e-6, "pull_N": PULL}
        )
        columns = f'[columns]\ntime_s = "time [{micro}s]"\nreel_m = "reel [{micro}m]"\n'
        has_the_columns(read(tmp_path, table, columns))
    assert proposed_name("f [MN]") == "f_MN_UNIT"


@pytest.mark.parametrize(
    ("name", "stated"),
    [
        ("pull_N", "pull [lbs]"),
        ("pull_N", "pull (V)"),
        ("reel_m", "reel [in]"),
        ("time_s", "t_min"),
    ],
)
def test_a_unit_that_is_not_read_needs_a_factor(tmp_path: Path, name: str, stated: str) -> None:
    table = csv({(stated if n == name else n): values for n, values in PLAIN.items()})
    with refusing(RecordingError, f"{stated!r} is in ", "say factor = …"):
        read(tmp_path, table, f'[columns]\n{name} = "{stated}"\n')
    has_the_columns(
        read(
            tmp_path,
            table,
            f'[columns]\n{name} = {{ column = "{stated}", factor = 1.0000000001 }}\n',
        ),
        1e-6,
    )


def test_marks_between_thousands_beside_decimal_commas_are_refused(tmp_path: Path) -> None:
    with refusing(RecordingError, "'1.000' has a point", "'0,1' a comma for decimals"):
        read(tmp_path, "time_s;reel_m;pull_N\n0,1;0,0;999\n0,2;0,0;1.000\n")


@pytest.mark.parametrize(
    "above", ["Specimen,1,2", "Test,By,On\nA7,me,today", "By,Lab,Rig\nm,N,s", "Rate,50\n\nA,B,C"]
)
@pytest.mark.parametrize("units", ["", "s,mm,N\n", "[s],(mm),\n"])
def test_lines_of_a_preamble_are_neither_names_nor_units(
    tmp_path: Path, above: str, units: str
) -> None:
    reel = "reel" if units else "reel_m"
    body = csv(PLAIN | {"reel_m": REEL * 1e3} if units else PLAIN).partition("\n")[2]
    columns = f'[columns]\ntime_s = "time_s"\nreel_m = "{reel}"\n'
    names = f"time_s,{reel},pull_N\n"
    has_the_columns(read(tmp_path, f"{above}\n{names}{units}{body}", columns))


def test_rows_of_messages_are_those_of_the_file_below_a_preamble_and_units(tmp_path: Path) -> None:
    rows = csv({"s": TIME, "m": REEL, "N": PULL}).replace("\n0.04,", "\n0.04,x")
    with refusing(RecordingError, "row 7, column 'reel_m'", "is not a number"):
        read(tmp_path, f"Run,1\nBy,me\ntime,reel,pull\n{rows}")


def test_a_unit_of_a_second_header_holds_over_the_name_of_the_description(tmp_path: Path) -> None:
    table = csv({"time,reel,pull\ns": TIME, "mm": REEL / 1e-3, "mN": PULL / 1e-3})
    has_the_columns(read(tmp_path, table, '[columns]\nreel_m = "reel"\npull_N = "pull"\n'))
    with refusing(RecordingError, "'pull_N'", "which unit factor × number + offset is in"):
        read(tmp_path, table, '[columns]\npull_N = { column = "pull", offset = 1.0 }\n')


def test_a_row_of_units_that_contradicts_the_names_is_asked_for(tmp_path: Path) -> None:
    """Which is right is never guessed, neither from the names nor from the row below them."""
    body = csv({"s,mm,newton\n0.0": TIME[1:], "0.0": REEL[1:], "23.0": PULL[1:]})
    table = f"time_ms,reel_m,pull_N\n{body}"
    asked = (
        'time_s = { column = "time_ms [s]", unit = "unit?" }',
        'reel_m = { column = "reel_m [mm]", unit = "unit?" }',
    )
    with refusing(RecordingError, *asked, "two units of 'time_ms [s]'"):
        read(tmp_path, table)
    pasted = "[columns]\n" + "\n".join(asked)
    with refusing(RecordingError, "[columns] 'time_s', unit: say in which unit"):
        read(tmp_path, table, pasted)
    said = pasted.replace("unit?", "s", 1)
    with silent(TendonWarning):
        has_the_columns(read(tmp_path, table, said.replace("unit?", "m")))
        thousandth = read(tmp_path, table, said.replace("unit?", "mm"))
    assert_allclose(thousandth.columns["reel_m"], 1e-3 * REEL)
    with refusing(RecordingError, "'reel_m': which unit a number of 'reel_m [mm]' is in is"):
        read(
            tmp_path, table, said.replace('{ column = "reel_m [mm]", unit = "unit?" }', '"reel_m"')
        )


def test_a_row_of_units_that_repeats_those_of_the_names_is_passed_over(tmp_path: Path) -> None:
    is_plain(read(tmp_path, csv({"time_s,reel_m,pull_N\nsec": TIME, "(m)": REEL, "newton": PULL})))


@pytest.mark.parametrize(
    ("table", "above", "said"),
    [
        (csv(PLAIN) + csv(PLAIN), "", ("row 62: the names stand there again", "another recording")),
        (csv(PLAIN).replace("20.0,", "-,"), "period = 0.0\n", ()),
        (csv(PLAIN), "period = 0.02\n", ("period = 0.02", "'time_s' is one; take period out")),
        (csv(PLAIN), "period = -1\n", ("period = -1.0 [s] is outside",)),
        (csv({"reel_m": REEL, "pull_N": PULL}), "", ("no column is named 'time_s'", "period = …")),
        (
            "time_s\treel_m\tpull_N\n1\t0\t1,234\n2\t0\t1,250\n",
            "",
            ("'1,234' has a comma for decimals or for thousands",),
        ),
        (
            csv(PLAIN | {"time_s": MICROS}),
            "",
            ("row 17, column 'time_s'", 'time_s = { column = "time_s", period = 4294967296 }'),
        ),
    ],
)
def test_tables_that_are_not_read_are_refused_with_a_way_out(
    tmp_path: Path, table: str, above: str, said: tuple[str, ...]
) -> None:
    if not said:
        read(tmp_path, table, above=above)
        return
    with refusing(RecordingError, "r.", *said):
        read(tmp_path, table, above=above)


@pytest.mark.parametrize("name", ["motor_mA", "Motor [mA]", "current_A"])
def test_a_current_is_no_force_before_its_factor_is_said(tmp_path: Path, name: str) -> None:
    table = csv({"time_s": TIME, "reel_m": REEL, name: PULL / 2.5})
    with refusing(RecordingError, "pull_N", repr(name), "is a current", "factor = …"):
        read(tmp_path, table, f'[columns]\npull_N = "{name}"\n')
    entry = f'[columns]\npull_N = {{ column = "{name}", factor = 2.5 }}\n'
    has_the_columns(read(tmp_path, table, entry))
    (tmp_path / "r.toml").write_text(TOML.replace("pull_N", '"motor_mA"'))
    if name == "motor_mA":
        with refusing(RecordingError, "'motor_mA' is of a current", "motor_Nm = "):
            read_recording(tmp_path / "r.csv")


def test_a_clock_that_goes_back_is_no_counter_that_begins_again(tmp_path: Path) -> None:
    time = (TIME * 1e6).astype(int)
    time[30] = time[28]
    entry = '[columns]\ntime_us = { column = "n", period = 4294967296 }\n'
    with refusing(RecordingError, "row 32, column 'n': 560000 does not come after 580000"):
        read(tmp_path, csv({"n": time, "reel_m": REEL, "pull_N": PULL}), entry)


@pytest.mark.parametrize("numbers", [False, True])
def test_times_of_day_over_midnight_are_refused_as_that(tmp_path: Path, numbers: bool) -> None:
    seconds = [(86395 + k) % 86400 for k in range(10)]
    clock = [f"{s // 3600:02}:{s // 60 % 60:02}:{s % 60:02}" for s in seconds]
    table = csv({"time_s": seconds if numbers else clock, "reel_m": REEL[:10], "pull_N": PULL[:10]})
    with refusing(RecordingError, "row 7,", "begins again at midnight", "with their date"):
        read(tmp_path, table)


NANOSECONDS = np.rint(TIME * 1e9).astype(int) + 1_700_000_000_500_000_000
STAMPS = {"stamp.sec": NANOSECONDS // 10**9, "stamp.nanosec": NANOSECONDS % 10**9}


@pytest.mark.parametrize(
    ("rows", "way_out"),
    [
        ([*range(40), *range(20)], "row 42, | make the rows from there on another recording"),
        ([*range(20), *range(21, 19, -1), *range(22, 60)], "row 23, | sort the rows by their"),
        ([1, 0, *range(2, 60)], "row 3, | sort the rows by their times"),
    ],
)
def test_a_clock_that_goes_back_is_refused_with_what_to_do(
    tmp_path: Path, rows: list[int], way_out: str
) -> None:
    """As of a logger that was started again, and of rows that are out of order."""
    table = csv({"time_ms": 1e3 * TIME[rows], "reel_m": REEL[rows], "pull_N": PULL[rows]})
    with refusing(RecordingError, "column 'time_ms'", "does not come after", way_out):
        read(tmp_path, table)


def test_nanoseconds_beside_seconds_are_read_as_is_said_of_them(tmp_path: Path) -> None:
    table = csv(STAMPS | {"reel_m": REEL, "pull_N": PULL})
    entry = 'time_ns = { column = "stamp.nanosec", period = 1000000000 }'
    with refusing(RecordingError, "no column is named 'time_s'", entry):
        read(tmp_path, table)
    with refusing(RecordingError, "row 27, column 'stamp.nanosec': 0 does not", f"write | {entry}"):
        read(tmp_path, table, '[columns]\ntime_ns = "stamp.nanosec"\n')
    has_the_columns(read(tmp_path, table, f"[columns]\n{entry}\n"))


@pytest.mark.parametrize("top", [4095, 5000])
def test_a_period_below_the_counts_of_a_column_is_refused(tmp_path: Path, top: int) -> None:
    counts = np.linspace(0.0, top, 60).round()
    table = csv({"time_s": TIME, "reel_m": REEL, "raw": counts})
    entry = '[columns]\npull_N = { column = "raw", factor = 0.001, period = 4096 }\n'
    if top < 4096:
        assert read(tmp_path, table, entry).columns["pull_N"].size == 60
        return
    with refusing(RecordingError, "'raw': goes from 0 to 5000,", "period = 4096"):
        read(tmp_path, table, entry)


UNSAID = {"reel": ("reel.pos", "Reel", "reel_2"), "pull": ("pull", "cell.pull"), "t": ("t", "Time")}
SAID = {
    "reel": (("reel [mm]", 1e-3), ("Reel (um)", 1e-6), ("reel_m", 1.0), ("REEL_inch", 0.0254)),
    "pull": (("Pull [mN]", 1e-3), ("pull (N)", 1.0), ("pull_kgf", 9.80665)),
    "t": (("Time [ms]", 1e-3), ("time_s", 1.0), ("t (us)", 1e-6)),
}
DECOYS = ("reel_ref", "reel [deg]", "pull_zero [N]", "reel 2 (mm)", "Pull", "time_of_day", "note")


def test_what_is_proposed_for_columns_is_what_the_file_says_or_is_refused_when_pasted(
    tmp_path: Path,
) -> None:
    """A guess is asked for: of tables with and without units and with decoys, none is misread."""
    rng, outcomes = np.random.default_rng(3), {"read": 0, "refused": 0}
    truth = {"t": TIME, "reel": REEL, "pull": PULL}
    for _ in range(100):
        columns: dict[str, object] = {}
        for name, values in truth.items():
            if rng.random() < 0.3:
                column, unit = str(rng.choice(UNSAID[name])), float(rng.choice([1.0, 1e-3, 1e-6]))
            else:
                column, unit = SAID[name][rng.integers(len(SAID[name]))]
            columns[column] = values / unit
        for decoy in rng.choice(DECOYS, rng.integers(3), replace=False).tolist():
            columns.setdefault(decoy, 7.0 * PULL)
        shuffled = rng.permutation(list(columns)).tolist()
        table = csv({name: columns[name] for name in shuffled})
        try:
            recording = read(tmp_path, table)
        except RecordingError as refused:
            _, _, lines = str(refused).partition("[columns]\n")
            assert lines
            try:
                recording = read(tmp_path, table, f"[columns]\n{lines}\n")
            except RecordingError:
                outcomes["refused"] += 1
                continue
        outcomes["read"] += 1
        has_the_columns(recording)
    assert min(outcomes.values()) > 20


def test_check_reads_the_recordings_of_a_folder(tmp_path: Path) -> None:
    folder = tmp_path / "session"
    folder.mkdir()
    with refusing(RecordingError, "session: a folder without a table"):
        check((folder,), out=tmp_path / "out")
    for name in ("a.csv", "b.csv"):
        (folder / name).write_text(csv(PLAIN))
    (folder / "r.toml").write_text(TOML)
    result = check((folder,), out=tmp_path / "out", description=folder / "r.toml")
    assert [one["name"] for one in result["recordings"]] == ["a", "b"]  # type: ignore[attr-defined]


class Bomb:
    def __reduce__(self) -> tuple[object, tuple[str]]:
        return sys.exit, ("unpickled",)


@pytest.mark.parametrize("suffix", [*files._OTHERS, *files._ALIKE, ".mystery", ""])
def test_a_file_of_another_format_is_named_as_that_and_not_opened(
    tmp_path: Path, suffix: str
) -> None:
    path = tmp_path / f"rec{suffix}"
    path.write_bytes(pickle.dumps(Bomb()))
    for described in (False, True):
        if described:
            (tmp_path / "rec.toml").write_text(TOML)
        with pytest.raises(RecordingError, match=r"Parquet, MCAP, .* are read: ") as caught:
            read_recording(path, tmp_path / "rec.toml" if described else None)
        assert str(caught.value).startswith(f"{path}: ")
        assert "no such file" not in str(caught.value)
    with refusing(RecordingError, "datasets of LeRobot are read:"):
        read_table(path)
    path.unlink()
    with refusing(RecordingError, "no such file"):
        read_recording(path)
    (tmp_path / f"rec{suffix}.csv").write_text(csv(PLAIN))  # of which this path is the stem
    (tmp_path / f"rec{suffix}.toml").write_text(TOML)
    is_plain(read_recording(path))
