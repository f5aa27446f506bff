"""`tendon-mj diagnose --next` on a sheath of which only the product of friction and bend shows."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tendon_mj.cli import main
from tendon_mj.lab.diagnosis import CATALOGUE
from tendon_mj.lab.recordings import read_recording, write_recording
from tendon_mj.lab.replay import Simulator
from tests.lab.diagnosis.toy import measured_by
from tests.lab.recorded import recorded

NOISE = 0.05
OTHERS = [name for name in CATALOGUE if name not in ("friction", "bend_angle")]
COLUMN, BEND = "output_tension_N", "sheath.extra_bend"
BOUNDS = f"""
[drive]
input_displacement_m = {{ low = -8e-4, high = 8e-4, rate = 0.02, dwell = 0.5 }}
[states]
"{BEND}" = {{ low = 0.0, high = 3.0 }}
"""


def record(folder: Path, name: str, seed: int, rate: float) -> str:
    """A bench with more friction than the model says, driven by a sine."""
    random = np.random.default_rng(seed)
    time = np.round(np.arange(0.0, 2.0, 0.01), 6)
    blank = recorded(
        time,
        {"input_displacement_m": ("reel", 8e-4 * np.sin(2.0 * np.pi * rate * time))},
        {COLUMN: ("output_tension", NOISE)},
        name=name,
    )
    made = measured_by(Simulator, blank, {"sheath.friction": 0.2}, random)
    return str(write_recording(made, folder / f"{name}.csv"))


def test_a_tie_gets_a_template_that_decides_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    made = [record(tmp_path, name, k, 0.8 + 0.3 * k) for k, name in enumerate("ab")]
    (tmp_path / "bounds.toml").write_text(BOUNDS, encoding="utf-8")
    out = tmp_path / "out"
    given = ["diagnose", made[0], "--hold-out", made[1], "--out", str(out), "--no-sysid"]
    given += ["--next", str(tmp_path / "bounds.toml"), "--exclude", *OTHERS]
    assert main(given) == 0
    result = json.loads((out / "result.json").read_text("utf-8"))
    assert [set(tie) for tie in result["indistinguishable"]] == [{"friction", "bend_angle"}]
    assert result["next"]["sentence"] in capsys.readouterr().out
    (difference,) = result["next"]["differences"]
    assert difference["recorded"] < 0.5 < 2.0 < difference["expected"]
    template = read_recording(out / "next.csv")
    assert template.known[BEND] == result["next"]["states"][BEND] > 0.5
    assert not template.columns[COLUMN].any()
    as_friction = {"sheath.friction": 0.2}
    as_bend = {BEND: template.known[BEND] + np.pi / 3.0}  # 0.15 (π + π/3) = 0.2 π
    by_friction, by_bend = (row[0][COLUMN] for row in Simulator([template])([as_friction, as_bend]))
    assert np.sqrt(np.mean((by_friction - by_bend) ** 2)) > 2.0 * NOISE
