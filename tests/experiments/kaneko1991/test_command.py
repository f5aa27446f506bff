"""`python -m experiments.kaneko1991` writes what its README lists."""

import contextlib
import dataclasses
import json

import pytest

import experiments.kaneko1991.__main__ as program
from experiments.command import run_experiment
from experiments.kaneko1991 import figure_4bc
from experiments.kaneko1991.__main__ import kaneko1991


def nothing(histories, progress):
    raise AssertionError("computed")


def test_an_input_that_is_refused_is_one_line_before_anything_is_computed(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(program, "reproduce", nothing)
    arguments = ["--out", str(tmp_path / "new"), "--histories", "-1"]
    assert run_experiment(kaneko1991, "kaneko1991", arguments) == 2
    told = "python -m experiments.kaneko1991: histories = -1 must be ≥ 0\n"
    assert capsys.readouterr().err == told
    assert not (tmp_path / "new").exists()
    (tmp_path / "file").write_text("")
    assert run_experiment(kaneko1991, "kaneko1991", ["--out", str(tmp_path / "file")]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_help_names_the_options(capsys):
    with pytest.raises(SystemExit):
        run_experiment(kaneko1991, "kaneko1991", ["--help"])
    text = capsys.readouterr().out
    assert "python -m experiments.kaneko1991" in text
    assert "--out" in text
    assert "--histories" in text


@pytest.mark.long
def test_everything_is_written(tmp_path, monkeypatch):
    for name in ("HEAVY", "OVERDAMPED"):
        dynamics = getattr(figure_4bc, name)
        coarse = dataclasses.replace(dynamics, steps=(max(dynamics.steps),))
        monkeypatch.setattr(figure_4bc, name, coarse)
    told = set()
    recorder = contextlib.nullcontext(lambda what, done, total: told.add((what, done <= total)))
    monkeypatch.setattr(program, "progress_bar", lambda: recorder)
    kaneko1991(tmp_path, histories=2)
    assert told
    assert all(fits for _, fits in told)
    result = json.loads((tmp_path / "result.json").read_text("utf-8"))
    assert result["agreement"]["max_difference_of_range"] < 0.005
    assert result["figure_4a"]["slope_error"] < 0.005
    routes = {"closed form", "continuum", "sheath alone", "elements"}
    routes |= {"plugin in MuJoCo", "elements in MuJoCo"}
    assert set(result["seconds_per_simulated_second"]) == routes
    assert max(c["error"] for c in result["cost"]) <= 0.01
    widening = list(result["figure_5"]["widening_by_constant_friction"].values())
    assert widening == sorted(widening, reverse=True)
    pictures = {p.stem for p in tmp_path.glob("*.png")}
    assert pictures >= {f"figure_{name}" for name in ("4a", "4b", "4c", "5")}
    assert pictures >= {"agreement", "refinement", "stiction", "cost"}
    page = (tmp_path / "numbers.md").read_text("utf-8")
    assert "| elements in MuJoCo |" in page
    assert "nan" not in page
