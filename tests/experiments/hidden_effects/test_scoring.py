"""Scores and verdict files on made-up verdicts whose figures are known."""

import json
import math

import pytest

from experiments.command import run_experiment
from experiments.hidden_effects.compare import compare
from experiments.hidden_effects.score import score
from experiments.hidden_effects.statistics import table
from experiments.hidden_effects.verdicts import JudgedCase, judge
from tendon_mj.errors import InvalidValueError, UnknownNameError
from tests.refusals import refusing

KEY = {
    "kind": "effect",
    "hidden": ["creep"],
    "target": 5.0,
    "reached": True,
    "parameters": {"sheath.creep": 0.2},
}
RESULT = {
    "verdict": "named",
    "effects": ["creep"],
    "indistinguishable": [],
    "confidence": 0.97,
    "parameters": {"sheath.creep": {"value": 0.21, "low": 0.19, "high": 0.23, "unit": "-"}},
    "gap": {"held_out": {"reducible_closed": 0.98}},
}


NOTHING = {"kind": "nothing", "hidden": []}


def judged(key=None, **result):
    return JudgedCase("case", {**KEY, **(key or {})}, {**RESULT, **result}, 1.0)


def figures(*cases):
    return {quantity: figure for quantity, _, figure, _ in table(cases)}


TOO_HIGH = {"kind": "too_high", "hidden": ["joint_damping"], "parameters": {"joint.damping": 19.0}}
GROUP = ["stiffening", "creep", "backlash", "sensor_lag"]
WRONGLY = ["stiffening", "backlash", "sensor_lag"]
PAIRS = [["stiffening", rival] for rival in ("creep", "backlash", "sensor_lag")]


def number(low, high, name="joint.damping", **result):
    """Result that calls a number wrong, with an interval of the right one."""
    parameters = {name: {"value": 0.5 * (low + high), "low": low, "high": high}}
    given = {"verdict": "parameter", "effects": ["joint_damping"], "parameters": parameters}
    return TOO_HIGH, given | result


BESIDE = {
    "joint.armature": {"value": 0, "low": 0, "high": 0},
    **number(18.0, 20.0)[1]["parameters"],
}


@pytest.mark.parametrize(
    ("key", "result", "judgements"),
    [
        # a hit counts one, a tie a half, and a wrong name nothing; in part counts like a name
        ({}, {}, {"hit": 1.0}),
        ({}, {"verdict": "partly"}, {"hit": 1.0}),
        ({}, {"indistinguishable": [["creep", "stiffening"]]}, {"hit": 0.5}),
        ({}, {"effects": ["stiffening"]}, {"hit": 0.0}),
        ({}, {"effects": ["stiffening", "creep"]}, {"hit": 0.0, "contains": True}),
        ({}, {"verdict": "unknown", "effects": []}, {"hit": 0.0, "extra": []}),
        # a false name is one where nothing is hidden
        (NOTHING, {}, {"named_effect": True}),
        (NOTHING, {"verdict": "partly"}, {"named_effect": True}),
        (NOTHING, {"verdict": "nothing missing", "effects": []}, {"named_effect": False}),
        (NOTHING, {"verdict": "parameter", "effects": ["friction"]}, {"named_effect": False}),
        # a number falsely called wrong is a false name and takes the lead
        (
            {},
            {"verdict": "partly", "effects": ["friction", "creep"]},
            {"hit": 1.0, "leads": 0.0, "extra": [], "false_names": ["friction"]},
        ),
        ({}, {"verdict": "parameter", "effects": ["friction"]}, {"false_names": ["friction"]}),
        ({}, {"verdict": "partly", "effects": ["creep", "friction"]}, {"leads": 1.0}),
        # a number is rightly wrong with its element alone and the truth in its interval
        (*number(18.0, 20.0), {"right_number": True}),
        (*number(20.0, 21.0), {"right_number": False}),
        (*number(18.0, 20.0, verdict="named"), {"right_number": False}),
        (*number(18.0, 20.0, "other.damping"), {"right_number": False}),
        (*number(18.0, 20.0, parameters=BESIDE), {"right_number": False}),
        (
            *number(18.0, 20.0, effects=["joint_damping", "friction"]),
            {"right_number": False, "false_names": ["friction"]},
        ),
        # two rivals are a tie, and more are named wrongly, counted over all groups of a name
        (
            {},
            {"effects": ["stiffening"], "indistinguishable": [GROUP[:3]]},
            {"contains": True, "hit": 0.5, "false_names": []},
        ),
        (
            {},
            {"effects": ["stiffening"], "indistinguishable": [GROUP]},
            {"contains": False, "hit": 0.0, "ties": [], "false_names": WRONGLY},
        ),
        ({}, {"indistinguishable": [GROUP[:2]]}, {"hit": 0.5}),
        ({}, {"indistinguishable": [GROUP]}, {"false_names": WRONGLY}),
        (
            {},
            {"effects": ["stiffening"], "indistinguishable": PAIRS},
            {"contains": False, "false_names": WRONGLY},
        ),
        (
            {},
            {"effects": ["stiffening"], "indistinguishable": [["creep", "backlash"]]},
            {"contains": False, "false_names": ["stiffening"]},
        ),
        (
            {},
            {"verdict": "unknown", "effects": [], "indistinguishable": [["creep"]]},
            {"contains": False},
        ),
    ],
    ids=str,
)
def test_a_result_is_judged_by_its_names(key, result, judgements):
    case = judged(key, **result)
    assert {name: getattr(case, name) for name in judgements} == judgements


