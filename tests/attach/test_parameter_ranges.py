"""Ranges of randomisation are the intervals of a proven diagnosis, under names that can be set."""

import json
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from tendon_mj import Parameters, diagnose, load_model, ranges
from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.diagnosis import Value
from tendon_mj.lab.diagnosis.data import Spread
from tests.lab.diagnosis.toy import Toy, rig
from tests.refusals import refusing

TRUTH = {"sheath.constant_friction": 1.0, "sheath.friction": 0.2}


@pytest.fixture(scope="module")
def diagnosis():
    """Of a rig with a friction that was uncertain and another that was missing."""
    return diagnose(*rig(1, TRUTH), Toy)


def written(folder, diagnosis):
    """The file of a diagnosis, as the command writes it."""
    path = folder / "result.json"
    path.write_text(json.dumps(diagnosis.result(), default=vars))
    return path


def test_the_truth_is_in_the_ranges_and_they_can_be_set(diagnosis, tmp_path):
    found = ranges(written(tmp_path, diagnosis))
    assert found.keys() == TRUTH.keys()
    model = load_model("bench")
    live = Parameters(model, mujoco.MjData(model))
    random = np.random.default_rng(0)
    for name, (low, high) in found.items():
        assert low < TRUTH[name] < high
        live[name] = random.uniform(low, high)
        assert low <= live[name] <= high


def test_a_number_of_each_recording_ranges_over_all_of_them(diagnosis, tmp_path):
    values = {"monday": 18.0, "tuesday": 21.0, "friday": 19.0}
    spread = {"sheath.pretension": Spread(2.0, 1.2, "N", values)}
    slip = {"input_tension.offset @ monday": Value(1.0, 0.9, 1.1, "N", 0.0)}
    parameters = {**diagnosis.parameters, **slip}
    given = replace(diagnosis, sessions=spread, parameters=parameters)
    found = ranges(written(tmp_path, given))
    assert found["sheath.pretension"] == (18.0, 21.0)
    assert found.keys() == {*TRUTH, "sheath.pretension"}


def test_what_is_not_determined_is_refused_or_taken_over_its_range(diagnosis, tmp_path):
    loose = {"sheath.friction": Value(0.2, 0.05, 0.4, "-", 0.15, determined=False)}
    path = written(tmp_path, replace(diagnosis, calibrated=loose))
    with refusing(InvalidValueError, path, "sheath.friction (0.05 … 0.4", "undetermined=True"):
        ranges(path)
    assert ranges(path, undetermined=True)["sheath.friction"] == (0.05, 0.4)


def test_what_proves_nothing_is_refused(diagnosis, tmp_path):
    with refusing(InvalidValueError, "result.json", "'unknown'", "proven"):
        ranges(written(tmp_path, replace(diagnosis, verdict="unknown")))
    other = tmp_path / "other.json"
    other.write_text("{}")
    with refusing(InvalidValueError, other, "diagnosis"):
        ranges(other)
