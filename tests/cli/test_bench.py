"""`tendon-mj bench`: what it writes and what it refuses."""

import functools
import importlib
import json
import os
from pathlib import Path

import pytest

from experiments.benchmarks import run_benchmark
from tendon_mj.cli import main
from tests.experiments.benchmarks.test_foreign_model import ARM, MOTOR, MUSCLE

GIVEN = Path(os.environ.get("TENDON_MJ_MODELS", "/nowhere")) / "myohand.xml"


@pytest.fixture(autouse=True)
def short(monkeypatch):
    quick = functools.partial(run_benchmark, guides=(4, 16, 32), sheaths=(1, 2))
    # the package's attribute of that name is the command itself
    monkeypatch.setattr(importlib.import_module("tendon_mj.cli.bench"), "run_benchmark", quick)


def test_the_result_has_every_figure(tmp_path, capsys):
    model = tmp_path / "arm.xml"
    model.write_text(ARM.format(MUSCLE + MOTOR))
    models = [str(model)] + ([str(GIVEN)] if GIVEN.exists() else [])
    out = tmp_path / "out"
    assert main(["bench", *models, "--out", str(out), "--rounds", "1"]) == 0
    result = json.loads((out / "result.json").read_text("utf-8"))
    names = ["bench", "finger", *(Path(name).stem for name in models)]
    assert list(result["step_cost_ratio"]) == list(result["models"]) == names
    assert min(result["step_cost_ratio"].values()) > 0.0
    for figure in (
        "guide_scaling_exponent",
        "sheath_scaling_exponent",
        "thread_speedup",
        "callback_ratio",
    ):
        assert figure in result
    for one in result["models"].values():
        assert one["quartiles"][0] <= one["ratio"] <= one["quartiles"][1]
        assert 0 < one["memory_bytes"]["plugin_state"] < one["memory_bytes"]["buffer"]
    assert result["cost_parts"]["empty_plugin_s"] is not None
    assert result["callback"]["largest_tension_difference"] < 1e-9
    assert result["frictionloss"]["output_tension"]["max_relative_error"] > 0.1
    for picture in ("scaling", "cost"):
        assert (out / f"{picture}.png").stat().st_size > 10_000
    printed = capsys.readouterr().out
    ratios = result["step_cost_ratio"]
    last = printed.splitlines()[-1]
    for model in (min(ratios, key=ratios.get), max(ratios, key=ratios.get)):
        assert f"{ratios[model]:.2f} ({model})" in last
    assert "floor: an empty plugin" in printed
    assert "arm" in printed


@pytest.mark.parametrize(
    ("text", "said"), [(None, "no such"), (ARM.format(""), "no actuator"), ("no XML", "XML")]
)
def test_a_refusal_is_one_line(tmp_path, capsys, text, said):
    model = tmp_path / "arm.xml"
    if text is not None:
        model.write_text(text)
    assert main(["bench", str(model), "--out", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert said in error or (text is None and str(model) in error)
    assert error.count("\n") == 1