def test_a_drawn_bend_counts_as_the_bend_that_the_key_states_beyond_it():
    """The bench is drawn with π rad; keys say what a rig has more."""
    key = {"kind": "parameter", "hidden": ["bend_angle"], "parameters": {"sheath.extra_bend": -0.5}}
    bend = {"value": 2.7, "low": 2.6, "high": 2.8, "unit": "rad"}
    one = judged(
        key, verdict="parameter", effects=["bend_angle"], parameters={"sheath.drawn_bend": bend}
    )
    assert one.right_number
    [(name, error, covered)] = one.errors()
    assert (name, covered) == ("sheath.extra_bend", True)
    assert error == pytest.approx((2.7 - math.pi + 0.5) / 0.5)
    wrong = {"sheath.drawn_bend": {**bend, "low": 2.65}}
    assert not judged(key, verdict="parameter", parameters=wrong).right_number


def test_a_case_without_a_result_is_right_in_no_figure():
    kinds = ("effect", "pair", "parameter", "outside", "too_high", "session", "remainder")
    hidden = [["creep", "sensor_lag"] if kind == "pair" else ["creep"] for kind in kinds]
    cases = [
        JudgedCase(kind, {**KEY, "kind": kind, "hidden": names}, None, None, missing=True)
        for kind, names in zip(kinds, hidden, strict=True)
    ]
    rows = table([*cases, judged(NOTHING, verdict="nothing missing", effects=[])])
    wanted = {q: figure for q, wanted, figure, count in rows if wanted.startswith("≥") and count}
    assert len(wanted) == 7
    assert set(wanted.values()) == {"0.0 %"}
    by_name = {quantity: figure for quantity, _, figure, _ in rows}
    assert by_name["cases without a result, which count as failed"] == "7"
    assert by_name["failed"] == "87.5 %"


WRITTEN = KEY | {"noise": 0.002}
RIGHT = {"verdict": "named", "effects": ["creep"], "seconds": 2.0}


def write_keys(folder, *cases, **key):
    folder.mkdir(exist_ok=True)
    (folder / "keys.json").write_text(json.dumps({"cases": {c: {**WRITTEN, **key} for c in cases}}))


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


INTERVAL = {"value": 1.0, "low": 0.0, "high": 2.0}


@pytest.mark.parametrize(
    ("result", "facts"),
    [
        ("{", "JSON"),
        ('{"verdict": "unknown", "seconds": NaN}', "NaN"),
        ({}, "verdict: | nothing"),
        ({"verdict": "named", "effects": []}, "names nothing"),
        ({"verdict": "named", "effects": ["back_lash"]}, "did you mean 'backlash'"),
        ({**RIGHT, "indistinguishable": [["creep", "creeb"]]}, "did you mean 'creep'"),
        ({**RIGHT, "parameters": {"a.b": {**INTERVAL, "low": 3.0}}}, "a.b | low | high"),
        ({**RIGHT, "confidence": 97}, "confidence | 97"),
        ({**RIGHT, "gap": {"held_out": {"after": -1.0}}}, "gap.held_out, after"),
    ],
)
def test_a_result_that_is_not_one_is_refused_with_its_file(result, facts, tmp_path):
    file = tmp_path / "a" / "result.json"
    with refusing((InvalidValueError, UnknownNameError), file, facts):
        read(tmp_path, result)


def command(tool, tmp_path, *arguments):
    """Exit status of a command on folders in a temporary one."""
    paths = [a if a.startswith("--") else str(tmp_path / a) for a in arguments]
    return run_experiment(tool, f"hidden_effects.{tool.__name__}", paths)


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
    (tmp_path / "whole" / "a" / "result.json").unlink()
    assert command(compare, tmp_path, *arguments, "--partial") == 2
    assert "no case on which each of the tools has a result" in capsys.readouterr().err
