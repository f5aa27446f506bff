"""Fig. 5 of the paper: 0.4 Hz on a sprung output, with and without tension-independent friction.

The authors lay the departure of the experiment below ξ_in = 0.5 mm to friction that does not depend
on the tension. A friction F_c of the whole sheath, spread evenly over its bend, has a closed form:

    dT/dθ = −(μT + F_c/φ) sgn ξ̇,  so that  T + F_c/λ  obeys every equation that T obeys without F_c.

The slopes stay as they are, so each branch is moved by a number of newtons that is the same at
every displacement, and over T_in by another one (`Departure`). Only relative to the width of the
loop does it fade. Without F_c the lines of both directions meet where the tendon turns slack; with
it they meet at T = −F_c/λ.

Equations: docs/theory.md, section 3.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from experiments.kaneko1991 import mujoco_routes, routes
from experiments.kaneko1991.figure_4a import (
    ELEMENTS,
    MUJOCO_ELEMENTS,
    PERIODS,
    SAMPLES,
    SLOWNESS,
    quasi_static_mass,
)
from experiments.kaneko1991.loop import (
    LoopMeasures,
    largest_difference,
    measure_loop,
    predict_loop,
    tension_sine,
)
from experiments.kaneko1991.paper_tendon import PaperTendon
from experiments.kaneko1991.routes import Trace
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.typing import FloatArray

FREQUENCY = 0.4  # the paper's [Hz]
AMPLITUDE = 19.0  # nearly T_0, so that the loop comes near slack [N]
# Of the plugin: a light carriage, since T_out jumps in slope when the front arrives [kg], [s].
CARRIAGE, TIMESTEP = 0.02, 4e-5
# A longer and thinner rope than in Fig. 4, so that ξ_in runs through millimetres as in the paper,
# on a stiff load cell; μ as on models/bench.
TENDON = PaperTendon(friction=0.15, length=1.0, axial_stiffness=10e3, output_stiffness=100e3)
CONSTANT_FRICTION = 1.0  # chosen: the loop is then half as wide again at 0.5 mm from slack [N]
BOUND = 0.5e-3  # where the paper sees the departure end [m]


@dataclass(frozen=True)
class Departure:
    """Change of T_out that F_c makes on the branches, constant along each of them.

    Args:
        travel_pulling, travel_loosening: at the same ξ_in, (F_c/λ)(K_t/K_slack − 1) with
            1/K_slack = 1/K_w + 1/k_se [N].
        tension_pulling, tension_loosening: at the same T_in, (F_c/λ)(e^{∓λ} − 1) [N].
        lower_flat: interval of ξ_in from slack in which T_out stays at its least, without F_c [m].
        lower_flat_with: that interval with F_c [m].
    """

    travel_pulling: float
    travel_loosening: float
    tension_pulling: float
    tension_loosening: float
    lower_flat: tuple[float, float]
    lower_flat_with: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Figure5:
    """Loops without and with F_c; each pair is in this order.

    Args:
        tendons: without and with F_c.
        traces: by route.
        measured: slopes, ratios and backlash of the last full loop, by route.
        predicted: slopes, ratios and backlash by formula.
        largest: difference of T_out between routes over the range [-].
        travel: ξ_in from where the tendon without F_c turns slack [m]. Shape (k,).
        widening: growth of the loop's width by F_c, over its width without F_c [-]. Shape (k,).
        departure: change of T_out by F_c.
    """

    tendons: tuple[PaperTendon, PaperTendon]
    traces: tuple[dict[str, Trace], dict[str, Trace]]
    measured: tuple[dict[str, LoopMeasures], dict[str, LoopMeasures]]
    predicted: tuple[LoopMeasures, LoopMeasures]
    largest: tuple[float, float]
    travel: FloatArray
    widening: FloatArray
    departure: Departure

    def widening_at(self, travel: float) -> float:
        """Widening at a displacement from slack ``travel`` [m]."""
        return float(np.interp(travel, self.travel, self.widening))


def simulate_figure_5(progress: Progress = silent) -> Figure5:
    """Simulate Fig. 5 by every route, without and with F_c."""
    tendons = (TENDON, dataclasses.replace(TENDON, constant_friction=CONSTANT_FRICTION))
    skip = SAMPLES // 4
    traces, measured, predicted, largest = [], [], [], []
    for done, tendon in enumerate(tendons):
        result = _run_routes(tendon)
        exact = result["closed form"]
        traces.append(result)
        measured.append(
            {name: measure_loop(tendon, trace, exact, skip) for name, trace in result.items()}
        )
        predicted.append(predict_loop(tendon, float(exact.output_tension.max())))
        largest.append(largest_difference(result, skip))
        progress("Fig. 5", done + 1, len(tendons))
    travel = np.linspace(0.05e-3, 6e-3, 240)
    return Figure5(
        tendons,
        (traces[0], traces[1]),
        (measured[0], measured[1]),
        (predicted[0], predicted[1]),
        (largest[0], largest[1]),
        travel,
        _widening(tendons, travel),
        measure_departure(tendons, [result["closed form"] for result in traces]),
    )


def measure_departure(
    tendons: tuple[PaperTendon, PaperTendon], exact: Sequence[Trace]
) -> Departure:
    """Change of T_out by F_c, from the traces of the closed form without and with it."""
    rubbing = tendons[1]
    offset, lam = rubbing.tension_offset, rubbing.exponent
    slack = tendons[0].slack_displacement
    compliance = -slack / rubbing.pretension
    flats = []
    for trace in exact:
        travel, tension = (
            values[SAMPLES // 4 :] for values in (trace.input_displacement, trace.output_tension)
        )
        low = travel[tension <= tension.min() + 1e-9] - slack
        flats.append((float(low.min()), float(low.max())))
    return Departure(
        offset * (rubbing.transmission_stiffness(1.0) * compliance - 1.0),
        offset * (rubbing.transmission_stiffness(-1.0) * compliance - 1.0),
        float(offset * np.expm1(-lam)),
        float(offset * np.expm1(lam)),
        flats[0],
        flats[1],
    )


def _run_routes(tendon: PaperTendon) -> dict[str, Trace]:
    time, load = tension_sine(FREQUENCY, AMPLITUDE, tendon.pretension, PERIODS, SAMPLES)
    exact = routes.closed_form(tendon, load, "tension")
    mass, damping = quasi_static_mass(tendon, FREQUENCY)
    return {
        "closed form": exact,
        "continuum": routes.continuum(tendon, load, "tension"),
        "elements": routes.quasi_static_elements(
            tendon, time, load, "tension", ELEMENTS, 1.0 / FREQUENCY, SLOWNESS
        ),
        "sheath alone": routes.sheath_alone(tendon, load, "tension", ELEMENTS),
        "plugin in MuJoCo": mujoco_routes.plugin(
            tendon, time, exact.input_displacement, ELEMENTS, TIMESTEP, carriage=CARRIAGE
        ),
        "elements in MuJoCo": mujoco_routes.mujoco_elements(
            tendon, time, load, "tension", MUJOCO_ELEMENTS, mass, damping
        ),
    }


def _widening(tendons: tuple[PaperTendon, PaperTendon], travel: FloatArray) -> FloatArray:
    """Relative widening of the loop in T_out between its two lines at the same ξ_in [-]."""
    widths = []
    slack = tendons[0].slack_displacement
    for tendon in tendons:
        away = travel + slack - tendon.slack_displacement
        slopes = [tendon.transmission_stiffness(direction) for direction in (1.0, -1.0)]
        widths.append((slopes[1] - slopes[0]) * away)
    return np.asarray(widths[1] / widths[0] - 1.0)
