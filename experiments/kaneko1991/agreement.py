"""Agreement of five routes: first motion, outer loop, minor loops and random histories."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from experiments.kaneko1991 import mujoco_routes, routes
from experiments.kaneko1991.loop import (
    LEG_TIME,
    TURNING_POINTS,
    displacement_history,
    random_turning_points,
)
from experiments.kaneko1991.paper_tendon import PaperTendon
from experiments.kaneko1991.routes import Trace
from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.typing import FloatArray

TENDON = PaperTendon(friction=0.15, output_stiffness=8e3)  # models/bench: 1/k_se = 1/10 + 1/40 m/MN
ELEMENTS = 64
SLOWNESS = 60.0  # of the elements, see `reference.quasi_static`
TIMESTEP = 1e-4  # of the plugin with a spring at the output [s]
BATCH = 10  # histories that two threads share at a time


@dataclass(frozen=True, eq=False)
class Agreement:
    """Largest difference of T_out and of T_in between any two routes, over its range.

    Args:
        routes: their names.
        difference: of T_out, a symmetric table for each kind of history. Each (routes, routes) [-].
        input_difference: of T_in, likewise.
        loops: traces of the minor loops by route, for the figure.
        tendon: of these histories.
        histories: number of random histories.
    """

    routes: tuple[str, ...]
    difference: dict[str, FloatArray]
    input_difference: dict[str, FloatArray]
    loops: dict[str, Trace]
    tendon: PaperTendon
    histories: int

    @property
    def largest(self) -> float:
        """Largest difference of T_out over all histories and pairs [-]."""
        return max(float(table.max()) for table in self.difference.values())

    @property
    def largest_input(self) -> float:
        """Largest difference of T_in over all histories and pairs [-]."""
        return max(float(table.max()) for table in self.input_difference.values())


def check_histories(histories: int) -> None:
    """Refuse a number of random histories that cannot be drawn.

    Raises:
        InvalidValueError: fewer than 0.
    """
    if histories < 0:
        raise InvalidValueError(f"histories = {histories} must be ≥ 0")


def compare_routes(
    histories: int = 100, tendon: PaperTendon = TENDON, progress: Progress = silent
) -> Agreement:
    """Compare the routes on the four kinds of history and on so many random ones.

    Raises:
        InvalidValueError: fewer than 0 histories.
    """
    check_histories(histories)
    difference: dict[str, FloatArray] = {}
    loops: dict[str, Trace] = {}
    for name, points in TURNING_POINTS.items():
        loops = _run_routes(tendon, [points])[0]
        difference[name] = _differences(loops)
    label = f"{histories} random histories"
    drawn = random_turning_points(histories)
    for done in range(0, histories, BATCH):
        batch = drawn[done : done + BATCH]
        tables = [_differences(traces) for traces in _run_routes(tendon, batch)]
        before = difference.get(label, np.zeros_like(tables[0]))
        difference[label] = np.maximum(before, np.max(tables, axis=0))
        progress(label, done + len(batch), histories)
    outputs = {name: tables[0] for name, tables in difference.items()}
    inputs = {name: tables[1] for name, tables in difference.items()}
    return Agreement(tuple(loops), outputs, inputs, loops, tendon, histories)


def _run_routes(
    tendon: PaperTendon, histories: Sequence[tuple[float, ...]]
) -> list[dict[str, Trace]]:
    """Traces of five routes on each history of ξ_in; all have equally many turning points."""
    time = displacement_history(histories[0])[0]
    travels = np.array([displacement_history(points)[1] for points in histories])
    rolled = mujoco_routes.plugin(
        tendon, time, travels, ELEMENTS, TIMESTEP, threads=min(2, len(histories))
    )
    return [
        {
            "closed form": routes.closed_form(tendon, travel, "displacement"),
            "continuum": routes.continuum(tendon, travel, "displacement"),
            "elements": routes.quasi_static_elements(
                tendon, time, travel, "displacement", ELEMENTS, 2.0 * LEG_TIME, SLOWNESS
            ),
            "sheath alone": routes.sheath_alone(tendon, travel, "displacement", ELEMENTS),
            "plugin in MuJoCo": Trace(rolled.input_tension[k], rolled.output_tension[k], travel),
        }
        for k, travel in enumerate(travels)
    ]


def _differences(traces: dict[str, Trace]) -> FloatArray:
    """Differences of T_out and of T_in between any two routes, (2, routes, routes) [-]."""
    outputs = np.array([trace.output_tension for trace in traces.values()])
    inputs = np.array([trace.input_tension for trace in traces.values()])
    table = np.zeros((2, len(outputs), len(outputs)))
    for end, tensions in enumerate((outputs, inputs)):
        span = np.ptp(tensions[0])
        for i, j in itertools.combinations(range(len(tensions)), 2):
            largest = np.abs(tensions[i] - tensions[j]).max() / span
            table[end, i, j] = table[end, j, i] = largest
    return table
