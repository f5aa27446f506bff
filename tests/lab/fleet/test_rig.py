"""Rigs of a fleet: folders, dates and descriptions."""

import re
from datetime import datetime

import pytest

from tendon_mj.errors import RecordingError
from tendon_mj.lab.fleet import find_rigs

TOML = 'model = "bench"\nsource = "a test"\n[drive]\nreel_m = "reel"\n'
CSV = "time_s,reel_m\n0.0,0.0\n0.1,0.001\n"


def written(folder, *names):
    for name in names:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(CSV if path.suffix == ".csv" else TOML, encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "date"),
    [
        ("2026-03-04.csv", datetime(2026, 3, 4)),
        ("20260304.csv", datetime(2026, 3, 4)),
        ("press_2026_03_04.csv", datetime(2026, 3, 4)),
        ("2026-03-04T14-30.csv", datetime(2026, 3, 4, 14, 30)),
        ("run7_20260304-143015.csv", datetime(2026, 3, 4, 14, 30, 15)),
        ("2026-03-04/press.csv", datetime(2026, 3, 4)),
        ("2026-03-04/raw/press_12.csv", datetime(2026, 3, 4)),
    ],
)
def test_a_date_is_in_the_file_s_name_or_in_a_folder_s(tmp_path, name, date):
    written(tmp_path, "description.toml", f"hand/{name}")
    (rig,) = find_rigs(tmp_path)
    assert rig.name == "hand"
    assert rig.dates == (date,)


def test_recordings_are_in_the_order_of_time_and_described_by_the_nearest_toml(tmp_path):
    written(
        tmp_path, "description.toml", "a/2026-03-05.csv", "a/2026-03-04.csv", "a/2026-03-04.toml"
    )
    written(tmp_path, "b/description.toml", "b/2026-03-04.csv", ".hidden/2026-03-04.csv")
    first, second = find_rigs(tmp_path)
    assert [path.name for path in first.tables.values()] == ["2026-03-04.csv", "2026-03-05.csv"]
    assert list(first.descriptions.values()) == [tmp_path / "description.toml"]
    assert list(second.descriptions.values()) == [tmp_path / "b" / "description.toml"]
    assert [recording.name for recording in first.read()] == ["2026-03-04", "2026-03-05"]


@pytest.mark.parametrize(
    ("names", "says"),
    [
        (["description.toml", "a/2026-03-04.csv", "a/notes.csv"], "notes.csv: no date"),
        (["description.toml", "a/20261399.csv"], "no date"),
        (["description.toml", "a/2026-03-04_2026-03-05.csv"], "a/2026.*two days"),
        (["a/2026-03-04.csv"], "no 2026-03-04.toml beside it"),
        (["description.toml", "a/2026-03-04.csv", "a/b/20260304.csv"], "of one date"),
        (["a/description.toml"], "a: no recordings"),
    ],
)
def test_what_cannot_be_told_apart_is_an_error_of_that_rig_alone(tmp_path, names, says):
    written(tmp_path, *names, "b/description.toml", "b/2026-03-04.csv")
    first, second = find_rigs(tmp_path)
    assert re.search(says, first.error)
    assert not first.dates
    assert not second.error


@pytest.mark.parametrize(
    ("names", "says"),
    [
        (["description.toml"], "no folder in it has recordings"),
        (["description.toml", "a/description.toml"], "no folder in it has recordings"),
        (["a/2026-03-04.csv", "2026-03-05.csv"], "2026-03-05.csv lies directly in the fleet's"),
    ],
)
def test_what_is_no_fleet_is_refused_with_the_way_out(tmp_path, names, says):
    written(tmp_path, *names)
    with pytest.raises(RecordingError, match=says):
        find_rigs(tmp_path)


def test_linked_days_are_recordings_and_a_link_upwards_is_no_end(tmp_path):
    written(tmp_path, "fleet/description.toml", "fleet/a/2026-03-04.csv", "store/day/press.csv")
    (tmp_path / "fleet" / "a" / "2026-03-05").symlink_to(tmp_path / "store" / "day")
    (tmp_path / "fleet" / "a" / "up").symlink_to(tmp_path / "fleet" / "a")
    (tmp_path / "fleet" / "a" / "2026-03-06.csv").symlink_to(tmp_path / "gone.csv")
    (rig,) = find_rigs(tmp_path / "fleet")
    assert [date.day for date in rig.dates] == [4, 5, 6]  # what is gone fails when it is read
    assert not rig.error


