"""Rollouts on several threads."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import mujoco
import numpy as np

from tendon_mj.errors import EngineError
from tendon_mj.lab.replay import full_state, rollout_sensors
from tendon_mj.lab.step_cost import Quartiles, times_in_turns
from tendon_mj.models import Bench, build_bench
from tendon_mj.typing import FloatArray

TRAVEL = 1e-3  # of the bench's reel [m]


def thread_speedups(
    bench: Bench,
    threads: Sequence[int],
    *,
    rounds: int = 5,
    runs: int = 8,
    steps: int = 6000,
) -> dict[int, Quartiles]:
    """Speedup of the same rollouts by so many threads over one, in turns [-]."""
    model = build_bench(bench).compile()
    pool = [mujoco.MjData(model) for _ in range(max(threads))]
    start = np.tile(full_state(model, pool[0]), (runs, 1))
    wave = TRAVEL * np.sin(np.linspace(0.0, 4.0 * np.pi, steps))
    # each run another amplitude, so that an exchange of two would show
    control = np.linspace(1.0, 0.5, runs)[:, None, None] * wave[None, :, None]
    readings: dict[int, FloatArray] = {}

    def roll(count: int) -> None:
        readings[count] = rollout_sensors(model, pool[:count], start, control)

    spent = times_in_turns([partial(roll, count) for count in (1, *threads)], rounds)
    for count in threads:
        if not np.array_equal(readings[1], readings[count]):
            raise EngineError(f"rollouts differ between one thread and {count}")
    return {n: Quartiles.of(spent[:, 0] / spent[:, k + 1]) for k, n in enumerate(threads)}
