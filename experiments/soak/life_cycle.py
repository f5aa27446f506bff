"""Lives of models: made, copied, pickled, recompiled, reloaded, refused and deleted, in any order.

In this process, in three threads at once, and in processes that were forked or spawned.
"""

from __future__ import annotations

import copy
import gc
import multiprocessing
import pickle
import random
import warnings
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import mujoco
import numpy as np

import tendon_mj
from experiments.soak.batches import report_batch
from tendon_mj.models import load_spec
from tendon_mj.typing import FloatArray

_MODELS = ("bench", "joint", "finger")
_PROCESSES = 4  # lives in processes of their own, half of them forked
_EVENTS = ("copy", "pickle", "recompile", "reload", "reset", "state", "friction", "refusal")
_FULL = mujoco.mjtState.mjSTATE_INTEGRATION


def trials(seed: int, count: int) -> Iterator[tuple[str, str]]:
    """Lead lives: some in processes of their own first, then each in this thread or in three."""
    warnings.simplefilter("ignore")
    draw = random.Random(seed)
    if count >= 2 * _PROCESSES:
        count -= _PROCESSES
        for start in ("fork", "spawn"):  # before there are threads, which a fork would lose
            yield from ((f"{start}ed", said) for said in _in_processes(start, draw))
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


def _in_processes(start: str, draw: random.Random) -> Iterator[str]:
    """Send a model and its data to processes, which must go on as this one does, and live there."""
    spec = load_spec(draw.choice(_MODELS))
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 10)
    seeds = [draw.randrange(2**32) for _ in range(_PROCESSES // 2)]
    with multiprocessing.get_context(start).Pool(2) as pool:
        there = pool.starmap(_continued, [(model, data, seed) for seed in seeds])
    mujoco.mj_step(model, data)
    for state, said in there:
        same = np.array_equal(state, data.plugin_state)
        yield said if same else f"{start}: a process went another way"


def _continued(model: mujoco.MjModel, data: mujoco.MjData, seed: int) -> tuple[FloatArray, str]:
    """State after a step in this process, and the faults of a life here."""
    mujoco.mj_step(model, data)
    return data.plugin_state.copy(), _life(seed)


def _life(seed: int) -> str:
    """One model's life; returns its faults."""
    draw = random.Random(seed)
    spec = load_spec(draw.choice(_MODELS))
    model = spec.compile()
    data = mujoco.MjData(model)
    for _ in range(draw.randint(1, 6)):
        data.ctrl[:] = 1e-4 * draw.random()
        mujoco.mj_step(model, data, draw.randint(1, 20))
        event = draw.choice(_EVENTS)
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
        elif event == "refusal":
            _refuse(spec, draw)
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


def _refuse(spec: mujoco.MjSpec, draw: random.Random) -> None:
    """Have the plugin refuse a model: for its configuration, or for what that is on."""
    broken = spec.copy()
    if draw.random() < 0.5:
        sheath = next(p for p in broken.plugins if "friction" in p.config)
        sheath.config = {**sheath.config, "friction": "-1"}
    else:
        broken.tendons[0].stiffness = [5.0, 0.0, 0.0]
    try:
        broken.compile()
    except ValueError:
        return
    raise AssertionError("a broken model was not refused")


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
