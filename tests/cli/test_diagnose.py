"""`tendon-mj diagnose` on short recordings: what it writes, and what it refuses."""

import hashlib
import json
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tendon_mj.attach import Parameters
from tendon_mj.cli import main
from tendon_mj.errors import TendonError
from tendon_mj.lab.diagnosis import CATALOGUE, Diagnosis
from tendon_mj.lab.recordings import Uncertain, read_recording
from tendon_mj.lab.recordings import write_recording as write
from tendon_mj.lab.replay import replay_recording
from tendon_mj.models import model_path
from tests.lab.recorded import recorded

NOISE = 0.05
OTHERS = [name for name in CATALOGUE if name != "sensor_bias"]


def record(folder, name, seed, offset=0.0):
    """A bench whose friction is not what the recording guesses, and whose sensor may be off."""
    random = np.random.default_rng(seed)
    time = np.arange(0.0, 1.0, 0.005)
    x = 8e-4 * np.sin(4.0 * np.pi * random.uniform(0.8, 1.3) * time)
    made = recorded(
        time,
        {"input_displacement_m": ("reel", x)},
        {"output_tension_N": ("output_tension", NOISE)},
        name=name,
        source=f"made by {name}'s test",
        uncertain={"sheath.friction": Uncertain(0.15, 0.05, 0.4)},
    )
    truth = {"sheath.friction": 0.2, "output_tension.offset": offset}
    tension = replay_recording(made, parameters=truth).columns["output_tension_N"]
    columns = {**made.columns, "output_tension_N": tension + random.normal(0.0, NOISE, time.size)}
    return str(write(replace(made, columns=columns), folder / f"{name}.csv"))


@pytest.fixture(scope="module")
def rig(tmp_path_factory):
    """Train and held-out recordings, of a sound sensor and of one that is off by 1 N."""
    folder = tmp_path_factory.mktemp("rig")
    return {
        offset: [record(folder, f"{name}_{offset:g}", k, offset) for k, name in enumerate("ab")]
        for offset in (0.0, 1.0)
    }


@pytest.fixture(scope="module")
def found(rig, tmp_path_factory):
    """Where the diagnosis of the sensor that is off was written, and its result."""
    out = tmp_path_factory.mktemp("found")
    train, held_out = rig[1.0]
    arguments = ["diagnose", train, "--hold-out", held_out, "--out", str(out), "--no-sysid"]
    assert main([*arguments, "--exclude", *OTHERS]) == 0
    return out, json.loads((out / "result.json").read_text("utf-8"))


def test_what_is_missing_is_named_with_its_parameters(found):
    _, result = found
    assert result["verdict"] == "named"
    assert result["effects"] == ["sensor_bias"]
    assert result["recordings"] == ["a_1"]
    assert result["held_out"] == ["b_1"]
    assert result["sysid"] is None
    offset = result["parameters"]["output_tension.offset"]
    assert offset["low"] < 1.0 < offset["high"]
    assert result["calibrated"]["sheath.friction"]["value"] == pytest.approx(0.2, rel=0.05)
    assert result["gap"]["held_out"]["reducible_closed"] > 0.9


def test_pictures_and_page_are_written(found):
    out, result = found
    for picture in ("misfit", "gap", "proof", "before_after"):
        assert (out / f"{picture}.png").stat().st_size > 10_000
    assert result["sentence"] in (out / "report.html").read_text("utf-8")


def test_the_result_tells_the_command_and_the_bytes_of_every_file(rig, found):
    out, result = found
    train, held_out = rig[1.0]
    provenance = result["provenance"]
    expected = f"tendon-mj diagnose {train} --hold-out {held_out} --out {out} --no-sysid --exclude"
    assert provenance["command"].startswith(expected)
    toml = str(Path(train).with_suffix(".toml"))
    assert {train, toml, held_out} <= provenance["files"].keys()
    assert any(file.endswith("bench.xml") for file in provenance["files"])
    digest = hashlib.sha256(Path(train).read_bytes()).hexdigest()
    assert provenance["files"][train] == digest
    page = (out / "report.html").read_text("utf-8")
    assert digest in page
    assert '<a href="#model">' in page
    assert str(Path.home()) not in page


