"""A fleet from its folder to its page."""

import json

import pytest

import tendon_mj
from tendon_mj.cli import main
from tendon_mj.lab.fleet import find_rigs, run_fleet
from tendon_mj.lab.workers import Workers
from tests.lab.fleet.small_fleet import AFTER, BEFORE, CHANGED, DAYS, write_fleet


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Folders of a fleet and of what was found of it."""
    base = tmp_path_factory.mktemp("fleet")
    write_fleet(base / "hands")
    broken = base / "hands" / "hand_9"
    broken.mkdir()
    still = "time_s,reel_m,input_N,output_N\n" + "".join(f"{0.1 * k},0,20,20\n" for k in range(20))
    (broken / "2026-03-01.csv").write_text(still, encoding="utf-8")
    for rig in ("hand_1", "hand_2"):
        (base / "hands" / rig / "2026-03-04T12.csv").write_text(still, encoding="utf-8")
    (base / "hands" / "hand_2" / "2026-02-28.csv").write_text("time_s,reel_m\nx,y\n", "utf-8")
    (base / "hands" / "hand_2" / "2026-03-09.csv").symlink_to(base / "gone.csv")
    assert main(["fleet", str(base / "hands"), "--out", str(base / "out"), "--processes", "1"]) == 0
    return base


def test_the_rig_that_changed_is_named_with_what_and_since_when(run):
    found = json.loads((run / "out" / "result.json").read_text(encoding="utf-8"))
    rigs = {rig["rig"]: rig for rig in found["rigs"]}
    changed = rigs[CHANGED]["changed"]
    assert {name for name, rig in rigs.items() if rig["verdict"] == "changed"} == {CHANGED}
    assert changed["parameter"] == "sheath.friction"
    assert changed["course"] == "step"
    assert changed["since"].startswith("2026-03-05")
    assert [changed["before"], changed["after"]] == pytest.approx([BEFORE, AFTER], abs=0.01)
    assert f"{CHANGED}: sheath.friction 0.1" in rigs[CHANGED]["sentence"]
    assert "since 2026-03-05" in rigs[CHANGED]["sentence"]


def test_the_function_returns_what_the_command_finds_as_a_table(run):
    result = tendon_mj.fleet(run / "hands", run / "out" / "rigs")
    table = result.to_dataframe()
    found = json.loads((run / "out" / "result.json").read_text(encoding="utf-8"))
    assert list(table["rig"]) == [rig["rig"] for rig in found["rigs"]]
    assert found["sentence"] in repr(result)
    assert len(repr(result).splitlines()) == 1


def test_a_rig_that_cannot_be_fitted_is_told_and_stops_no_other(run):
    found = json.loads((run / "out" / "result.json").read_text(encoding="utf-8"))
    rigs = {rig["rig"]: rig for rig in found["rigs"]}
    assert rigs["hand_9"]["verdict"] == "failed"
    assert rigs["hand_9"]["error"]
    assert "hand_9" in found["sentence"]


def test_a_recording_that_cannot_be_used_is_left_out_and_told_by_its_file(run):
    found = json.loads((run / "out" / "result.json").read_text(encoding="utf-8"))
    rigs = {rig["rig"]: rig for rig in found["rigs"]}
    page = (run / "out" / "fleet.html").read_text(encoding="utf-8")
    left_out = {
        "hand_1": {"2026-03-04T12.csv": "the drive stands still"},
        CHANGED: {
            "2026-02-28.csv": "2026-02-28.csv, row 2, column 'time_s'",
            "2026-03-04T12.csv": "the drive stands still",
            "2026-03-09.csv": "no such file",
        },
    }
    for rig, files in left_out.items():
        assert len(rigs[rig]["dates"]) == DAYS
        assert len(rigs[rig]["remarks"]) == len(files)
        for file, reason in files.items():
            (told,) = (r for r in rigs[rig]["remarks"] if f"{file} is left out: " in r)
            assert reason in told
            assert told in rigs[rig]["sentence"]
            assert file in page
    assert not rigs["hand_3"]["remarks"]


def test_a_second_run_computes_only_what_is_new(run, capsys):
    kept = sorted((run / "out" / "rigs").rglob("*.json"))
    times = {path: path.stat().st_mtime_ns for path in kept}
    fleet = run / "hands"
    kept[0].write_text("{")  # half-written by something else
    rows = (fleet / "hand_3" / "2026-03-07.csv").read_text(encoding="utf-8")
    (fleet / "hand_3" / "2026-03-09.csv").write_text(rows.replace("0.79,", "0.795,"))
    assert main(["fleet", str(fleet), "--out", str(run / "out"), "--processes", "1"]) == 0
    again = {path.name for path, time in times.items() if path.stat().st_mtime_ns != time}
    assert again == {kept[0].name, "hand_3.json", "hand_9.json"}  # the last could not be fitted
    assert "1 changed (hand_2)" in capsys.readouterr().out


@pytest.mark.long
def test_what_is_set_anew_each_day_is_no_change(tmp_path):
    write_fleet(tmp_path / "hands", rigs=2, zero=0.8)
    found = run_fleet(find_rigs(tmp_path / "hands"), tmp_path / "out", on=Workers(processes=1))
    (changed,) = found.of("changed")
    assert changed.name == CHANGED
    assert changed.series.parameter == "sheath.friction"
    assert changed.change.after == pytest.approx(AFTER, abs=0.015)


@pytest.mark.long
def test_a_rig_with_one_odd_day_is_consistent_and_the_day_is_reported(tmp_path):
    write_fleet(tmp_path / "hands", rigs=5, odd="hand_4")
    found = run_fleet(find_rigs(tmp_path / "hands"), tmp_path / "out", on=Workers(processes=1))
    verdicts = {rig.name: rig.verdict for rig in found.rigs}
    assert verdicts == dict.fromkeys(verdicts, "consistent with the fleet") | {CHANGED: "changed"}
    odd = next(rig for rig in found.with_findings if rig.name == "hand_4")
    assert any("is on 2026-03-03, " in remark for remark in odd.remarks)
