"""Springs that balance a load where a model starts: stiffness and rest position go together."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tendon_mj.lab.diagnosis import CATALOGUE, Candidate, SystemDescription, written
from tests.lab.diagnosis.test_wrong_numbers import diagnosed

STIFFNESS, REST = 0.8, np.radians(10.0)  # of the pendulum's spring


def bound(springref: float, reference: float = 0.0) -> list[Candidate]:
    """Candidates for a wrong spring of a joint that rests there."""
    rig = SystemDescription(
        values={"a.stiffness": 2.0, "a.springref": springref},
        known=frozenset(),
        uncertain=frozenset(),
        spans={},
        inputs=(),
        free_joints=("a",),
        reference={"a.springref": reference},
    )
    return CATALOGUE["joint_spring"].bind(rig)


@pytest.mark.parametrize("reference", [0.0, 0.4])
@pytest.mark.parametrize("factor", [0.5, 1.0, 3.0])
def test_a_stiffer_spring_keeps_its_torque_in_the_reference_pose(
    factor: float, reference: float
) -> None:
    (candidate,) = bound(-0.3, reference)
    base = {"a.stiffness": 2.0, "a.springref": -0.3}
    found = written(candidate.terms, [factor, 1.0], base)
    assert found["a.stiffness"] == pytest.approx(2.0 * factor)
    torque = found["a.stiffness"] * (found["a.springref"] - reference)
    assert torque == pytest.approx(2.0 * (-0.3 - reference))


def test_a_spring_that_rests_in_the_reference_pose_has_one_number() -> None:
    assert bound(0.0) == bound(0.4, 0.4) == []


@pytest.mark.parametrize("factor", [0.75, 1.25])
@pytest.mark.parametrize("torque", [1.0, 1.1])  # of the model's, in the reference pose
def test_a_wrong_spring_is_found_with_its_rest_position(
    factor: float, torque: float, tmp_path: Path
) -> None:
    truth = {"elbow.stiffness": factor * STIFFNESS, "elbow.springref": REST * torque / factor}
    found = diagnosed("motor", truth, tmp_path)
    assert (found.verdict, found.effects) == ("parameter", ["joint_spring"])
    for name, value in truth.items():
        assert found.parameters[name].low <= value <= found.parameters[name].high
        assert found.parameters[name].value == pytest.approx(value, rel=0.03)
    assert "the stiffness of joint elbow is too" in found.sentence
    assert "the rest position of the spring of joint elbow is wrong" in found.sentence


def test_no_weight_is_more_than_that_of_any_attitude(tmp_path: Path) -> None:
    rig = SystemDescription(
        values={
            f"gravity.{axis}": value for axis, value in zip("xyz", (0.0, 0.0, -9.81), strict=True)
        },
        known=frozenset(),
        uncertain=frozenset(),
        spans={},
        inputs=(),
        free_joints=(),
    )
    for candidate in CATALOGUE["gravity_load"].bind(rig):
        (term,) = candidate.terms
        assert (term.low, term.high) == (-10.0, 10.0)
    turned = diagnosed("motor", {"gravity.x": 6.0}, tmp_path)
    assert (turned.verdict, turned.effects) == ("named", ["gravity_load"])
    assert turned.parameters["gravity.x"].value == pytest.approx(6.0, rel=0.02)
