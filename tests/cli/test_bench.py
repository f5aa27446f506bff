"""`tendon-mj bench`: its result, its picture and its refusals."""

import json
import os
from pathlib import Path

from tendon_mj.cli import main
from tests.lab.test_step_cost import ARM, MOTOR, MUSCLE

GIVEN = Path(os.environ.get("TENDON_MJ_MODELS", "/nowhere")) / "myohand.xml"


def test_the_result_has_every_figure(tmp_path, capsys):
    model = tmp_path / "arm.xml"
    model.write_text(ARM.format(MUSCLE + MOTOR))
    models = [str(model)] + ([str(GIVEN)] if GIVEN.exists() else [])
    out = tmp_path / "out"
    assert main(["bench", *models, "--out", str(out), "--rounds", "1"]) == 0
    result = json.loads((out / "result.json").read_text("utf-8"))
    names = ["bench", "finger", *(Path(name).stem for name in models)]
    ratios = result["step_cost_ratio"]
    assert list(ratios) == list(result["models"]) == names
    assert min(ratios.values()) > 0.0
    assert result["cores"] == os.cpu_count()
    for cost in result["models"].values():
        assert cost["quartiles"][0] <= cost["ratio"] <= cost["quartiles"][1]
        assert 0 < cost["memory_bytes"]["plugin_state"] < cost["memory_bytes"]["buffer"]
    assert (out / "cost.png").stat().st_size > 10_000
    printed = capsys.readouterr().out
    last = printed.splitlines()[-1]
    for name in (min(ratios, key=ratios.get), max(ratios, key=ratios.get)):
        assert f"{ratios[name]:.2f} ({name})" in last
    assert "arm without the sensors of tension" in printed
