"""`init` and `check`, and `--settle` of the commands that simulate recordings."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from tendon_mj import (
    Recording,
    Uncertain,
    example_rig,
    load_model,
    patch_model,
    read_recording,
    replay_error,
    replay_recording,
    write_recording,
)
from tendon_mj.cli import main
from tendon_mj.models import example_recording
from tests.lab.recorded import written


def test_init_writes_a_description_beside_the_model_and_keeps_what_is_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "hand.xml").write_text("<mujoco/>")
    assert main(["init", "models/hand.xml", "--out", "new/data.toml"]) == 0
    assert 'model = "../models/hand.xml"' in (tmp_path / "new" / "data.toml").read_text()
    assert "to be filled in" in capsys.readouterr().out
    assert main(["init", "bench"]) == 0
    before = (tmp_path / "bench.toml").read_text()
    assert 'model = "bench"' in before
    assert main(["init", "joint", "--out", "bench.toml"]) == 2
    assert "bench.toml" in capsys.readouterr().err
    assert (tmp_path / "bench.toml").read_text() == before


def test_check_draws_each_recording_and_says_how_many_warnings(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    example = example_recording()
    toml = example.with_suffix(".toml").read_text()
    lines = example.read_text().splitlines()
    late = [f"{1000.0 * float(line.split(',')[0])},{line.partition(',')[2]}" for line in lines[1:]]
    (tmp_path / "late.csv").write_text("\n".join([lines[0], *late]))
    (tmp_path / "late.toml").write_text(toml)
    out = tmp_path / "out"
    assert main(["check", str(example), str(tmp_path / "late.csv"), "--out", str(out)]) == 0
    assert (out / "twin.png").stat().st_size > 10_000
    assert not (out / "late.png").exists()
    said = " ".join(capsys.readouterr().out.split())
    assert "warning: late, column 'time_s'" in said
    assert "name the column 'time_ms'" in said
    assert said.endswith("take such faults for properties of the rig.")
    sound, late_result = json.loads((out / "result.json").read_text())["recordings"]
    assert (sound["name"], sound["warnings"], sound["simulated"]) == ("twin", [], True)
    assert [w["identifier"] for w in late_result["warnings"]] == ["times_in_ms"]


def test_check_says_that_an_angle_alone_may_not_tell_friction(tmp_path, capsys):
    rig = Path(__file__).parents[2] / "models" / "rig"
    for name in ("triangles.csv", "rig.xml"):
        (tmp_path / name).write_bytes((rig / name).read_bytes())
    text = (rig / "rig.toml").read_text()
    measured = next(line for line in text.splitlines() if line.startswith("cable_N"))
    for name, description in (("both", text), ("angle", text.replace(measured, ""))):
        path = tmp_path / f"{name}.toml"
        path.write_text(description)
        table = str(tmp_path / "triangles.csv")
        arguments = ["check", table, "--description", str(path), "--out", str(tmp_path / name)]
        assert main(arguments) == 0
        said = " ".join(capsys.readouterr().out.split())
        assert ("No force is measured: friction, play and an elastic mount" in said) == (
            name == "angle"
        )


def with_and_without_friction(folder: Path) -> tuple[Recording, list[str]]:
    """Recording of the example rig, and two models of it, with a friction of 0.12 and of 0."""
    rig, paths = example_rig(), []
    for friction in (0.12, 0.0):
        paths.append(str(folder / f"{friction}.xml"))
        patch_model(str(rig / "rig.xml"), {"sheath.friction": friction}, paths[-1])
    return read_recording(rig / "triangles.csv", rig / "rig.toml"), paths


def test_replay_compares_models_each_with_its_own_friction(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The recording is one model's own: that one leaves the noise, and a description no guess."""
    described, paths = with_and_without_friction(tmp_path)
    guess = {**described.uncertain, "sheath.friction": Uncertain(0.25, 0.03, 0.3)}
    recording = replace(described, uncertain=guess)
    known = {**recording.known, "sheath.friction": 0.0}
    truth = replace(recording, known=known, uncertain={}, model=str(example_rig() / "rig.xml"))
    made = replay_recording(truth)
    write_recording(replace(recording, columns=made.columns, model=paths[0]), tmp_path / "pull.csv")
    out = tmp_path / "out"
    assert main(["replay", str(tmp_path / "pull.csv"), "--model", *paths, "--out", str(out)]) == 0
    found = json.loads((out / "result.json").read_text())["over_noise"]
    assert list(found) == paths
    assert found[paths[0]] > 10.0
    assert found[paths[1]] < 0.01
    again = read_recording(out / "simulated_1")
    assert replay_error(again, replay_recording(again))["cable_N"].rmse < 1e-6
    assert Path(again.model).name == Path(paths[1]).name
    said = " ".join(capsys.readouterr().out.split())
    assert "0.12 (description: 0.25)" in said
    assert said.rindex(f"{paths[1]} by") < said.rindex(f"{paths[0]} by")


