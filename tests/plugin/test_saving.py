"""A model that was saved, pickled or loaded again behaves bit by bit as it did."""

import copy
import pickle
import re
import subprocess
import sys

import mujoco
import numpy as np
import pytest

from tendon_mj.plugin import pickles
from tests.refusals import refusing
from tests.rigs import arm, arm_xml, run, snapshot, started


def assert_alike(model, other):
    assert model.npluginstate == other.npluginstate
    one, two = (run(m, started(m, 6, 2.0), 200) for m in (model, other))
    np.testing.assert_array_equal(snapshot(model, one), snapshot(other, two))
    np.testing.assert_array_equal(one.sensordata, two.sensordata)


def by_mjb(model, folder):
    mujoco.mj_saveModel(model, str(folder / "arm.mjb"), None)
    return mujoco.MjModel.from_binary_path(str(folder / "arm.mjb"))


def by_last_xml(model, folder):
    mujoco.mj_saveLastXML(str(folder / "arm.xml"), model)
    return mujoco.MjModel.from_xml_path(str(folder / "arm.xml"))


def by_pickle(model, folder):
    return pickle.loads(pickle.dumps(model))


def by_copy(model, folder):
    return copy.deepcopy(model)


@pytest.mark.parametrize("friction", [0.2, 1.0 / 3.0])
@pytest.mark.parametrize("again", [by_mjb, by_last_xml, by_pickle, by_copy])
def test_a_model_that_is_saved_and_loaded(again, friction, tmp_path):
    model = arm(spools=True, axial_damping=0.5, friction=friction)
    assert_alike(model, again(model, tmp_path))


def test_a_spec_is_written_as_it_is_and_read_as_it_was():
    text = mujoco.MjSpec.from_string(arm_xml(friction=1.0 / 3.0)).to_xml()
    assert mujoco.MjSpec.from_string(text).to_xml() == text


def test_without_the_package_a_saved_model_is_refused_by_name(tmp_path):
    mujoco.mj_saveLastXML(str(tmp_path / "arm.xml"), arm())
    load = f"import mujoco; mujoco.MjModel.from_xml_path({str(tmp_path / 'arm.xml')!r})"
    done = subprocess.run([sys.executable, "-c", load], capture_output=True, text=True, check=False)
    assert done.returncode == 1, "no crash"
    assert re.search("ValueError: .*tendon_mj.sheath", done.stderr)


SPAWN = """
import multiprocessing, pickle, sys
from concurrent.futures import ProcessPoolExecutor
import worker
if __name__ == "__main__":
    kept = pickle.load(open(sys.argv[1], "rb"))
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        print([worker.step(*kept), pool.submit(worker.step, *kept).result(timeout=100)])
"""
WORKER = """
import sys
import mujoco
def step(model, data):
    mujoco.mj_step(model, data, 10)
    return data.sensordata.tolist()
"""


def test_a_process_that_only_knows_mujoco_and_its_workers_step_them(tmp_path):
    model = arm(spools=True)
    data = run(model, started(model, 6, 2.0), 20)
    for name, content in (("worker.py", WORKER), ("main.py", SPAWN)):
        (tmp_path / name).write_text(content)
    (tmp_path / "kept").write_bytes(pickle.dumps((model, data)))
    command = [sys.executable, str(tmp_path / "main.py"), str(tmp_path / "kept")]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    assert eval(done.stdout) == [run(model, data, 10).sensordata.tolist() for _ in range(2)]


def test_other_models_pickle_as_ever():
    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    for stock in (model, mujoco.MjData(model)):
        assert b"tendon_mj" not in pickle.dumps(stock)
        assert type(pickle.loads(pickle.dumps(stock))) is type(stock)


def test_another_order_of_plugins_is_refused(monkeypatch):
    text = pickle.dumps(arm())
    monkeypatch.setattr(pickles, "plugin_at", lambda slot: "somebody.else")
    with refusing(RuntimeError, "tendon_mj.sheath in slot", "somebody.else"):
        pickle.loads(text)


def test_a_binary_model_of_a_process_with_another_plugin_there_is_refused(tmp_path):
    model = arm()
    model.plugin[:] = 15  # a placeholder's, whatever plugins this MuJoCo has
    with refusing(mujoco.FatalError, "tendon_mj.reserved.15 instance 'input_tension'"):
        mujoco.MjData(by_mjb(model, tmp_path))


def test_a_model_that_stored_fewer_numbers_of_state_is_refused(tmp_path):
    """As another release did, of a state that was smaller."""
    model, file = arm(), tmp_path / "arm.mjb"
    mujoco.mj_saveModel(model, str(file), None)
    content = file.read_bytes()
    parts = model.plugin, model.plugin_stateadr, model.plugin_statenum
    before = np.concatenate(parts).astype(np.int32).tobytes()
    assert content.count(before) == 1
    numbers = model.plugin_statenum - np.array([1] + [0] * (model.nplugin - 1))
    after = np.concatenate([*parts[:2], numbers]).astype(np.int32).tobytes()
    file.write_bytes(content.replace(before, after))
    older = mujoco.MjModel.from_binary_path(str(file))
    with pytest.raises(mujoco.FatalError, match=str(model.plugin_statenum[0])):
        mujoco.MjData(older)
