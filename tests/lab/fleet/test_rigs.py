"""Rigs of a fleet: folders, dates and descriptions."""

from datetime import datetime

import pytest

from tendon_mj.errors import RecordingError
from tendon_mj.lab.fleet import find_rigs
from tests.refusals import refusing

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
        ("2026-03-04", datetime(2026, 3, 4)),
        ("20260304", datetime(2026, 3, 4)),
        ("2026-03-04T14", datetime(2026, 3, 4, 14)),
        ("2026-03-04T1430", datetime(2026, 3, 4, 14, 30)),
        ("2026-03-04T14:30:15", datetime(2026, 3, 4, 14, 30, 15)),
        ("2026-03-04T14:30:15.250", datetime(2026, 3, 4, 14, 30, 15, 250000)),
    ],
)
def test_a_recording_is_named_after_its_date(tmp_path, name, date):
    written(tmp_path, "description.toml", f"hand/{name}.csv")
    (rig,) = find_rigs(tmp_path)
    assert (rig.name, rig.dates) == ("hand", (date,))


def test_recordings_are_sorted_by_time_and_described_by_the_nearest_toml(tmp_path):
    written(tmp_path, "description.toml", "a/2026-03-05.csv", "a/2026-03-04.csv")
    written(tmp_path, "a/2026-03-04.toml", "b/description.toml", "b/2026-03-04.csv")
    written(tmp_path, ".hidden/2026-03-04.csv")
    first, second = find_rigs(tmp_path)
    tables, descriptions = zip(*first.files.values(), *second.files.values(), strict=True)
    assert [table.name for table in tables[:2]] == ["2026-03-04.csv", "2026-03-05.csv"]
    places = ("a/2026-03-04.toml", "description.toml", "b/description.toml")
    assert list(descriptions) == [tmp_path / place for place in places]
    recordings, reasons, _ = first.read()
    assert [recording.name for recording in recordings] == ["2026-03-04", "2026-03-05"]
    assert not any(reasons)


@pytest.mark.parametrize(
    ("names", "value"),
    [
        (["description.toml", "a/2026-03-04.csv", "a/notes.csv"], "notes.csv"),
        (["description.toml", "a/2026-13-99.csv"], "2026-13-99.csv"),
        (["description.toml", "a/2026-03-04_0042.csv"], "2026-03-04_0042.csv"),
        (["description.toml", "a/2026-03-04T14-05.csv"], "2026-03-04T14-05.csv"),  # a zone of -5 h
        (["a/2026-03-04.csv"], "2026-03-04.toml"),
        (["description.toml", "a/2026-03-04.csv", "a/20260304.csv"], "of one date, 2026-03-04"),
        (["a/description.toml"], "no recordings"),
        (["description.toml", "a/2026-03-04/press.csv"], "no recordings"),
    ],
)
def test_an_ambiguous_rig_is_an_error_of_that_rig_alone(tmp_path, names, value):
    written(tmp_path, *names, "b/description.toml", "b/2026-03-04.csv")
    first, second = find_rigs(tmp_path)
    assert str(tmp_path / "a") in first.error
    assert value in first.error
    assert not first.dates
    assert not second.error


@pytest.mark.parametrize(
    ("names", "out", "value"),
    [
        (["description.toml"], None, "no folder in it has recordings"),
        (["description.toml", "a/description.toml"], None, "no folder in it has recordings"),
        (["a/2026-03-04.csv", "2026-03-05.csv"], None, "rig_1/2026-03-05.csv"),
        (["description.toml", "a/2026-03-04.csv"], "a", "--out"),
        (None, None, "nowhere"),
    ],
)
def test_an_unusable_fleet_is_refused_by_its_folder(tmp_path, names, out, value):
    folder = tmp_path if names else tmp_path / "nowhere"
    written(tmp_path, *(names or ()))
    with refusing(RecordingError, str(folder), value):
        find_rigs(folder, tmp_path / out if out else None)


def test_an_unusable_recording_is_refused_with_its_reason(tmp_path):
    written(tmp_path, "description.toml", *(f"a/2026-03-0{k}.csv" for k in range(4, 8)))
    (tmp_path / "a" / "2026-03-04.csv").write_text("time_s\n")
    (tmp_path / "a" / "2026-03-06.toml").write_text(TOML.replace("bench", "finger"))
    (tmp_path / "a" / "2026-03-08.csv").symlink_to(tmp_path / "gone.csv")
    (rig,) = find_rigs(tmp_path)
    recordings, reasons, _ = rig.read()
    assert [one and one.name for one in recordings] == [
        None,
        "2026-03-05",
        None,
        "2026-03-07",
        None,
    ]
    for k, reason in {0: "2026-03-04.csv", 2: "'finger'", 4: "2026-03-08.csv"}.items():
        assert reason in reasons[k]
    assert [date.day for date in rig.without(reasons).dates] == [5, 7]


def test_two_paths_to_one_model_are_one_model(tmp_path):
    written(tmp_path, "description.toml", "a/2026-03-04.csv", "a/2026-03-05.csv")
    (tmp_path / "m.xml").write_text("<mujoco/>")
    (tmp_path / "description.toml").write_text(TOML.replace("bench", "m.xml"))
    (tmp_path / "a" / "2026-03-05.toml").write_text(TOML.replace("bench", "../m.xml"))
    (rig,) = find_rigs(tmp_path)
    assert not any(rig.read().reasons)


@pytest.mark.parametrize("results", ["out/fleet.csv", "old/fleet/fleet.csv"])
def test_folders_of_results_are_not_rigs_unless_they_have_recordings(tmp_path, results):
    written(tmp_path, "description.toml", "a/2026-03-04.csv", results)
    folder = results.partition("/")[0]
    for out in (None, tmp_path / folder, tmp_path / folder / "more"):
        assert [rig.name for rig in find_rigs(tmp_path, out)] == ["a"]
    written(tmp_path, f"{folder}/2026-03-04.csv")
    assert [rig.name for rig in find_rigs(tmp_path)] == ["a", folder]
