"""Laws of verdicts on disk: what README.md allows is scored, anything else refused in a line."""

import json

import pytest

from experiments.command import run_experiment
from experiments.hidden_effects.compare import compare
from experiments.hidden_effects.score import score
from experiments.hidden_effects.verdicts import judge
from tendon_mj.errors import InvalidValueError, TendonError, UnknownNameError
from tests.refusals import refusing

KEY = {
    "kind": "effect",
    "hidden": ["creep"],
    "target": 5.0,
    "reached": True,
    "noise": 0.002,
    "parameters": {"sheath.creep": 0.2},
}
RIGHT = {"verdict": "named", "effects": ["creep"], "seconds": 2.0}


def write_keys(folder, *cases, **key):
    folder.mkdir(exist_ok=True)
    (folder / "keys.json").write_text(json.dumps({"cases": {c: {**KEY, **key} for c in cases}}))


def write(folder, case, result=None, run=None):
    (folder / case).mkdir(parents=True, exist_ok=True)
    for name, content in (("result", result), ("run", run)):
        if content is not None:
            text = content if isinstance(content, str) else json.dumps(content)
            (folder / case / f"{name}.json").write_text(text)


def read(folder, result=None, run=None):
    """The one case of a suite."""
    write_keys(folder, "a")
    write(folder, "a", result, run)
    (case,) = judge(folder, folder)
    return case


def test_any_tool_s_results_are_scored_and_a_case_without_one_failed(tmp_path):
    write_keys(tmp_path, "a", "b")
    write(tmp_path, "a", {"verdict": "named", "effects": ["creep"]})
    found, missing = judge(tmp_path, tmp_path)
    assert (found.name, found.hit, found.closed, found.left) == ("a", 1.0, None, None)
    assert (missing.name, missing.missing, missing.verdict) == ("b", True, "failed")


def test_a_suite_without_any_verdict_is_refused(tmp_path):
    write_keys(tmp_path, "a", "b")
    with refusing(TendonError, "no verdict on any of the 2 cases"):
        judge(tmp_path, tmp_path)
    with refusing(InvalidValueError, "--keys is the folder of keys"):
        judge(tmp_path, tmp_path / "none")


def test_what_may_be_missing_may_be_null(tmp_path):
    others = ("indistinguishable", "parameters", "confidence", "gap", "seconds")
    case = read(tmp_path, {"verdict": "named", "effects": ["creep"], **dict.fromkeys(others)})
    assert (case.hit, case.errors(), case.left, case.seconds) == (1.0, [], None, None)
    case = read(tmp_path, {**RIGHT, "gap": {"held_out": None}}, {"seconds": None, "error": None})
    assert (case.left, case.seconds) == (None, 2.0)


def test_seconds_are_of_either_file_and_an_error_is_a_failure(tmp_path):
    assert read(tmp_path, RIGHT, {"error": ""}).seconds == 2.0
    assert read(tmp_path, RIGHT, {"seconds": 3.0, "error": ""}).seconds == 3.0
    failed = read(tmp_path, "{ half of a fi", {"seconds": 3.0, "error": "diverged"})
    assert (failed.verdict, failed.missing, failed.seconds) == ("failed", False, 3.0)


INTERVAL = {"value": 1.0, "low": 0.0, "high": 2.0}


