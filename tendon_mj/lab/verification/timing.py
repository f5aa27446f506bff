"""Times of tasks, taken in turns because a machine's speed drifts, and their spread."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tendon_mj.typing import FloatArray

_FINE = 1e-6  # resolution that a clock of processor time must have [s]


def processor_time() -> float:
    """Processor time of the calling thread [s], which other processes do not lengthen.

    Wall time where the system counts it only in ticks of its scheduler.
    """
    fine = time.get_clock_info("thread_time").resolution <= _FINE
    return time.thread_time() if fine else time.perf_counter()


@dataclass(frozen=True)
class Spread:
    """Median and quartiles of what several rounds gave.

    Attributes:
        median, low, high: the median, the lower and the upper quartile.
    """

    median: float
    low: float
    high: float

    @classmethod
    def of(cls, values: FloatArray) -> Spread:
        """Spread over the rounds, (rounds,)."""
        low, median, high = np.quantile(values, (0.25, 0.5, 0.75))
        return cls(float(median), float(low), float(high))

    def result(self) -> dict[str, object]:
        """Plain numbers for `result.json`."""
        return {"median": self.median, "quartiles": [self.low, self.high]}


def times_in_turns(
    tasks: Sequence[Callable[[], object]],
    rounds: int,
    clock: Callable[[], float] = time.perf_counter,
) -> FloatArray:
    """(rounds, tasks) times [s]; every round runs each task once, in order."""
    spent = np.empty((rounds, len(tasks)))
    for times in spent:
        for k, task in enumerate(tasks):
            before = clock()
            task()
            times[k] = clock() - before
    return spent
