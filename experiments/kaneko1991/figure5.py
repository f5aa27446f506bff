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

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from experiments.kaneko1991 import mujoco_route as in_mujoco
from experiments.kaneko1991 import routes
from experiments.kaneko1991.figure4 import (
    ELEMENTS,
    MUJOCO_ELEMENTS,
    SAMPLES,
    sine,
    slow_mass,
)
from experiments.kaneko1991.loop import (
    LoopNumbers,
    largest_difference,
    loop_numbers,
    theory_numbers,
)
from experiments.kaneko1991.rig import Rig
from experiments.kaneko1991.routes import Array, Trace
from tendon_mj.progress import Progress, silent

FREQUENCY = 0.4  # the paper's [Hz]
PERIODS = 2.25
AMPLITUDE = 19.0  # nearly T_0, so that the loop comes near slack [N]
CARRIAGE, TIMESTEP = (
    0.02,
    4e-5,
)  # of the plugin: light, since the front arrives with a jolt [kg], [s]
SLOWNESS = 1000.0
# A longer and thinner rope than in Fig. 4, so that ξ_in runs through millimetres as in the paper,
# on a stiff load cell; μ as on models/bench.
RIG = Rig(friction=0.15, length=1.0, axial_stiffness=10e3, output_stiffness=100e3)
CONSTANT_FRICTION = 1.0  # chosen: the loop is then half as wide again at 0.5 mm from slack [N]
BOUND = 0.5e-3  # where the paper sees the departure end [m]


@dataclass(frozen=True)
class Departure:
    """By what F_c moves the branches in T_out, the same everywhere on them.

    Args:
        travel_pulling, travel_loosening: of T_out over ξ_in, (F_c/λ)(K_t/K_slack − 1) with
            1/K_slack = 1/K_w + 1/k_se [N].
        tension_pulling, tension_loosening: of T_out over T_in, (F_c/λ)(e^{∓λ} − 1) [N].
        lower_flat: ξ_in from slack between which T_out stays at its least, without F_c [m].
        lower_flat_with: the same with F_c.
    """

    travel_pulling: float
    travel_loosening: float
    tension_pulling: float
    tension_loosening: float
    lower_flat: tuple[float, float]
    lower_flat_with: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Figure5:
    """The loops with and without F_c.

    Args:
        rigs: without and with F_c.
        traces: by route, for each rig.
        numbers: read off the last full loop by route, for each rig.
        theory: by formula, for each rig.
        largest: difference of T_out between routes over the range, for each rig [-].
        travel: ξ_in from where the frictionless tendon turns slack [m]. Shape (k,).
        widening: how much F_c widens the loop there, over its width without [-]. Shape (k,).
        departure: in newtons.
    """

    rigs: tuple[Rig, Rig]
    traces: tuple[dict[str, Trace], dict[str, Trace]]
    numbers: tuple[dict[str, LoopNumbers], dict[str, LoopNumbers]]
    theory: tuple[LoopNumbers, LoopNumbers]
    largest: tuple[float, float]
    travel: Array
    widening: Array
    departure: Departure

    def widening_at(self, travel: float) -> float:
        """The widening at a displacement from slack [m]."""
        return float(np.interp(travel, self.travel, self.widening))


def _traces(rig: Rig) -> dict[str, Trace]:
    time, load = sine(FREQUENCY, AMPLITUDE, rig.pretension, PERIODS, SAMPLES)
    exact = routes.closed_form(rig, load, "tension")
    mass, damping = slow_mass(rig, FREQUENCY)
    runs: dict[str, Callable[[], Trace]] = {
        "closed form": lambda: exact,
        "continuum": lambda: routes.continuum(rig, load, "tension"),
        "elements": lambda: routes.slow_elements(
            rig, time, load, "tension", ELEMENTS, 1.0 / FREQUENCY, SLOWNESS
        ),
        "sheath alone": lambda: routes.sheath_alone(rig, load, "tension", ELEMENTS),
        "plugin in MuJoCo": lambda: in_mujoco.plugin(
            rig, time, exact.input_displacement, ELEMENTS, TIMESTEP, carriage=CARRIAGE
        ),
        "elements in MuJoCo": lambda: in_mujoco.mujoco_elements(
            rig, time, load, "tension", MUJOCO_ELEMENTS, mass, damping
        ),
    }
    return {name: run() for name, run in runs.items()}


def figure_5(progress: Progress = silent) -> Figure5:
    """Simulate Fig. 5 by every route, with and without F_c."""
    rigs = (RIG, RIG.but(constant_friction=CONSTANT_FRICTION))
    skip = SAMPLES // 4
    traces, numbers, theory, largest = [], [], [], []
    for done, rig in enumerate(rigs):
        found = _traces(rig)
        exact = found["closed form"]
        traces.append(found)
        numbers.append(
            {name: loop_numbers(rig, trace, exact, skip) for name, trace in found.items()}
        )
        theory.append(theory_numbers(rig, float(exact.output_tension.max())))
        largest.append(largest_difference(found, skip))
        progress("Fig. 5", done + 1, len(rigs))
    travel = np.linspace(0.05e-3, 6e-3, 240)
    return Figure5(
        rigs,
        (traces[0], traces[1]),
        (numbers[0], numbers[1]),
        (theory[0], theory[1]),
        (largest[0], largest[1]),
        travel,
        _widening(rigs, travel),
        departure(rigs, [found["closed form"] for found in traces]),
    )


def departure(rigs: tuple[Rig, Rig], exact: Sequence[Trace]) -> Departure:
    """Return what F_c moves, from the traces of the closed form without and with it."""
    rubbing = rigs[1]
    offset, lam = rubbing.tension_offset, rubbing.exponent
    slack = rigs[0].slack_displacement
    compliance = -slack / rubbing.pretension
    flats = []
    for trace in exact:
        travel, tension = (
            values[SAMPLES // 4 :] for values in (trace.input_displacement, trace.output_tension)
        )
        low = travel[tension <= tension.min() + 1e-9] - slack
        flats.append((float(low.min()), float(low.max())))
    return Departure(
        offset * (rubbing.slope(1.0) * compliance - 1.0),
        offset * (rubbing.slope(-1.0) * compliance - 1.0),
        float(offset * np.expm1(-lam)),
        float(offset * np.expm1(lam)),
        flats[0],
        flats[1],
    )


def _widening(rigs: tuple[Rig, Rig], travel: Array) -> Array:
    """Relative widening of the loop in T_out between its two lines at the same ξ_in."""
    widths = []
    slack = rigs[0].slack_displacement
    for rig in rigs:
        away = travel + slack - rig.slack_displacement
        widths.append((rig.slope(-1.0) - rig.slope(1.0)) * away)
    return np.asarray(widths[1] / widths[0] - 1.0)
