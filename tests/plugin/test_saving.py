"""A model that was saved, pickled or loaded again behaves bit by bit as it did; engines that run
no plugins refuse it by name."""

import copy
import importlib
import pickle
import subprocess
import sys

import mujoco
import numpy as np
import pytest

from tendon_mj.plugin import NAME, SERVO, elsewhere
from tendon_mj.plugin.elsewhere import guard_engines
from tests.refusals import refusing
from tests.rigs import arm, arm_xml, run, snapshot, started


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


LOAD = """
import pickle, sys
import mujoco
kept = pickle.load(open(sys.argv[1], "rb"))
model, data = kept["model"], kept["data"]
mujoco.mj_step(model, data)
print(*data.plugin_state)
"""
SPAWN = """
import multiprocessing
from concurrent.futures import ProcessPoolExecutor
import worker
if __name__ == "__main__":
    from tests.rigs import arm, started
    model = arm()
    data = started(model, 6, 2.0)
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        print(pool.submit(worker.step, model, data).result(timeout=100))
"""
WORKER = """
import sys
import mujoco
def step(model, data):
    mujoco.mj_step(model, data, 10)
    return data.sensordata.tolist()
"""


def python(*arguments):
    done = subprocess.run(
        [sys.executable, *arguments], capture_output=True, text=True, check=False, timeout=300
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_a_process_that_only_knows_mujoco_can_load_them(tmp_path):
    model = arm(spools=True)
    data = run(model, started(model, 6, 2.0), 20)
    file = tmp_path / "kept.pkl"
    file.write_bytes(pickle.dumps({"model": model, "data": data}))
    mujoco.mj_step(model, data)
    states = [float(word) for word in python("-c", LOAD, str(file)).split()]
    np.testing.assert_array_equal(states, data.plugin_state)


def test_spawned_workers_step_them(tmp_path):
    (tmp_path / "worker.py").write_text(WORKER)
    (tmp_path / "main.py").write_text(SPAWN)
    shown = python(str(tmp_path / "main.py"))
    model = arm()
    assert eval(shown) == run(model, started(model, 6, 2.0), 10).sensordata.tolist()


@pytest.mark.parametrize("protocol", range(2, pickle.HIGHEST_PROTOCOL + 1))
def test_a_pickle_repeats_the_simulation(protocol):
    model = arm()
    data = run(model, started(model, 6, 2.0), 5)
    again, data_again = pickle.loads(pickle.dumps((model, data), protocol))
    ends = [snapshot(m, run(m, d, 5)) for m, d in ((model, data), (again, data_again))]
    np.testing.assert_array_equal(*ends)


def test_other_models_pickle_as_ever():
    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    for stock in (model, mujoco.MjData(model)):
        assert b"tendon_mj" not in pickle.dumps(stock)
        assert type(pickle.loads(pickle.dumps(stock))) is type(stock)


def test_another_order_of_plugins_is_refused(monkeypatch):
    text = pickle.dumps(arm())
    monkeypatch.setattr(elsewhere, "plugin_at", lambda slot: "somebody.else")
    with refusing(RuntimeError, "tendon_mj.sheath in slot", "somebody.else"):
        pickle.loads(text)


ENGINES = {"mujoco.mjx": "MJX", "mujoco_warp": "MuJoCo Warp"}
ENGINE = "def put_model(m, device=None, **more):\n    return m.nq\n"


@pytest.fixture(params=ENGINES)
def engine(request, tmp_path, monkeypatch):
    """Name of an engine that can be imported, and is not."""
    folder = tmp_path.joinpath(*request.param.split("."))
    folder.mkdir(parents=True)
    (folder / "__init__.py").write_text(ENGINE)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(mujoco, "__path__", [str(tmp_path / "mujoco"), *mujoco.__path__])
    monkeypatch.delitem(sys.modules, request.param, raising=False)
    yield request.param
    sys.modules.pop(request.param, None)
    if hasattr(mujoco, "mjx"):
        del mujoco.mjx


def refuses(module, name):
    with refusing(NotImplementedError, "tendon_mj.sheath", name, "rollout"):
        module.put_model(arm())
    with refusing(NotImplementedError, name):
        module.put_model(m=arm(), device="cpu")
    assert module.put_model(mujoco.MjModel.from_xml_string("<mujoco/>"), device=None) == 0


def test_imported_after_us(engine):
    refuses(importlib.import_module(engine), ENGINES[engine])


def test_imported_before_us(engine, monkeypatch):
    monkeypatch.setattr(sys, "meta_path", [f for f in sys.meta_path if "tendon" not in repr(f)])
    module = importlib.import_module(engine)
    assert module.put_model(arm()) > 0
    guard_engines((NAME, SERVO))
    refuses(module, ENGINES[engine])


def test_one_that_is_not_installed_is_still_missing(monkeypatch):
    monkeypatch.setattr(mujoco, "__path__", [])
    monkeypatch.setattr(sys, "path", [])
    for name in ENGINES:
        monkeypatch.delitem(sys.modules, name, raising=False)
        with pytest.raises(ModuleNotFoundError, match=name):
            importlib.import_module(name)