def test_models_that_differ_in_a_known_number_have_two_curves(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The description is of the second model, and knows the friction of the first."""
    described, paths = with_and_without_friction(tmp_path)
    known = {**described.known, "sheath.friction": 0.12}
    recording = replace(described, model=paths[1], known=known, uncertain={})
    write_recording(recording, tmp_path / "pull.csv")
    arguments = ["replay", str(tmp_path / "pull.csv"), "--out", str(tmp_path / "out"), "--model"]
    assert main([*arguments, *paths]) == 0
    first, second = json.loads((tmp_path / "out" / "result.json").read_text())[
        "over_noise"
    ].values()
    assert second > 1.5 * first
    assert "the models differ in sheath.friction" in " ".join(capsys.readouterr().out.split())
    assert main([*arguments, paths[1]]) == 0
    assert "sets sheath.friction = 0.12 (model: 0)" in " ".join(capsys.readouterr().out.split())


def test_a_demo_ends_with_the_verdict_and_its_report(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """What it runs is tested by itself; here only the order, and what is said last."""
    ran = []
    for name in ("compare", "render", "replay"):
        monkeypatch.setattr(f"tendon_mj.cli.demo.{name}", lambda *_, of=name, **__: ran.append(of))

    def found(recordings: tuple[Path, ...], out: Path, **given: object) -> dict[str, object]:
        ran.append("diagnose")
        held_out = given["hold_out"]
        assert isinstance(held_out, tuple)
        assert all(path.is_file() for path in (*recordings, *held_out[0], given["description"]))
        return {"verdict": "named", "sentence": "Missing: a sheath."}

    monkeypatch.setattr("tendon_mj.cli.demo.diagnose", found)
    assert main(["demo", "--out", str(tmp_path)]) == 0
    assert ran == ["compare", "render", "replay", "diagnose"]
    last = capsys.readouterr().out.splitlines()[-1]
    report = tmp_path / "diagnose" / "report.html"
    assert last == f"The diagnosis is named. Missing: a sheath. Its report: {report}."


def test_settle_overrules_the_description(tmp_path: Path) -> None:
    """A drive that begins wound in: without time to settle the model starts at rest."""
    rows = "".join(f"{0.02 * k},1.0,30.0\n" for k in range(20))
    written(tmp_path, rows, "time_s,reel_mm,pull_N")
    errors = {}
    for settle in (0.0, 0.5):
        arguments = ["replay", str(tmp_path / "r.csv"), "--settle", str(settle)]
        assert main([*arguments, "--out", str(tmp_path)]) == 0
        rmse = json.loads((tmp_path / "result.json").read_text())["rmse"]["as described"]
        recording = read_recording(tmp_path / "r")
        shown = replay_recording(recording, load_model("bench"), settle=settle)
        errors[settle] = rmse["pull_N"]["rmse"]
        assert errors[settle] == pytest.approx(replay_error(recording, shown)["pull_N"].rmse)
    assert errors[0.0] != pytest.approx(errors[0.5], rel=0.01)
    assert main(["diagnose", str(tmp_path / "r.csv"), "--settle", "-1"]) == 2


def test_recordings_of_one_name_have_a_picture_each(tmp_path: Path) -> None:
    example = example_recording()
    paths = []
    for folder in ("day_1", "day_2"):
        (tmp_path / folder).mkdir()
        for suffix in (".csv", ".toml"):
            text = example.with_suffix(suffix).read_text()
            (tmp_path / folder / f"run{suffix}").write_text(text)
        paths.append(str(tmp_path / folder / "run.csv"))
    assert main(["check", *paths, "--out", str(tmp_path / "out")]) == 0
    found = json.loads((tmp_path / "out" / "result.json").read_text())
    assert [one["name"] for one in found["recordings"]] == ["0_run", "1_run"]
    assert found["files"] == ["0_run.png", "1_run.png"]
