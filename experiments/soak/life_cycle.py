"""Lives of models: made, copied, pickled, recompiled, reloaded and deleted, in any order."""

from __future__ import annotations

import copy
import gc
import pickle
import random
import warnings
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import mujoco
import numpy as np

import tendon_mj
from experiments.soak.batches import report_batch
from tendon_mj.builders import load_spec

_MODELS = ("bench", "joint", "finger")
_FULL = mujoco.mjtState.mjSTATE_INTEGRATION


def trials(seed: int, count: int) -> Iterator[tuple[str, str]]:
    """Lead a life in this thread, and two more at the same time every fourth trial."""
    warnings.simplefilter("ignore")
    draw = random.Random(seed)
    with ThreadPoolExecutor(2) as pool:
        for k in range(count):
            seeds = [draw.randrange(2**32) for _ in range(3)]
            if k % 4 == 0:
                others = [pool.submit(_life, s) for s in seeds[1:]]
                said = [_life(seeds[0]), *(other.result() for other in others)]
                yield "three threads", "; ".join(filter(None, said))
            else:
                yield "one thread", _life(seeds[0])
            if k % 50 == 0:
                gc.collect()


def _life(seed: int) -> str:
    """One model's life; what was not as it should be."""
    draw = random.Random(seed)
    spec = load_spec(draw.choice(_MODELS))
    model = spec.compile()
    data = mujoco.MjData(model)
    for _ in range(draw.randint(1, 6)):
        data.ctrl[:] = 1e-4 * draw.random()
        mujoco.mj_step(model, data, draw.randint(1, 20))
        event = draw.choice(("copy", "pickle", "recompile", "reload", "reset", "state", "friction"))
        if event == "copy":
            model, data = _same(model, data, copy.copy(model), copy.copy(data))
        elif event == "pickle":
            model, data = _same(model, data, *pickle.loads(pickle.dumps((model, data))))
        elif event == "recompile":
            model, data = spec.recompile(model, data)
        elif event == "reload":
            spec = mujoco.MjSpec.from_string(spec.to_xml())
            model = spec.compile()
            data = mujoco.MjData(model)
        elif event == "reset":
            mujoco.mj_resetData(model, data)
        elif event == "state":
            state = np.empty(mujoco.mj_stateSize(model, _FULL))
            mujoco.mj_getState(model, data, state, _FULL)
            data = mujoco.MjData(model)
            mujoco.mj_setState(model, data, state, _FULL)
        else:
            tendon = spec.tendons[0].name
            tendon_mj.remove_friction(spec, tendon)
            tendon_mj.add_friction(
                spec, tendon, friction=draw.random(), axial_stiffness=2e3, pretension=2.0
            )
            model = spec.compile()
            data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 5)
    return "" if np.isfinite(data.qpos).all() else f"life {seed}: a position is not finite"


def _same(
    model: mujoco.MjModel, data: mujoco.MjData, other: mujoco.MjModel, twin: mujoco.MjData
) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """The copies, after a step beside the originals, which they must equal."""
    mujoco.mj_step(model, data)
    mujoco.mj_step(other, twin)
    if not np.array_equal(data.plugin_state, twin.plugin_state):
        raise AssertionError("a copy went another way than what it was copied from")
    return other, twin


if __name__ == "__main__":
    report_batch(trials)
