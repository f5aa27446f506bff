"""Wall times of tasks, taken in turns because a machine's speed drifts."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np


def time_in_turns(tasks: Sequence[Callable[[], object]], rounds: int) -> list[float]:
    """Median wall time of each task [s]; every round runs each of them once, in order."""
    spent = np.empty((rounds, len(tasks)))
    for times in spent:
        for k, task in enumerate(tasks):
            before = time.perf_counter()
            task()
            times[k] = time.perf_counter() - before
    return [float(median) for median in np.median(spent, axis=0)]
