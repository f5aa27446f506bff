"""What a step costs, over one of the same model without a sheath, and what a second core saves."""

from __future__ import annotations

import dataclasses
import time

import mujoco
import numpy as np

from tendon_mj.builders.bench import Bench, build_bench
from tendon_mj.errors import EngineError
from tendon_mj.replay.rollout import full_state, rollout_sensors


def reference_spec(bench: Bench) -> mujoco.MjSpec:
    """The bench without the plugin: MuJoCo's own tendon, of stiffness EA/S and spring length S."""
    spec = build_bench(dataclasses.replace(bench, friction=0.0))
    unstretched = bench.length / (1.0 + bench.pretension / bench.axial_stiffness)
    tendon = spec.tendon("tendon")
    tendon.stiffness[0] = bench.axial_stiffness / unstretched
    tendon.springlength = [0.0, unstretched]
    plugin_made = mujoco.mjtSensor.mjSENS_PLUGIN
    for element in [*spec.actuators, *(s for s in spec.sensors if s.type == plugin_made)]:
        spec.delete(element)
    for plugin in list(spec.plugins):
        spec.delete(plugin)
    return spec


def step_cost_ratio(bench: Bench, *, rounds: int = 7, steps: int = 8000) -> float:
    """Time of a step with the sheath over that of the same model without, taken in turns.

    The reel moves all the time, so that the tendon slides and turns back. The ratio is that of the
    medians over the rounds.
    """
    spec = build_bench(bench)
    for sensor in [s for s in spec.sensors if s.type == mujoco.mjtSensor.mjSENS_PLUGIN]:
        spec.delete(sensor)
    for view in [p for p in spec.plugins if "sensor" in p.config]:
        spec.delete(view)
    models = [spec.compile(), reference_spec(bench).compile()]
    phase = np.linspace(0.0, 4.0 * np.pi, steps)
    spent: list[list[float]] = [[], []]
    for _ in range(rounds):
        for k, model in enumerate(models):
            data = mujoco.MjData(model)
            start = full_state(model, data)[None]
            control = np.broadcast_to(1e-3 * np.sin(phase)[:, None], (steps, model.nu))[None]
            before = time.perf_counter()
            rollout_sensors(model, [data], start, control)
            spent[k].append(time.perf_counter() - before)
    return float(np.median(spent[0]) / np.median(spent[1]))


def rollout_speedup(bench: Bench, *, rounds: int = 5, runs: int = 8, steps: int = 6000) -> float:
    """Time of the same rollouts on one thread over that on two, taken in turns.

    Raises:
        EngineError: the two do not agree bit by bit.
    """
    model = build_bench(bench).compile()
    pool = [mujoco.MjData(model) for _ in range(2)]
    start = np.tile(full_state(model, pool[0]), (runs, 1))
    wave = 1e-3 * np.sin(np.linspace(0.0, 4.0 * np.pi, steps))
    control = np.broadcast_to(wave[None, :, None], (runs, steps, 1))
    spent: list[list[float]] = [[], []]
    for _ in range(rounds):
        seen = []
        for threads in (1, 2):
            before = time.perf_counter()
            shown = rollout_sensors(model, pool[:threads], start, control)
            spent[threads - 1].append(time.perf_counter() - before)
            seen.append(shown)
        if not np.array_equal(seen[0], seen[1]):
            raise EngineError("rollouts differ between one and two threads")
    return float(np.median(spent[0]) / np.median(spent[1]))
