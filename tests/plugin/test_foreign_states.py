"""A state that is none of its model's is found out: no index of it is used, and it is laid anew.

``python -m tests.plugin.test_foreign_states`` steps models from 300 such states; a crash ends it.
"""

import os
import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest
from mujoco import rollout

from tendon_mj import add_friction
from tendon_mj.plugin import sheaths
from tendon_mj.plugin.sheath_plugin.state import view
from tests.rigs import MODELS, TOO_NEW, moved, simulated

WHOLE = mujoco.mjtState.mjSTATE_FULLPHYSICS
KINDS = list(MODELS)
ROOT = Path(__file__).parents[2]
CASES = 300


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path, monkeypatch):
    """MuJoCo writes its warnings to a file where it runs."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module", params=KINDS)
def model(request):
    return MODELS[request.param]()


def states(model, data):
    return [view(data.plugin_state, sheath.state).state for sheath in sheaths(model).values()]


@pytest.mark.parametrize("fill", [0.0, np.nan, np.inf, -1.0, 1e300, 7.0])
def test_a_state_of_no_model_acts_as_a_fresh_one(model, fill):
    fresh, data = mujoco.MjData(model), mujoco.MjData(model)
    fresh.qvel[:] = data.qvel[:] = 0.1
    fresh.ctrl[:] = data.ctrl[:] = 1e-3
    data.plugin_state[:] = fill
    for _ in range(3):
        mujoco.mj_step(model, fresh)
        mujoco.mj_step(model, data)
        np.testing.assert_array_equal(data.qfrc_passive, fresh.qfrc_passive)
        np.testing.assert_array_equal(data.qpos, fresh.qpos)
        np.testing.assert_array_equal(data.sensordata, fresh.sensordata)
    assert np.isfinite(data.qacc).all()
    assert [state.rebound for state in states(model, data)] == [1.0] * len(sheaths(model))
    assert [state.rebound for state in states(model, fresh)] == [0.0] * len(sheaths(model))
    own = simulated(model, 1, plugin_state=moved(model))
    assert not any(state.rebound for state in states(model, own))
    unsolved = [state.unsolved for state in states(model, data)]
    assert unsolved == [state.unsolved for state in states(model, fresh)]


def test_zeros_as_the_initial_state_of_a_rollout_are_a_fresh_sheath(model):
    data, starts = mujoco.MjData(model), np.empty((2, mujoco.mj_stateSize(model, WHOLE)))
    data.qvel[:] = 0.1
    mujoco.mj_getState(model, data, starts[0], WHOLE)
    data.plugin_state[:] = 0.0
    mujoco.mj_getState(model, data, starts[1], WHOLE)
    controls = np.full((2, 20, model.nu), 1e-3)
    states, shown = rollout.rollout(model, mujoco.MjData(model), starts, controls, nstep=20)
    np.testing.assert_array_equal(shown[0], shown[1])
    bodies = 1 + model.nq + model.nv
    np.testing.assert_array_equal(states[0, :, :bodies], states[1, :, :bodies])


def test_no_state_ends_the_process():
    command = [sys.executable, "-m", "tests.plugin.test_foreign_states"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stderr[-2000:]


def given():
    """Models of others, with friction on all their tendons that actuators pull."""
    for path in sorted(Path(os.environ.get("TENDON_MJ_MODELS", "/nowhere")).glob("*.xml")):
        if path.stem in TOO_NEW:
            continue
        yield add_friction(mujoco.MjSpec.from_file(str(path)), "*", friction=0.1).compile()


def anything(random, count, kept):
    """Numbers of all kinds, in part those of a true state."""
    kind = random.integers(7)
    if kind == 0:
        return random.integers(0, 2**63, count, dtype=np.uint64).view(np.float64)
    if kind == 1:
        return random.normal(size=count) * 10.0 ** random.integers(-3, 12)
    if kind == 2:
        return random.choice([np.nan, np.inf, -np.inf, 1e300, -1e300, 0.0, -1.0], count)
    if kind == 3:
        return random.integers(-3, 50, count).astype(float)
    numbers = kept.copy()
    if kind == 4:
        return np.roll(numbers, random.integers(count))
    where = random.random(count) < 10.0 ** -random.integers(1, 4)
    numbers[where] = random.choice([np.nan, np.inf, -1e300, 3.0, 1e6], where.sum())
    return numbers


def try_all(model, cases):
    random, kept = np.random.default_rng(1), moved(model)
    starts = (mujoco.mj_step, mujoco.mj_forward, mujoco.mj_sensorVel, mujoco.mj_fwdActuation)
    starts += (mujoco.mj_rnePostConstraint, mujoco.mj_sensorAcc)
    for case in range(cases):
        data = mujoco.MjData(model)
        data.plugin_state[:] = anything(random, kept.size, kept)
        if case % 7 == 6 and hasattr(mujoco, "mj_Euler"):
            mujoco.mj_Euler(model, data)  # advances what was not evaluated
        else:
            starts[case % 7 % 6](model, data)
        mujoco.mj_step(model, data, 2)


if __name__ == "__main__":
    for make in MODELS.values():
        try_all(make(), CASES // len(MODELS))
    for model in given():
        try_all(model, 20)
