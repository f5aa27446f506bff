"""Rigs of a fleet: folders, dates and descriptions."""

from datetime import datetime

import pytest

from tendon_mj.errors import RecordingError
from tendon_mj.fleet import find_rigs

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
    (tmp_path / "no recordings").mkdir()
    first, second = find_rigs(tmp_path)
    assert [path.name for path in first.tables.values()] == ["2026-03-04.csv", "2026-03-05.csv"]
    assert list(first.descriptions.values()) == [tmp_path / "description.toml"]
    assert list(second.descriptions.values()) == [tmp_path / "b" / "description.toml"]
    assert [recording.name for recording in first.read()] == ["2026-03-04", "2026-03-05"]


@pytest.mark.parametrize(
    ("names", "says"),
    [
        (["description.toml", "a/press.csv"], "no date"),
        (["description.toml", "a/20261399.csv"], "no date"),
        (["a/2026-03-04.csv"], "no 2026-03-04.toml beside it"),
        (["description.toml", "a/2026-03-04.csv", "a/b/20260304.csv"], "of one date"),
        (["description.toml", "2026-03-04.csv"], "no folder in it has recordings"),
    ],
)
def test_what_is_no_fleet_is_refused_with_the_way_out(tmp_path, names, says):
    written(tmp_path, *names)
    with pytest.raises(RecordingError, match=says):
        find_rigs(tmp_path)


def test_a_folder_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(RecordingError, match="is no folder"):
        find_rigs(tmp_path / "nowhere")


def test_a_rig_has_one_model(tmp_path):
    written(tmp_path, "description.toml", "a/2026-03-04.csv", "a/2026-03-05.csv")
    (tmp_path / "a" / "2026-03-05.toml").write_text(TOML.replace("bench", "finger"))
    (rig,) = find_rigs(tmp_path)
    with pytest.raises(RecordingError, match="a rig has one model"):
        rig.read()


def test_results_in_the_fleet_s_folder_are_no_rig(tmp_path):
    written(tmp_path, "description.toml", "a/2026-03-04.csv", "out/fleet/fleet.csv")
    assert [rig.name for rig in find_rigs(tmp_path, tmp_path / "out" / "fleet")] == ["a"]
    with pytest.raises(RecordingError, match="no date"):
        find_rigs(tmp_path)
