"""A suite is solved case by case; one that cannot be read stops no other."""

import json
import shutil
import sys
from pathlib import Path

import pytest

from experiments.command import run_experiment
from experiments.hidden_effects.case_folder import solve_suite
from experiments.hidden_effects.diagnose_suite import diagnose_suite
from experiments.hidden_effects.rivals.rig import run_rival
from tendon_mj.errors import InvalidValueError, RecordingError
from tendon_mj.models import example_recording, model_path
from tests.refusals import refusing


def solve(case):
    """Result that a tool could give."""
    return {"verdict": "nothing", "effects": [], "samples": len(case.train[0].time)}


def write_case(folder, model="bench"):
    folder.mkdir(parents=True)
    recording = example_recording()
    for name in ("train_1", "held_out_1"):
        shutil.copy(recording, folder / f"{name}.csv")
        toml = recording.with_suffix(".toml").read_text("utf-8")
        assert 'model = "bench"' in toml
        text = toml.replace('model = "bench"', f'model = "{model}"')
        (folder / f"{name}.toml").write_text(text, "utf-8")
    (folder / "case.json").write_text('{"exclude": []}')


def solved(base, capsys):
    """Names of the cases that a run solves."""
    solve_suite(solve, base / "suite", base / "out", cases=0, again=False, processes=1)
    lines = capsys.readouterr().out.splitlines()
    return {line.partition(": ")[2].split()[0] for line in lines}


def replaced(path, content):
    """Break a file, or remove it."""
    path.unlink() if content is None else path.write_text(content)


def test_cases_that_cannot_be_read_are_told_and_stop_no_other(tmp_path, capsys):
    broken = {
        "table": ("train_1.csv", "time_s\nx\n", "train_1.csv"),
        "description": ("train_1.toml", "[", "train_1.toml"),
        "half": ("case.json", "{", 'case.json: it is not like {"exclude": []}'),
        "list": ("case.json", "[]", 'case.json: it is not like {"exclude": []}'),
        "number": ("case.json", '{"exclude": 5}', "exclude is 5"),
        "deep": ("case.json", "[" * 200_000, 'case.json: it is not like {"exclude": []}'),
        "nothing": ("train_1.csv", None, "no train_*.csv"),
    }
    for name in (*broken, "whole"):
        write_case(tmp_path / "suite" / name)
    for name, (file, content, _) in broken.items():
        replaced(tmp_path / "suite" / name / file, content)
    assert solved(tmp_path, capsys) == {*broken, "whole"}
    for name, (_, _, said) in broken.items():
        told = json.loads((tmp_path / "out" / name / "run.json").read_text("utf-8"))
        assert said in told["error"]
        assert not (tmp_path / "out" / name / "result.json").exists()
    assert json.loads((tmp_path / "out" / "whole" / "result.json").read_text("utf-8"))
    assert solved(tmp_path, capsys) == set()


def test_outcomes_that_are_not_there_or_broken_are_computed_again(tmp_path, capsys):
    contents = (None, "", '{"seconds": 1', "[]", "1", "[" * 200_000)
    broken = {
        f"{file}_{k}": (f"{file}.json", content)
        for file in ("run", "result")
        for k, content in enumerate(contents)
    }
    for name in (*broken, "whole"):
        write_case(tmp_path / "suite" / name)
    assert solved(tmp_path, capsys) == {*broken, "whole"}
    for name, (file, content) in broken.items():
        replaced(tmp_path / "out" / name / file, content)
    assert solved(tmp_path, capsys) == {*broken}
    assert solved(tmp_path, capsys) == set()


def test_a_case_whose_model_or_recording_changed_is_solved_again(tmp_path, capsys):
    model = tmp_path / "model.xml"
    text = model_path("bench").read_text("utf-8")
    model.write_text(text, "utf-8")
    write_case(tmp_path / "suite" / "case_1", "../../model.xml")
    assert solved(tmp_path, capsys) == {"case_1"}
    assert 'timestep="' in text
    model.write_text(text.replace('timestep="', 'timestep="1', 1), "utf-8")
    assert solved(tmp_path, capsys) == {"case_1"}
    assert solved(tmp_path, capsys) == set()
    (tmp_path / "suite" / "case_1" / "train_1.csv").write_text("time_s\nx\n")
    assert solved(tmp_path, capsys) == {"case_1"}  # with an error, and no earlier verdict
    assert [path.name for path in (tmp_path / "out" / "case_1").iterdir()] == ["run.json"]


def recorded_again(case):
    """Result of a tool while somebody records again."""
    table = Path(case.train[0].beside, "train_1.csv")
    table.write_text("\n".join(table.read_text("utf-8").splitlines()[:300]) + "\n")
    return solve(case)


def test_a_case_that_changes_while_it_is_solved_is_solved_again(tmp_path, capsys):
    write_case(tmp_path / "suite" / "case_1")
    where = tmp_path / "suite", tmp_path / "out"
    solve_suite(recorded_again, *where, cases=0, again=False, processes=1)
    capsys.readouterr()
    assert solved(tmp_path, capsys) == {"case_1"}


def test_outcomes_go_beside_the_suite_and_cases_are_counted_from_the_first(tmp_path):
    write_case(tmp_path / "suite" / "case_1")
    for out, cases, said in (("suite", 0, "would be read as files"), ("out", -1, "cases = -1")):
        with refusing(InvalidValueError, said):
            solve_suite(solve, tmp_path / "suite", tmp_path / out, cases=cases, again=False)


def test_what_is_no_suite_is_refused(tmp_path):
    with refusing(RecordingError, "no folder in it has a case"):
        solve_suite(solve, tmp_path / "none", tmp_path / "out", cases=0, again=False)


@pytest.mark.parametrize("options", [[], ["--processes", "0"]])
def test_commands_refuse_in_a_line(options, tmp_path, capsys, monkeypatch):
    arguments = ["--suite", str(tmp_path), "--out", str(tmp_path / "out"), *options]
    monkeypatch.setattr(sys, "argv", ["any", *arguments])
    assert run_rival(solve, "any") == 2
    assert run_experiment(diagnose_suite, "any", arguments) == 2
    assert capsys.readouterr().err.count("\n") == 2
