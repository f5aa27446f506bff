"""Fig. 4 (a) of the paper: a slow loop with μ_s = μ_d by every route, and without friction."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from experiments import references
from experiments.kaneko1991 import mujoco_routes, routes
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

FREQUENCY = 0.04  # the paper's [Hz]
AMPLITUDE = 15.0  # T_m < T_0 [N]
TENDON = PaperTendon(friction=0.1)  # μ_s = μ_d = 0.1: the paper's
PERIODS = 2.25
SAMPLES = 800  # a period
ELEMENTS = 64
SLOWNESS = 1000.0
STIFFENING = 1e4  # of EA, to take the finite strain away
# In MuJoCo the tendon weighs so much that its lowest mode is this many times the frequency.
MUJOCO_ELEMENTS, MUJOCO_SLOWNESS, MUJOCO_DAMPING_RATIO = 16, 300.0, 0.2


@dataclass(frozen=True, eq=False)
class Figure4a:
    """Slow loop by every route.

    Args:
        tendon: of the loop.
        time: (samples,) [s].
        traces: by route.
        measured: slopes, ratios and backlash of the last full loop, by route.
        predicted: slopes, ratios and backlash by formula.
        nonlinearity: without friction, largest |T_out − (T_0 + K_w ξ_in)| over the range, by
            route [-]. Sheath and plugin have finite strain, which Hooke's law leaves out: 1e-3
            here; the last entry shows that it falls with 1/EA.
        largest: difference of T_out between two routes, over the range [-].
    """

    tendon: PaperTendon
    time: FloatArray
    traces: dict[str, Trace]
    measured: dict[str, LoopMeasures]
    predicted: LoopMeasures
    nonlinearity: dict[str, float]
    largest: float

    def slope_errors(self, route: str) -> tuple[float, float]:
        """Relative errors of the slope against K_ap, pulling and loosening [-]."""
        result = self.measured[route]
        return (
            result.slope_pulling / self.predicted.slope_pulling - 1.0,
            result.slope_loosening / self.predicted.slope_loosening - 1.0,
        )

    @property
    def slope_error(self) -> float:
        """Largest relative error of a slope over routes and directions [-]."""
        return max(abs(e) for route in self.measured for e in self.slope_errors(route))


def quasi_static_mass(tendon: PaperTendon, frequency: float) -> tuple[float, float]:
    """Mass [kg] and damping [N s/m] of elements in MuJoCo, quasi-static at ``frequency`` [Hz]."""
    chain = references.quasi_static(
        routes.element_chain(tendon, MUJOCO_ELEMENTS),
        1.0 / frequency,
        slowness=MUJOCO_SLOWNESS,
        damping_ratio=MUJOCO_DAMPING_RATIO,
    )
    return float(chain.mass.sum()), float(chain.damping.sum())


def simulate_figure_4a(progress: Progress = silent) -> Figure4a:
    """Simulate Fig. 4 (a) by every route."""
    tendon = TENDON
    time, load = tension_sine(FREQUENCY, AMPLITUDE, tendon.pretension, PERIODS, SAMPLES)
    exact = routes.closed_form(tendon, load, "tension")
    mass, damping = quasi_static_mass(tendon, FREQUENCY)
    others: dict[str, Callable[[], Trace]] = {
        "continuum": lambda: routes.continuum(tendon, load, "tension"),
        "elements": lambda: routes.quasi_static_elements(
            tendon, time, load, "tension", ELEMENTS, 1.0 / FREQUENCY, SLOWNESS
        ),
        "sheath alone": lambda: routes.sheath_alone(tendon, load, "tension", ELEMENTS),
        "plugin in MuJoCo": lambda: mujoco_routes.plugin(
            tendon, time, exact.input_displacement, ELEMENTS
        ),
        "elements in MuJoCo": lambda: mujoco_routes.mujoco_elements(
            tendon, time, load, "tension", MUJOCO_ELEMENTS, mass, damping
        ),
    }
    traces = {"closed form": exact}
    for done, (name, run) in enumerate(others.items()):
        traces[name] = run()
        progress("Fig. 4 (a)", done + 1, len(others) + 1)
    nonlinearity = _nonlinearity_by_route(tendon)
    progress("Fig. 4 (a)", len(others) + 1, len(others) + 1)
    skip = SAMPLES // 4
    top = float(exact.output_tension.max())
    measured = {name: measure_loop(tendon, trace, exact, skip) for name, trace in traces.items()}
    predicted = predict_loop(tendon, top)
    largest = largest_difference(traces, skip)
    return Figure4a(tendon, time, traces, measured, predicted, nonlinearity, largest)


def _nonlinearity_by_route(tendon: PaperTendon) -> dict[str, float]:
    """Largest departure from Hooke's law without friction over the range of T_out [-]."""
    frictionless = dataclasses.replace(tendon, friction=0.0)
    time, load = tension_sine(FREQUENCY, AMPLITUDE, tendon.pretension, 1.0, 500)
    exact = routes.closed_form(frictionless, load, "tension")
    travel = exact.input_displacement
    # real masses here: the sine begins with a kink, and the ringing that it excites must be small
    chain = routes.element_chain(frictionless, ELEMENTS, mass=1e-6, damping=2e-3)
    traces = {
        "closed form": exact,
        "continuum": routes.continuum(frictionless, load, "tension"),
        "elements": routes.elements(chain, time, load, "tension", 1e-3),
        "sheath alone": routes.sheath_alone(frictionless, load, "tension", ELEMENTS),
        "plugin in MuJoCo": mujoco_routes.plugin(frictionless, time, travel, ELEMENTS),
    }
    departures = {name: _nonlinearity(frictionless, trace) for name, trace in traces.items()}
    stiff = frictionless.stiffened(STIFFENING)
    trace = mujoco_routes.plugin(stiff, time, travel / STIFFENING, ELEMENTS)
    departures[f"plugin in MuJoCo, EA × {STIFFENING:g}"] = _nonlinearity(stiff, trace)
    return departures


def _nonlinearity(tendon: PaperTendon, trace: Trace) -> float:
    line = tendon.pretension + tendon.transmission_stiffness(1.0) * trace.input_displacement
    return float(np.abs(trace.output_tension - line).max() / np.ptp(trace.output_tension))
