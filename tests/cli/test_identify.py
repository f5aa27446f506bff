"""`tendon-mj identify`: a planned motion, a recorded one, and what is refused."""

from __future__ import annotations

import json
import shutil
from functools import partial
from pathlib import Path

import pytest

from tendon_mj import example_rig
from tendon_mj.cli import main
from tendon_mj.lab import diagnosis

BOUNDS = "duration = 1.5\n[drive]\nspool_deg = { low = 0.0, high = 60.0, rate = 200.0 }\n"


@pytest.fixture
def rig(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a description and bounds; one effect is judged, which takes less time."""
    few = {"sensor_bias": diagnosis.CATALOGUE["sensor_bias"]}
    monkeypatch.setattr("tendon_mj.cli.identify.judge", partial(diagnosis.identify, catalogue=few))
    for name in ("rig.toml", "rig.xml"):
        shutil.copy(example_rig() / name, tmp_path / name)
    (tmp_path / "bounds.toml").write_text(BOUNDS)
    return tmp_path


def test_a_planned_motion_is_judged_by_the_signals_and_written_down(
    rig: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["--bounds", str(rig / "bounds.toml"), "--out", str(rig / "out")]
    assert main(["identify", str(rig / "rig.toml"), *arguments, "--signals", "lever_deg"]) == 0
    written = json.loads((rig / "out" / "result.json").read_text())
    assert written["signals"] == ["lever_deg"]
    assert [effect["where"] for effect in written["effects"]] == ["lever_angle"]
    assert {n["name"] for n in written["numbers"]} == {"sheath.friction", "sheath.pretension"}
    said = " ".join(capsys.readouterr().out.split())
    assert written["sentence"] in said
    assert "sensor_bias (lever_angle)" in said
    assert all(word in said for word in ("sheath.friction", "determined"))


def test_a_recording_gives_the_motion(rig: Path) -> None:
    shutil.copy(example_rig() / "sines.csv", rig / "sines.csv")
    arguments = ["--description", str(rig / "rig.toml"), "--out", str(rig / "out")]
    assert main(["identify", str(rig / "sines.csv"), *arguments]) == 0
    written = json.loads((rig / "out" / "result.json").read_text())
    assert written["signals"] == ["cable_N", "lever_deg"]
