"""Speedup of rollouts by a second thread, on the bench."""

from __future__ import annotations

import mujoco
import numpy as np

from tendon_mj.builders.bench import Bench, build_bench
from tendon_mj.errors import EngineError
from tendon_mj.replay.rollout import Array, full_state, rollout_sensors
from tendon_mj.verification.timing import time_in_turns


def rollout_speedup(bench: Bench, *, rounds: int = 5, runs: int = 8, steps: int = 6000) -> float:
    """Time of the same rollouts on one thread over that on two, taken in turns [-].

    Raises:
        EngineError: the two do not agree bit by bit.
    """
    model = build_bench(bench).compile()
    pool = [mujoco.MjData(model) for _ in range(2)]
    start = np.tile(full_state(model, pool[0]), (runs, 1))
    wave = 1e-3 * np.sin(np.linspace(0.0, 4.0 * np.pi, steps))
    control = np.broadcast_to(wave[None, :, None], (runs, steps, 1))
    readings: dict[int, Array] = {}

    def roll(threads: int) -> None:
        readings[threads] = rollout_sensors(model, pool[:threads], start, control)

    one, two = time_in_turns([lambda: roll(1), lambda: roll(2)], rounds)
    if not np.array_equal(readings[1], readings[2]):
        raise EngineError("rollouts differ between one and two threads")
    return one / two
