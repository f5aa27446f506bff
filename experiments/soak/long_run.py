"""A simulation of very many steps: conservation, memory, and resumption."""

from __future__ import annotations

import time
from dataclasses import dataclass

import mujoco
import numpy as np

from experiments.soak.own_memory import own_memory
from tendon_mj import add_servo
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.models import load_spec
from tendon_mj.plugin import sheath_arrays, sheaths, unsolved_evaluations

_FULL = mujoco.mjtState.mjSTATE_INTEGRATION
_BURST = 100  # steps with one control
_PARTS = 20  # of a run; at the start of each it is resumed from a checkpoint
_COMPARED = 20  # bursts for which what was resumed goes on beside the run


@dataclass
class LongRun:
    """Result of a long simulation.

    Attributes:
        model: its name.
        steps: number of steps.
        seconds: wall time.
        drift: largest relative change of a tendon's unstretched length, stored and wound.
        memory_growth: own memory at the end less that after the first part [MiB].
        resumed: whether fresh data, resumed from checkpoints, went on as the run, to the bit.
        unsolved: evaluations whose flow was not solved.
        finite: whether every position was.
    """

    model: str
    steps: int
    seconds: float
    drift: float
    memory_growth: float
    resumed: bool
    unsolved: float
    finite: bool


def long_run(name: str, steps: int, progress: Progress = silent) -> LongRun:
    """Simulate a model of the package for so many steps.

    The bench under a reel that goes back and forth at many rates; the finger under a force servo on
    each tendon.
    """
    model, controls = _prepared(name)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    start = _lengths(model, data)
    began, memory, drift, resumed, finite = time.perf_counter(), 0.0, 0.0, True, True
    bursts = max(2, steps // (_BURST * _PARTS))
    compared = min(_COMPARED, bursts)
    for part in range(_PARTS):
        again, first = mujoco.MjData(model), part * bursts
        mujoco.mj_setState(model, again, _state(model, data), _FULL)
        for one in (data, again):
            _simulate(model, one, controls, first, compared)
        resumed = resumed and np.array_equal(_state(model, again), _state(model, data))
        _simulate(model, data, controls, first + compared, bursts - compared)
        drift = max(drift, float(np.max(np.abs(_lengths(model, data) / start - 1.0))))
        finite = finite and bool(np.isfinite(data.qpos).all())
        memory = memory or own_memory()
        progress(name, part + 1, _PARTS)
    return LongRun(
        name,
        bursts * _BURST * _PARTS,
        time.perf_counter() - began,
        drift,
        (own_memory() - memory) / 2**20,
        resumed,
        float(sum(unsolved_evaluations(model, data).values())),
        finite,
    )


def _prepared(name: str) -> tuple[mujoco.MjModel, np.ndarray]:
    """A model, and controls that repeat, (rows, nu)."""
    spec, low, high = load_spec(name), -1e-3, 1e-3  # of a reel [m]
    if name == "finger":
        low, high = 2.0, 25.0  # of a servo [N]
        for motor in list(spec.actuators):
            spec.delete(motor)
        for tendon in ("flexor", "extensor"):
            add_servo(spec, tendon, tension_gain=7.0, velocity_gain=2.0, name=f"{tendon}_servo")
    model = spec.compile()
    rng = np.random.default_rng(0)
    rates, phases = rng.uniform(0.01, 1.0, (2, model.nu, 5))
    waves = np.sin(np.arange(10_000)[:, None, None] * rates + 6.28 * phases).mean(-1)
    return model, 0.5 * (low + high) + 0.5 * (high - low) * waves


def _simulate(
    model: mujoco.MjModel, data: mujoco.MjData, controls: np.ndarray, first: int, bursts: int
) -> None:
    for k in range(first, first + bursts):
        data.ctrl[:] = controls[k % len(controls)]
        mujoco.mj_step(model, data, _BURST)


def _state(model: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    state = np.empty(mujoco.mj_stateSize(model, _FULL))
    mujoco.mj_getState(model, data, state, _FULL)
    return state


def _lengths(model: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    """Unstretched length of every tendon, stored along it and wound [m]."""
    results = []
    for name, sheath in sheaths(model).items():
        scalars, segments, *_ = sheath_arrays(model, data.plugin_state, name, sheath.state)
        wound = float(scalars["wound_in"].item()) + float(scalars["wound_out"].item())
        results.append(float(segments["stored"].sum()) + wound)
    return np.array(results)
