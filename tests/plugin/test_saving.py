"""A model that was saved and loaded again behaves bit by bit as it did."""

import copy
import pickle
import subprocess
import sys

import mujoco
import numpy as np
import pytest

from tests.plugin.rigs import arm, arm_xml, run, snapshot, started


def assert_alike(model, other):
    assert model.npluginstate == other.npluginstate
    one, two = (run(m, started(m, 6, 2.0), 200) for m in (model, other))
    np.testing.assert_array_equal(snapshot(model, one), snapshot(other, two))
    np.testing.assert_array_equal(one.sensordata, two.sensordata)


def test_a_binary_model(tmp_path):
    model = arm(spools=True, axial_damping=0.5)
    file = str(tmp_path / "arm.mjb")
    mujoco.mj_saveModel(model, file, None)
    assert_alike(model, mujoco.MjModel.from_binary_path(file))


@pytest.mark.parametrize("friction", [0.2, 1.0 / 3.0])
def test_a_text_model_through_mjspec(friction):
    spec = mujoco.MjSpec.from_string(arm_xml(spools=True, friction=friction, axial_damping=0.5))
    model = spec.compile()
    text = spec.to_xml()
    again = mujoco.MjSpec.from_string(text)
    assert_alike(model, again.compile())
    assert again.to_xml() == text


def test_a_text_model_through_the_last_xml(tmp_path):
    model = arm(spools=True)
    mujoco.mj_saveLastXML(str(tmp_path / "arm.xml"), model)
    assert_alike(model, mujoco.MjModel.from_xml_path(str(tmp_path / "arm.xml")))


def test_a_copy_and_a_pickle_of_a_model():
    model = arm(spools=True)
    assert_alike(model, copy.deepcopy(model))
    assert_alike(model, pickle.loads(pickle.dumps(model)))


LOADER = """
import sys
import mujoco
try:
    mujoco.MjModel.from_xml_path(sys.argv[1])
except ValueError as error:
    print(error)
print("alive")
"""


def test_without_the_package_a_saved_model_is_refused_by_name(tmp_path):
    file = tmp_path / "arm.xml"
    mujoco.mj_saveLastXML(str(file), arm())
    done = subprocess.run(
        [sys.executable, "-c", LOADER, str(file)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "tendon_mj.sheath" in done.stdout
    assert "alive" in done.stdout
