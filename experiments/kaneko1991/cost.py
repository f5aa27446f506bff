"""Cost of a simulated second by each route, with T_in and T_out within 1 % of their range."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from experiments.kaneko1991 import routes
from experiments.kaneko1991.agreement import TENDON
from experiments.kaneko1991.discretisations import SAMPLE_TIME, Discretisation, discretisations
from experiments.kaneko1991.loop import TURNING_POINTS, displacement_history
from tendon_mj.errors import TendonError
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.typing import FloatArray

TARGET = 0.01  # of the range, for either tension
REPEATS = 3


@dataclass(frozen=True)
class Cost:
    """Cost of a route with its first discretisation that reaches ``TARGET``.

    Args:
        route: its name.
        seconds: of wall time per simulated second, the best of some repeats [-].
        step: time step [s].
        elements: n, guides, elements or grid intervals; 0 for the closed form.
        error: largest of T_in or T_out over its range [-].
        inertia: the parts with mass in this run.
    """

    route: str
    seconds: float
    step: float
    elements: int
    error: float
    inertia: str


def measure_costs(progress: Progress = silent) -> tuple[Cost, ...]:
    """Time every route on an outer loop, in this one process, one thread.

    Raises:
        TendonError: a route does not reach ``TARGET`` with any of its discretisations.
    """
    coarse, loop = displacement_history(TURNING_POINTS["outer loop"])
    time = np.arange(round(coarse[-1] / SAMPLE_TIME) + 1) * SAMPLE_TIME
    travel = np.interp(time, coarse, loop)
    exact = routes.closed_form(TENDON, travel, "displacement")
    tensions = (exact.input_tension, exact.output_tension)
    by_route = discretisations(time, travel)
    results = []
    for name, choices in by_route.items():
        results.append(_first_within_target(name, choices, tensions, float(time[-1])))
        progress("wall time by route", len(results), len(by_route))
    return tuple(results)


def _first_within_target(
    route: str,
    choices: Iterator[Discretisation],
    exact: tuple[FloatArray, FloatArray],
    duration: float,
) -> Cost:
    for step, elements, inertia, run in choices:
        try:
            pairs = zip(run(), exact, strict=True)
            error = max(float(np.abs(ours - true).max() / np.ptp(true)) for ours, true in pairs)
        except TendonError:  # unstable: this step is too long for MuJoCo
            continue
        if error <= TARGET:
            times = []
            for _ in range(REPEATS):
                start = perf_counter()
                run()
                times.append(perf_counter() - start)
            return Cost(route, min(times) / duration, step, elements, error, inertia)
    raise TendonError(
        f"no discretisation of the route {route!r} is within {TARGET:.0%} of the closed form"
    )