@pytest.mark.parametrize(
    ("result", "message"),
    [
        ("{", "cannot be read as JSON .* write it again"),
        ('{"verdict": "unknown", "seconds": NaN}', "NaN is no number"),
        ("[" * 100_000, "cannot be read as JSON"),
        ("[]", r"must be an object, such as .*, got \[\]"),
        ({}, "verdict: must be one of 'named', .*, got nothing"),
        ({"verdict": ["named"]}, r"verdict: must be one of .*, got \['named'\]"),
        ({"verdict": "namd"}, "unknown verdict 'namd'; did you mean 'named'"),
        ({"verdict": "named", "effects": []}, "names nothing; where nothing can be named"),
        ({"verdict": "named", "effects": "backlash"}, "effects: must be a list of .* 'backlash'$"),
        ({"verdict": "named", "effects": [1]}, "effects: must be a list of identifiers"),
        ({"verdict": "named", "effects": ["back_lash"]}, "did you mean 'backlash'"),
        ({**RIGHT, "indistinguishable": "creep"}, "indistinguishable: must be a list of groups"),
        ({**RIGHT, "indistinguishable": ["creep"]}, r"indistinguishable\[0\]: must be a list"),
        ({**RIGHT, "indistinguishable": [["creep", "creeb"]]}, "did you mean 'creep'"),
        ({**RIGHT, "parameters": [1.0]}, "parameters: must be an object"),
        ({**RIGHT, "parameters": {"a.b": 1.0}}, "parameters, a.b: must be an object, got 1.0"),
        ({**RIGHT, "parameters": {"a.b": {"value": 1.0, "low": 0.0}}}, "'a.b' lacks high"),
        ({**RIGHT, "parameters": {"a.b": {**INTERVAL, "low": "0"}}}, "low: must be a finite"),
        ({**RIGHT, "parameters": {"a.b": {**INTERVAL, "low": 3.0}}}, "low: must be at most high"),
        (
            {**RIGHT, "confidence": 97},
            "confidence: must be a finite number and ≥ 0 and ≤ 1, got 97",
        ),
        ({**RIGHT, "seconds": "2 s"}, "seconds: must be a finite number and ≥ 0, got '2 s'"),
        ({**RIGHT, "seconds": True}, "seconds: must be a finite number"),
        ('{"verdict": "unknown", "seconds": 1e999}', "seconds: must be a finite number"),
        ({**RIGHT, "gap": 1.0}, "gap: must be an object"),
        ({**RIGHT, "gap": {"held_out": {"after": -1.0}}}, "gap.held_out, after: must be"),
    ],
)
def test_a_result_that_is_not_one_is_refused_with_its_file(result, message, tmp_path):
    with pytest.raises((InvalidValueError, UnknownNameError), match=message) as refused:
        read(tmp_path, result)
    assert str(tmp_path / "a" / "result.json") in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_run_that_is_not_one_is_refused_with_its_file(tmp_path):
    with refusing(InvalidValueError, "run.json, error: must be a text"):
        read(tmp_path, RIGHT, {"error": True})
    with refusing(InvalidValueError, "run.json, seconds: must be"):
        read(tmp_path, RIGHT, {"seconds": "long"})


def command(tool, tmp_path, *arguments):
    """Exit status of a command on folders in a temporary one."""
    paths = [a if a.startswith("--") else str(tmp_path / a) for a in arguments]
    return run_experiment(tool, f"hidden_effects.{tool.__name__}", paths)


@pytest.mark.parametrize("tool", [score, compare])
def test_a_command_refuses_what_it_cannot_read_in_one_line(tool, tmp_path, capsys):
    write_keys(tmp_path / "keys", "a")
    write(tmp_path / "tool", "a", "{")
    assert command(tool, tmp_path, "--verdicts", "tool", "--keys", "keys", "--out", "out") == 2
    error = capsys.readouterr().err
    assert error.startswith(f"python -m experiments.hidden_effects.{tool.__name__}: ")
    assert error.count("\n") == 1


def test_verdicts_without_keys_are_refused(tmp_path, capsys):
    arguments = ("--verdicts", "one", "two", "--keys", "keys", "--out", "out")
    assert command(score, tmp_path, *arguments) == 2
    assert "--verdicts names 2 folders and --keys 1" in capsys.readouterr().err


