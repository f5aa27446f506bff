"""Models and data that are pickled for a process which has not imported the package."""

import pickle
import subprocess
import sys

import mujoco
import numpy as np
import pytest

from tendon_mj.plugin import elsewhere
from tests.plugin.rigs import arm, refused, run, snapshot, started

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
    from tests.plugin.rigs import arm, started
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
    with refused("tendon_mj.sheath in slot", "somebody.else", by=RuntimeError):
        pickle.loads(text)
