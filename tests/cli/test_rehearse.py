"""`tendon-mj rehearse`: what it hands to the diagnosis, and what it says of the result."""

from __future__ import annotations

from pathlib import Path

import pytest

from tendon_mj import example_rig, read_recording, replay_error, replay_recording
from tendon_mj.cli import main


def test_a_rehearsal_diagnoses_the_rig_with_the_effect_and_says_what_was_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    handed: dict[str, object] = {}

    def found(recordings: tuple[Path, ...], out: Path, **given: object) -> dict[str, object]:
        handed.update(given, recordings=recordings)
        value = {"value": 4.9e-4, "low": 4.7e-4, "high": 5.2e-4}
        parameters = {"sheath.backlash": value}
        return {
            "verdict": "named",
            "effects": ["backlash"],
            "parameters": parameters,
            "calibrated": {},
        }

    monkeypatch.setattr("tendon_mj.cli.rehearse.diagnose", found)
    rig = example_rig()
    arguments = [str(rig / "triangles.csv"), "--hold-out", str(rig / "sines.csv")]
    arguments += ["--description", str(rig / "rig.toml"), "--out", str(tmp_path)]
    assert main(["rehearse", *arguments, "--effect", "backlash=5e-4,friction=0.2"]) == 0
    (train,), ((held_out,),) = handed["recordings"], handed["hold_out"]  # type: ignore[misc,has-type]
    for path in (train, held_out):
        made = read_recording(path)
        parameters = {"sheath.backlash": 5e-4, "sheath.friction": 0.2}
        errors = replay_error(made, replay_recording(made, parameters=parameters))
        for column, misfit in errors.items():
            assert misfit.rmse == pytest.approx(made.measured[column].noise, rel=0.15)
    said = " ".join(capsys.readouterr().out.split())
    assert "Planted sheath.backlash = 500 µm: found 490 µm, 95 % within 470 µm … 520 µm." in said
    assert "Planted sheath.friction = 0.2: not found, the verdict is named." in said
