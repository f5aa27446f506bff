"""Refinement of each route towards the closed form: error over the number of elements."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from experiments.kaneko1991 import mujoco_routes, routes
from experiments.kaneko1991.loop import LEG_TIME, TURNING_POINTS, displacement_history
from experiments.kaneko1991.paper_tendon import PaperTendon
from experiments.kaneko1991.routes import Trace
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.typing import FloatArray

TENDON = PaperTendon(friction=1.0 / np.pi)  # λ = 1, output fixed: only the tendon to refine
TRAVEL = 0.3  # share of the outer loop, which reaches about the same tensions without a spring
ELEMENTS = (4, 8, 16, 32, 64)
SLOWNESS = 600.0
STIFFENING = 100.0  # of EA, to take the finite strain away
_LEAST_FALL = 3.0  # of the error from one n to the next, while the error still converges


@dataclass(frozen=True, eq=False)
class Refinement:
    """RMS error of T_out against the closed form over its range, by the number of elements.

    Args:
        elements: n. Shape (k,).
        error: by route [-]. Each (k,).
        order: −slope of log(error) over log(n), of the routes that converge over three points [-].
        tendon: of the history, an outer loop.
    """

    elements: FloatArray
    error: dict[str, FloatArray]
    order: dict[str, float]
    tendon: PaperTendon


def refine(tendon: PaperTendon = TENDON, progress: Progress = silent) -> Refinement:
    """Run an outer loop with ever more elements, guides or grid intervals."""
    time, travel = displacement_history(TURNING_POINTS["outer loop"])
    travel = TRAVEL * travel
    exact = routes.closed_form(tendon, travel, "displacement").output_tension
    stiff, stiff_travel = tendon.stiffened(STIFFENING), travel / STIFFENING
    runs: dict[str, Callable[[int], Trace]] = {
        "continuum": lambda n: routes.continuum(tendon, travel, "displacement", n),
        "elements": lambda n: routes.quasi_static_elements(
            tendon, time, travel, "displacement", n, 2.0 * LEG_TIME, SLOWNESS
        ),
        "sheath alone": lambda n: routes.sheath_alone(tendon, travel, "displacement", n),
        "plugin in MuJoCo": lambda n: mujoco_routes.plugin(tendon, time, travel, n),
        "sheath alone, EA × 100": lambda n: routes.sheath_alone(
            stiff, stiff_travel, "displacement", n
        ),
        "plugin in MuJoCo, EA × 100": lambda n: mujoco_routes.plugin(stiff, time, stiff_travel, n),
    }
    error: dict[str, FloatArray] = {}
    for done, (name, run) in enumerate(runs.items()):
        gaps = [run(n).output_tension - exact for n in ELEMENTS]
        error[name] = np.array([np.sqrt(np.mean(gap**2)) for gap in gaps]) / np.ptp(exact)
        progress("refinement", done + 1, len(runs))
    counts = np.array(ELEMENTS, float)
    orders = {name: _order(counts, values) for name, values in error.items()}
    return Refinement(counts, error, {k: v for k, v in orders.items() if v is not None}, tendon)


def _order(counts: FloatArray, error: FloatArray) -> float | None:
    """Order of convergence over at least three points, as long as the error falls enough."""
    falling = np.append(error[1:] < error[:-1] / _LEAST_FALL, False)
    points = int(np.argmin(falling)) + 1
    if points < 3:
        return None
    line = np.polyfit(np.log(counts[:points]), np.log(error[:points]), 1)
    return float(-line[0])
