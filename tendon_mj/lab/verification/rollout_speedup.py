"""Speedup of rollouts by more threads, on the bench."""

from __future__ import annotations

import functools
from collections.abc import Sequence

import mujoco
import numpy as np

from tendon_mj.errors import EngineError
from tendon_mj.lab.replay import full_state, rollout_sensors
from tendon_mj.lab.verification.timing import Spread, times_in_turns
from tendon_mj.models import Bench, build_bench
from tendon_mj.typing import FloatArray


def thread_speedups(
    bench: Bench,
    threads: Sequence[int] = (2,),
    *,
    rounds: int = 5,
    runs: int = 8,
    steps: int = 6000,
) -> dict[int, Spread]:
    """Threads → wall time of the same rollouts on one over that on so many, in turns [-].

    Args:
        bench: its parameters.
        threads: numbers of threads to compare with one.
        rounds: in each of which every number of threads does all rollouts.
        runs: rollouts.
        steps: of a rollout.

    Raises:
        EngineError: two numbers of threads do not agree bit by bit.
    """
    model = build_bench(bench).compile()
    pool = [mujoco.MjData(model) for _ in range(max(threads))]
    start = np.tile(full_state(model, pool[0]), (runs, 1))
    wave = 1e-3 * np.sin(np.linspace(0.0, 4.0 * np.pi, steps))
    # each run another amplitude, so that an exchange of two would show
    control = np.linspace(1.0, 0.5, runs)[:, None, None] * wave[None, :, None]
    readings: dict[int, FloatArray] = {}

    def roll(count: int) -> None:
        readings[count] = rollout_sensors(model, pool[:count], start, control)

    counts = (1, *threads)
    spent = times_in_turns([functools.partial(roll, count) for count in counts], rounds)
    for count in threads:
        if not np.array_equal(readings[1], readings[count]):
            raise EngineError(f"rollouts differ between one thread and {count}")
    return {n: Spread.of(spent[:, 0] / spent[:, k + 1]) for k, n in enumerate(threads)}


def rollout_speedup(bench: Bench, *, rounds: int = 5, runs: int = 8, steps: int = 6000) -> float:
    """Time of the same rollouts on one thread over that on two, taken in turns [-].

    Raises:
        EngineError: the two do not agree bit by bit.
    """
    return thread_speedups(bench, rounds=rounds, runs=runs, steps=steps)[2].median
