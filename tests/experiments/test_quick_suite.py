"""A few hidden cases, made, diagnosed and scored; the full suite has hundreds."""

from __future__ import annotations

import json
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import pytest

from experiments.hidden_effects.case import make_case
from experiments.hidden_effects.case_plan import CasePlan
from experiments.hidden_effects.diagnose_suite import SuiteDiagnosis, diagnose_suite
from experiments.hidden_effects.judged_case import JudgedCase
from experiments.hidden_effects.score import judge

SEED = 900  # not used for tuning


def plan(number: int, kind: str, *names: str, exclude: tuple[str, ...] = ()) -> CasePlan:
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
    "pair": plan(5, "pair", "direction_asymmetry", "sensor_gain"),
    "wrong_parameter": plan(6, "parameter", "axial_stiffness"),
    "nothing": plan(7, "nothing"),
    "nothing_too": plan(8, "nothing"),
    "outside": plan(9, "outside", "friction_drift", exclude=("friction_drift",)),
}


@pytest.fixture(scope="module")
def judged(tmp_path_factory: pytest.TempPathFactory) -> dict[str, JudgedCase]:
    """Every case beside its key; keys are read after the verdicts are written."""
    root = tmp_path_factory.mktemp("suite")
    folders = [root / "cases" / name for name in PLANS]
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        made = list(pool.map(make_case, PLANS.values(), folders))
    diagnose_suite(SuiteDiagnosis(suite=root / "cases", out=root / "verdicts", processes=2))
    (root / "keys").mkdir()
    keys = {"cases": dict(zip(PLANS, made, strict=True))}
    (root / "keys" / "keys.json").write_text(json.dumps(keys))
    return {j.name: j for j in judge(root / "verdicts", Path(root / "keys"))}


@pytest.mark.parametrize("name", ["viscous", "constant", "backlash", "delay"])
def test_one_effect_is_named_first_and_measured(judged: dict[str, JudgedCase], name: str) -> None:
    found = judged[name]
    assert found.hit > 0.0
    assert found.extra == []
    assert found.closed is not None
    assert found.closed > 0.8
    assert all(error < 0.2 for _, error, _ in found.errors())


def test_two_effects_are_both_found(judged: dict[str, JudgedCase]) -> None:
    assert judged["pair"].contains


def test_a_wrong_parameter_is_no_missing_effect(judged: dict[str, JudgedCase]) -> None:
    assert judged["wrong_parameter"].verdict == "parameter"
    assert judged["wrong_parameter"].result is not None
    findings = judged["wrong_parameter"].result["findings"]
    assert "axial_stiffness" in {f["identifier"] for f in findings}.union(
        *(f["rivals"] for f in findings)
    )


@pytest.mark.parametrize("name", ["nothing", "nothing_too"])
def test_with_nothing_hidden_nothing_is_named(judged: dict[str, JudgedCase], name: str) -> None:
    assert judged[name].verdict == "nothing missing"


def test_outside_the_catalogue_no_effect_is_confident(
    judged: dict[str, JudgedCase],
) -> None:
    assert judged["outside"].verdict != "failed"
    assert not judged["outside"].confident
