"""The same to the bit: in any number of threads, in other processes, resumed, and run again."""

import hashlib
import json
import multiprocessing
from functools import partial

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some
from mujoco import rollout

from tendon_mj import CATALOGUE, Simulator, diagnose, load_model, read_recording
from tendon_mj.models import example_rig
from tests.guarantees.random_tendon import cases, control_range, thorough

STEPS, WORLDS = 40, 6
STATE = mujoco.mjtState.mjSTATE_INTEGRATION
pytestmark = pytest.mark.filterwarnings("ignore::tendon_mj.TendonWarning")


def state_of(model, data, kind=STATE):
    state = np.empty(mujoco.mj_stateSize(model, kind))
    mujoco.mj_getState(model, data, state, kind)
    return state


def random_controls(model, seed, shape):
    low, high = control_range(model)
    return low + (high - low) * np.random.default_rng(seed).random((*shape, model.nu))


def step(model, data, controls):
    for control in controls:
        data.ctrl[:] = control
        mujoco.mj_step(model, data)


@thorough
@given(cases())
def test_in_one_two_and_four_threads(case):
    model = case.model()
    start = state_of(model, mujoco.MjData(model), mujoco.mjtState.mjSTATE_FULLPHYSICS)
    controls = random_controls(model, case.seed, (WORLDS, STEPS))
    one, *others = [
        rollout.rollout(
            model,
            [mujoco.MjData(model) for _ in range(threads)],
            np.tile(start, (WORLDS, 1)),
            controls,
        )
        for threads in (1, 2, 4)
    ]
    for other in others:
        np.testing.assert_array_equal(other[0], one[0])
        np.testing.assert_array_equal(other[1], one[1])


@thorough
@given(cases(), some.integers(0, STEPS - 1))
def test_resumed_anywhere_in_data_that_did_something_else(case, when):
    model = case.model()
    controls = random_controls(model, case.seed, (STEPS,))
    data, other = mujoco.MjData(model), mujoco.MjData(model)
    step(model, data, controls[:when])
    step(model, other, controls[::-1])
    mujoco.mj_setState(model, other, state_of(model, data), STATE)
    for simulation in (data, other):
        step(model, simulation, controls[when:])
    np.testing.assert_array_equal(state_of(model, other), state_of(model, data))
    np.testing.assert_array_equal(other.sensordata, data.sensordata)


def digest(name):
    """What 300 steps of a model leave behind."""
    model = load_model(name)
    data = mujoco.MjData(model)
    step(model, data, 0.01 * random_controls(model, 4, (300,)))
    return hashlib.sha256(state_of(model, data).tobytes() + data.sensordata.tobytes()).hexdigest()


def test_in_other_processes():
    models = ("bench", "joint", "finger")
    here = [digest(name) for name in models]
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        assert pool.map(digest, models, chunksize=1) == here


def test_a_diagnosis_run_again_in_two_threads():
    paths = [example_rig() / f"{name}.csv" for name in ("triangles", "sines")]
    train, held_out = ([read_recording(path, example_rig() / "rig.toml")] for path in paths)
    considered = {"joint_friction", "sensor_lag"}

    def said(threads):
        simulator = partial(Simulator, threads=threads)
        found = diagnose(train, held_out, simulator, exclude=set(CATALOGUE) - considered)
        return json.dumps({k: v for k, v in found.result().items() if k != "seconds"})

    assert said(1) == said(2)
