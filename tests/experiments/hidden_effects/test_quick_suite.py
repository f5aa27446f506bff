"""A few hidden cases, made, diagnosed and scored; the full suite has hundreds."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from experiments.hidden_effects.case import make_case
from experiments.hidden_effects.diagnose_suite import diagnose_suite
from experiments.hidden_effects.plan import CasePlan, Kind
from experiments.hidden_effects.verdicts import JudgedCase, judge

SEED = 900  # not used for tuning


def plan(number: int, kind: Kind, *names: str, exclude: tuple[str, ...] = ()) -> CasePlan:
    """A case with a residual of 5 noise, at 0.5 % noise."""
    target = 0.0 if kind == "nothing" else 5.0
    return CasePlan(
        kind=kind, names=names, target=target, noise=0.005, exclude=exclude, seed=(SEED, number)
    )


PLANS = {
    "viscous": plan(1, "effect", "viscous_friction"),
    "constant": plan(2, "effect", "constant_friction"),
    "backlash": plan(3, "effect", "backlash"),
    "delay": plan(4, "effect", "sensor_delay"),
    "pair": plan(5, "pair", "viscous_friction", "sensor_gain"),
    "wrong_parameter": plan(6, "parameter", "axial_stiffness"),
    "nothing": plan(7, "nothing"),
    "nothing_too": plan(8, "nothing"),
    "outside": plan(9, "outside", "friction_drift", exclude=("friction_drift",)),
}


def judged(name: str, root: Path) -> JudgedCase:
    """A case beside its key, which is written after the verdict is.

    Each test makes a case of its own, so that no case is diagnosed by more than one test process,
    from the first halves of two of its four training recordings, in a quarter of the time.
    """
    made = make_case(PLANS[name], root / "cases" / name)
    for left_out in ("train_3", "train_4"):
        for file in (root / "cases" / name).glob(f"{left_out}.*"):
            file.unlink()
    for table in (root / "cases" / name).glob("*.csv"):
        lines = table.read_text("utf-8").splitlines(keepends=True)
        table.write_text("".join(lines[: len(lines) // 2]), "utf-8")
    diagnose_suite(suite=root / "cases", out=root / "verdicts", processes=1)
    (root / "keys").mkdir()
    (root / "keys" / "keys.json").write_text(json.dumps({"cases": {name: made}}))
    (result,) = judge(root / "verdicts", root / "keys")
    return result


@pytest.mark.long
def test_two_effects_are_both_found(tmp_path: Path) -> None:
    assert judged("pair", tmp_path).contains


LONG = [pytest.param(name, marks=pytest.mark.long) for name in ("viscous", "constant", "delay")]


@pytest.mark.parametrize("name", ["backlash", *LONG])
def test_one_effect_is_named_first_and_measured(name: str, tmp_path: Path) -> None:
    result = judged(name, tmp_path)
    assert result.hit > 0.0
    assert result.extra == []
    assert result.closed is not None
    assert result.closed > 0.8
    assert all(error < 0.2 for _, error, _ in result.errors())


@pytest.mark.long
def test_a_wrong_parameter_is_no_missing_effect(tmp_path: Path) -> None:
    result = judged("wrong_parameter", tmp_path)
    assert result.verdict == "parameter"
    assert result.result is not None
    findings = result.result["findings"]
    assert "axial_stiffness" in {f["identifier"] for f in findings}.union(
        *(f["rivals"] for f in findings)
    )


@pytest.mark.parametrize("name", ["nothing", pytest.param("nothing_too", marks=pytest.mark.long)])
def test_with_nothing_hidden_nothing_is_named(name: str, tmp_path: Path) -> None:
    assert judged(name, tmp_path).verdict == "nothing missing"


@pytest.mark.long
def test_outside_the_catalogue_no_effect_is_confident(tmp_path: Path) -> None:
    result = judged("outside", tmp_path)
    assert result.verdict != "failed"
    assert not result.confident