def test_the_simulations_leave_the_gaps_that_the_result_states(rig, found):
    out, result = found
    measured = read_recording(rig[1.0][1]).columns["output_tension_N"]
    for when in ("before", "after"):
        simulated = read_recording(out / f"0_b_1_{when}").columns["output_tension_N"]
        rms = np.sqrt(np.mean((simulated - measured) ** 2)) / NOISE
        assert rms == pytest.approx(result["gap"]["held_out"][when], rel=1e-3)


def test_a_replay_on_the_model_that_was_written_keeps_what_was_found(rig, found, tmp_path, capsys):
    """The report's first advice; the description's guess would overrule it silently."""
    out, result = found
    held_out = rig[1.0][1]
    errors = {}
    for values in ([], ["--values-of", "model"], ["--values-of", "description"]):
        arguments = ["replay", held_out, "--model", str(out / "model.xml"), *values]
        assert main([*arguments, "--out", str(tmp_path)]) == 0
        (rmse, *_) = json.loads((tmp_path / "result.json").read_text("utf-8"))["rmse"].values()
        errors[values[-1] if values else ""] = rmse["output_tension_N"]["rmse"] / NOISE
    assert errors[""] == pytest.approx(result["gap"]["held_out"]["after"], rel=1e-3)
    assert errors["model"] == pytest.approx(errors[""])
    assert errors["description"] > 2.0 * errors[""]
    said = " ".join(capsys.readouterr().out.split())
    assert "sheath.friction, are kept" in said
    assert "warning: b_1: the description overrules" in said
    assert "--model model.xml" in (out / "report.html").read_text("utf-8").replace(
        '<a href="#model">model.xml</a>', "model.xml"
    )


def test_a_check_on_the_model_that_was_written_keeps_what_was_found(rig, found, tmp_path):
    out, result = found
    arguments = ["check", rig[1.0][1], "--model", str(out / "model.xml"), "--out", str(tmp_path)]
    assert main(arguments) == 0
    (one,) = json.loads((tmp_path / "result.json").read_text("utf-8"))["recordings"]
    after = result["gap"]["held_out"]["after"]
    assert one["rmse"]["output_tension_N"] / NOISE == pytest.approx(after, rel=1e-3)


def test_an_uncertain_number_without_a_range_is_in_the_model(rig, tmp_path):
    train, held_out = rig[0.0]
    fixed = []
    for path in (train, held_out):
        made = read_recording(path)
        fixed.append(replace(made, uncertain={"sheath.friction": Uncertain(0.2, 0.2, 0.2)}))
    paths = [str(write(made, tmp_path / f"{k}.csv")) for k, made in enumerate(fixed)]
    arguments = ["diagnose", paths[0], "--hold-out", paths[1], "--out", str(tmp_path / "out")]
    assert main([*arguments, "--no-sysid", "--exclude", *OTHERS]) == 0
    patched = mujoco.MjModel.from_xml_path(str(tmp_path / "out" / "model.xml"))
    assert Parameters(patched, mujoco.MjData(patched))["sheath.friction"] == 0.2