def test_a_rig_whose_folder_results_would_go_to_is_refused(tmp_path):
    written(tmp_path, "description.toml", "a/2026-03-04.csv", "rigs/2026-03-04.csv")
    with pytest.raises(RecordingError, match=r"rigs has recordings.*--out"):
        find_rigs(tmp_path, tmp_path / "rigs")
    with pytest.raises(RecordingError, match=r"a has recordings.*--out"):
        find_rigs(tmp_path, tmp_path / "a" / "out" / "rigs")


def test_a_folder_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(RecordingError, match="is no folder"):
        find_rigs(tmp_path / "nowhere")


def test_a_rig_has_one_model(tmp_path):
    written(tmp_path, "description.toml", "a/2026-03-04.csv", "a/2026-03-05.csv")
    (tmp_path / "a" / "2026-03-05.toml").write_text(TOML.replace("bench", "finger"))
    (rig,) = find_rigs(tmp_path)
    with pytest.raises(RecordingError, match="a rig has one model"):
        rig.read()


def test_what_cannot_be_read_is_left_out_with_its_reason(tmp_path):
    written(tmp_path, "description.toml", "a/2026-03-04.csv", "a/2026-03-05.csv")
    written(tmp_path, "a/2026-03-06.csv", "a/2026-03-07.csv")
    (tmp_path / "a" / "2026-03-04.csv").write_text("time_s\n")
    (tmp_path / "a" / "2026-03-06.toml").write_text(TOML.replace("bench", "finger"))
    (rig,) = find_rigs(tmp_path)
    found, refused = rig.read_each()
    assert [recording.name for recording in found.values()] == ["2026-03-05", "2026-03-07"]
    assert [date.day for date in refused] == [4, 6]
    assert "2026-03-04.csv" in refused[rig.dates[0]]
    assert "a rig has one model" in refused[rig.dates[2]]
    assert rig.read_first().name == "2026-03-05"
    assert rig.without(refused).dates == tuple(found)


def test_a_rig_of_which_nothing_can_be_read_says_so_with_the_first_reason(tmp_path):
    written(tmp_path, "description.toml", "a/2026-03-04.csv", "a/2026-03-05.csv")
    for path in (tmp_path / "a").iterdir():
        path.write_text("time_s\n")
    (rig,) = find_rigs(tmp_path)
    with pytest.raises(RecordingError, match=r"none of its 2 recordings .* the first: .*-04\.csv"):
        rig.read_first()


def test_a_model_s_file_is_one_by_whatever_way_it_is_named(tmp_path):
    written(tmp_path, "description.toml", "a/2026-03-04.csv", "a/2026-03-05.csv")
    (tmp_path / "m.xml").touch()
    (tmp_path / "description.toml").write_text(TOML.replace("bench", "m.xml"))
    (tmp_path / "a" / "2026-03-05.toml").write_text(TOML.replace("bench", "../m.xml"))
    (rig,) = find_rigs(tmp_path)
    assert len(rig.read()) == 2


def test_results_in_the_fleet_s_folder_are_no_rig(tmp_path):
    written(tmp_path, "description.toml", "a/2026-03-04.csv", "out/fleet/fleet.csv")
    assert [rig.name for rig in find_rigs(tmp_path, tmp_path / "out" / "fleet")] == ["a"]
    assert [rig.name for rig in find_rigs(tmp_path)] == ["a"]


def test_earlier_results_are_no_rig_either_unless_recordings_lie_there(tmp_path):
    written(tmp_path, "description.toml", "a/2026-03-04.csv", "old/fleet.csv")
    assert [rig.name for rig in find_rigs(tmp_path)] == ["a"]
    written(tmp_path, "old/2026-03-04.csv")
    assert [rig.name for rig in find_rigs(tmp_path)] == ["a", "old"]


def test_a_name_that_is_no_text_is_an_error_of_that_rig_alone(tmp_path):
    written(tmp_path, "description.toml", "rig_1/2026-03-01.csv", "rig_2/2026-03-01_\udcff.csv")
    written(tmp_path, "rig_\udcff/2026-03-01.csv")
    good, other, bad = find_rigs(tmp_path)
    assert good.error == ""
    assert (other.name, bad.name) == ("rig_2", "rig_\\udcff")
    for rig in (other, bad):
        assert "its name are not UTF-8; rename it" in rig.error
        rig.error.encode()
