"""Runs at a model's own step and at a finer one, as the experiment compares them."""

import json

import mujoco
import numpy as np
import pytest

from experiments.step_convergence import controls, differences, simulate, step_convergence
from tendon_mj import add_friction
from tendon_mj.errors import InvalidValueError
from tests.refusals import refusing
from tests.rigs import FINGER

TENDONS = ["flexor"]
ARM = FINGER.format(more="").replace(
    "</mujoco>", '<actuator><motor name="pull" tendon="flexor"/></actuator></mujoco>'
)


@pytest.fixture
def runs():
    spec = mujoco.MjSpec.from_string(ARM)
    model = add_friction(spec, TENDONS, friction=0.2).compile()
    inputs = 2.0 * controls(model, 100, 1.0, seed=1) - 2.0
    return [simulate(model, TENDONS, inputs, refinement) for refinement in (1, 1, 4, 16)]


def test_a_finer_run_is_nearer_to_the_finest(runs):
    own, same, finer, finest = runs
    travel = np.ptp(finest.qpos, axis=0)
    for result in differences(own, same, np.array([0, 1]), travel).values():
        assert result == [0.0] * len(result)
    far, near = (differences(run, finest, np.array([0, 1]), travel) for run in (own, finer))
    for what in ("angle", "angle_over_own_travel", "output_tension", "total_friction_work"):
        assert max(near[what]) < 0.5 * max(far[what]) < 0.05


def test_result_has_a_row_for_each_stiffness(tmp_path):
    path = tmp_path / "arm.xml"
    path.write_text(ARM)
    step_convergence((path,), out=tmp_path / "out", stiffness=(1e4, 1e5), duration=0.1)
    result = json.loads((tmp_path / "out" / "result.json").read_text())["arm"]
    assert [row["axial_stiffness"] for row in result["rows"]] == [None, 1e4, 1e5]
    assert not any(row["unstable"] for row in result["rows"])
    path.write_text(ARM.replace('<motor name="pull" tendon="flexor"/>', ""))
    with refusing(InvalidValueError, "no actuator"):
        step_convergence((path,), out=tmp_path / "out")