def test_a_tare_is_the_reason_why_no_effect_is_sought(rig, tmp_path, capsys):
    train = read_recording(rig[0.0][0])
    tension = train.columns["output_tension_N"].copy()
    tension[tension.size // 2 :] -= 6.0
    tared = replace(train, columns={**train.columns, "output_tension_N": tension})
    path = str(write(tared, tmp_path / "tared.csv"))
    assert main(["diagnose", path, "--out", str(tmp_path / "out"), "--no-sysid"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert said.index("its zero steps by") < said.index("The misfit is")
    assert said.index("not proven:") < said.index("sheath.friction = ")
    result = json.loads((tmp_path / "out" / "result.json").read_text("utf-8"))
    (check,) = result["checks"]
    assert (result["verdict"], result["effects"]) == ("unknown", [])
    assert (check["identifier"], check["blocks"]) == ("zero_step", True)
    assert f"row {tension.size // 2 + 2}" in check["value"]
    page = (tmp_path / "out" / "report.html").read_text("utf-8")
    assert "No effect is named" in page
    assert "Nothing was found" not in page


def test_ctrl_c_after_the_verdict_skips_the_comparison_and_no_more(
    rig, tmp_path, capsys, monkeypatch
):
    def interrupted(*_):
        page = (tmp_path / "report.html").read_text("utf-8")
        assert "interrupted" in page
        assert "named: The rig has a sensor" in capsys.readouterr().out
        raise KeyboardInterrupt

    monkeypatch.setattr("tendon_mj.cli.diagnose.sysid_is_there", lambda: True)
    monkeypatch.setattr("tendon_mj.cli.diagnose.fit_with_sysid", interrupted)
    train, held_out = rig[1.0]
    arguments = ["diagnose", train, "--hold-out", held_out, "--out", str(tmp_path)]
    assert main([*arguments, "--catalogue", "sensor_bias"]) == 0
    result = json.loads((tmp_path / "result.json").read_text("utf-8"))
    assert (result["effects"], result["sysid"]) == (["sensor_bias"], None)
    assert {ranked["identifier"] for ranked in result["ranking"]} == {"sensor_bias"}
    assert "report.html" in result["files"]
    assert "Skipped" in capsys.readouterr().out
    assert main([*arguments, "--catalogue", "sensor_bais"]) == 2
    assert "did you mean 'sensor_bias'" in " ".join(capsys.readouterr().err.split())


def test_where_nothing_is_missing_it_says_so(rig, tmp_path, capsys):
    arguments = ["diagnose", *rig[0.0], "--out", str(tmp_path), "--no-sysid"]
    assert main([*arguments, "--exclude", *OTHERS]) == 0
    said = " ".join(capsys.readouterr().out.split())
    for text in ("Nothing is missing", "sheath.friction = ", "held out: rms error", "[noise]"):
        assert text in said
    assert said.endswith("Report: " + str(tmp_path / "report.html"))
    result = json.loads((tmp_path / "result.json").read_text("utf-8"))
    assert result["held_out"] == []
    assert "last quarter" in (tmp_path / "report.html").read_text("utf-8")
    assert not (tmp_path / "misfit.png").exists()


def refused(arguments, tmp_path, capsys):
    assert main(["diagnose", *arguments, "--out", str(tmp_path / "out"), "--no-sysid"]) == 2
    error = capsys.readouterr().err
    assert "Traceback" not in error
    return " ".join(error.split())


def test_no_recording_that_a_diagnosis_reads_is_written_over(found, capsys):
    out, _ = found
    before = {path: path.read_bytes() for path in out.iterdir()}
    written = sorted(out.glob("*.csv"))
    assert len(written) == 2  # before and after
    for path in written:
        assert main(["diagnose", str(path), "--out", str(out), "--no-sysid"]) == 2
        assert path.name in capsys.readouterr().err
    assert {path: path.read_bytes() for path in out.iterdir()} == before


@pytest.mark.parametrize("named", ["by the option", "by the description"])
def test_the_model_that_a_diagnosis_reads_is_not_written_over(rig, tmp_path, capsys, named):
    """Its own folder is where a rig's model is `model.xml`, as the result's is."""
    given, bench = Path(rig[0.0][0]), model_path("bench")
    (tmp_path / "model.xml").write_text(bench.read_text("utf-8"), "utf-8")
    text = given.with_suffix(".toml").read_text("utf-8")
    if "option" not in named:
        text = text.replace('model = "bench"', 'model = "model.xml"')
    (tmp_path / "a.csv").write_bytes(given.read_bytes())
    (tmp_path / "a.toml").write_text(text, "utf-8")
    option = ["--model", str(tmp_path / "model.xml")] if "option" in named else []
    (tmp_path / "result.json").write_text('{"files": ["misfit.png"]}')  # of an earlier run
    (tmp_path / "misfit.png").touch()
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    arguments = ["diagnose", str(tmp_path / "a.csv"), *option, "--out", str(tmp_path)]
    assert main([*arguments, "--no-sysid", "--exclude", *OTHERS]) == 2
    assert "model.xml" in capsys.readouterr().err
    assert {path: path.read_bytes() for path in before} == before


def test_what_was_found_is_written_where_the_model_cannot_be(rig, tmp_path, capsys, monkeypatch):
    def write_model(*_):
        raise TendonError("rig.xml: unknown body 'x_link'")

    monkeypatch.setattr(Diagnosis, "write_model", write_model)
    assert "unknown body 'x_link'" in refused([*rig[0.0], "--exclude", *OTHERS], tmp_path, capsys)
    result = json.loads((tmp_path / "out" / "result.json").read_text("utf-8"))
    assert "There is no model.xml: rig.xml: unknown body 'x_link'" in result["warnings"]
    assert "There is no model.xml" in (tmp_path / "out" / "report.html").read_text("utf-8")
    assert not (tmp_path / "out" / "model.xml").exists()