def test_a_score_counts_and_tells_the_cases_without_a_result(tmp_path):
    write_keys(tmp_path / "keys", "a", "b", "c", "d")
    write(tmp_path / "tool", "a", RIGHT)
    arguments = ("--verdicts", "tool", "--keys", "keys", "--out", "out")
    first = "one effect, residual ≥ 5 noise: first (tie: half)"

    def figure(quantity):
        return json.loads((tmp_path / "out" / "score.json").read_text("utf-8"))[quantity]

    assert command(score, tmp_path, *arguments) == 0
    text = (tmp_path / "out" / "score.md").read_text("utf-8")
    assert "Cases without a result: 3 of 4 (tool/b, tool/c, tool/d)" in text
    assert figure(first) == {"wanted": "≥ 97 %", "figure": "25.0 %", "cases": 4}
    assert figure("cases without a result, which count as failed")["figure"] == "3"
    assert command(score, tmp_path, *arguments, "--partial") == 0
    text = (tmp_path / "out" / "score.md").read_text("utf-8")
    assert "Scored are the 1 of 4 cases with a result" in text
    assert figure(first)["figure"] == "100.0 %"


def test_a_right_verdict_without_an_error_on_held_out_data_is_no_miss(tmp_path):
    write_keys(tmp_path / "keys", "a")
    write(tmp_path / "tool", "a", {"verdict": "named", "effects": ["creep"]})
    assert command(score, tmp_path, "--verdicts", "tool", "--keys", "keys", "--out", "out") == 0
    assert len((tmp_path / "out" / "misses.csv").read_text("utf-8").splitlines()) == 1
    text = (tmp_path / "out" / "score.md").read_text("utf-8")
    assert "| seconds per diagnosis, as stated, median / longest |  | – | 0 |" in text
    assert "nan" not in text


def test_a_failed_case_is_a_miss_of_whatever_kind(tmp_path):
    write_keys(tmp_path / "keys", "a", "b", kind="outside")
    write(tmp_path / "tool", "a", run={"error": "diverged"})
    assert command(score, tmp_path, "--verdicts", "tool", "--keys", "keys", "--out", "out") == 0
    lines = (tmp_path / "out" / "misses.csv").read_text("utf-8").splitlines()
    assert [line.split(",")[6] for line in lines[1:]] == ["failed", "no result"]


def test_a_case_that_one_tool_lacks_counts_for_the_others(tmp_path, capsys):
    write_keys(tmp_path / "keys", "a", "b", "c", "d")
    for case in "abcd":
        write(tmp_path / "whole", case, {**RIGHT, "gap": {"held_out": {"after": 1.5}}})
    write(tmp_path / "picked", "a", {**RIGHT, "gap": {"held_out": {"after": 1.0}}})
    arguments = ("--verdicts", "whole", "picked", "--keys", "keys")
    assert command(compare, tmp_path, *arguments) == 0
    text = capsys.readouterr().out
    assert "first (tie: half) | ≥ 97 % | 100.0 % | 25.0 % | 4 |" in text
    assert "worst decile [noise] |  | 1.50 / 1.50 | 1.00 / 1.00 (of 1) | 4 |" in text
    assert "cases without a result, which count as failed | 0 | 0 | 3 | 4 |" in text
    assert command(compare, tmp_path, *arguments, "--partial") == 0
    text = capsys.readouterr().out
    assert "first (tie: half) | ≥ 97 % | 100.0 % | 100.0 % | 1 |" in text
    assert "Scored are the 1 of 4 cases on which each tool has a result" in text


def test_tools_without_a_case_in_common_have_nothing_in_part(tmp_path, capsys):
    write_keys(tmp_path / "keys", "a", "b")
    write(tmp_path / "one", "a", RIGHT)
    write(tmp_path / "two", "b", RIGHT)
    arguments = ("--verdicts", "one", "two", "--keys", "keys")
    assert command(compare, tmp_path, *arguments, "--partial") == 2
    assert "no case on which each of the tools has a result" in capsys.readouterr().err
    assert command(compare, tmp_path, *arguments) == 0
