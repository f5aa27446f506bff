"""Fig. 4 (a) of the paper: a slow loop with μ_s = μ_d, by every route, and without friction."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from experiments.kaneko1991 import mujoco_route as in_mujoco
from experiments.kaneko1991 import routes
from experiments.kaneko1991.loop import (
    LoopNumbers,
    largest_difference,
    loop_numbers,
    theory_numbers,
)
from experiments.kaneko1991.rig import Rig
from experiments.kaneko1991.routes import Array, Trace
from tendon_mj import reference
from tendon_mj.progress import Progress, silent

FREQUENCY = 0.04  # the paper's [Hz]
AMPLITUDE = 15.0  # T_m < T_0 [N]
RIG = Rig(friction=0.1)  # μ_s = μ_d = 0.1: the paper's
PERIODS = 2.25
SAMPLES = 800  # a period
ELEMENTS = 64
SLOWNESS = 1000.0
STIFF = 1e4
# In MuJoCo the tendon weighs so much that its lowest mode is this many times the frequency.
MUJOCO_ELEMENTS, MUJOCO_SLOWNESS, MUJOCO_DAMPING_RATIO = 16, 300.0, 0.2


@dataclass(frozen=True, eq=False)
class Figure4a:
    """The slow loop.

    Args:
        rig: of the loop.
        time: (samples,) [s].
        traces: by route.
        numbers: read off the last full loop, by route.
        theory: the same by formula.
        straight: without friction, largest |T_out − (T_0 + K_w ξ_in)| over the range, by route [-].
            Sheath and plugin know finite strain, which Hooke's line does not: 1e-3 here, and the
            last entry shows that it goes with 1/EA.
        largest: difference of T_out between two routes, over the range [-].
    """

    rig: Rig
    time: Array
    traces: dict[str, Trace]
    numbers: dict[str, LoopNumbers]
    theory: LoopNumbers
    straight: dict[str, float]
    largest: float

    def slope_errors(self, route: str) -> tuple[float, float]:
        """Relative error of the slope against K_ap, pulling and loosening [-]."""
        found = self.numbers[route]
        return (
            found.slope_pulling / self.theory.slope_pulling - 1.0,
            found.slope_loosening / self.theory.slope_loosening - 1.0,
        )

    @property
    def slope_error(self) -> float:
        """Largest over routes and directions [-]."""
        return max(abs(e) for route in self.numbers for e in self.slope_errors(route))


def sine(
    frequency: float, amplitude: float, pretension: float, periods: float, samples: int
) -> tuple[Array, Array]:
    """Time [s] and T_in = T_0 + T_m sin ωt [N]; eq. (26)."""
    time = np.arange(round(periods * samples) + 1) / (samples * frequency)
    return time, pretension + amplitude * np.sin(2.0 * np.pi * frequency * time)


def slow_mass(rig: Rig, frequency: float) -> tuple[float, float]:
    """Mass [kg] and damping [N s/m] of a tendon in MuJoCo that is slow at ``frequency``."""
    chain = reference.quasi_static(
        routes.elements_chain(rig, MUJOCO_ELEMENTS),
        1.0 / frequency,
        slowness=MUJOCO_SLOWNESS,
        damping_ratio=MUJOCO_DAMPING_RATIO,
    )
    return float(chain.mass.sum()), float(chain.damping.sum())


def figure_4a(progress: Progress = silent) -> Figure4a:
    """Simulate Fig. 4 (a) by every route."""
    rig = RIG
    time, load = sine(FREQUENCY, AMPLITUDE, rig.pretension, PERIODS, SAMPLES)
    exact = routes.closed_form(rig, load, "tension")
    mass, damping = slow_mass(rig, FREQUENCY)
    others: dict[str, Callable[[], Trace]] = {
        "continuum": lambda: routes.continuum(rig, load, "tension"),
        "elements": lambda: routes.slow_elements(
            rig, time, load, "tension", ELEMENTS, 1.0 / FREQUENCY, SLOWNESS
        ),
        "sheath alone": lambda: routes.sheath_alone(rig, load, "tension", ELEMENTS),
        "plugin in MuJoCo": lambda: in_mujoco.plugin(rig, time, exact.input_displacement, ELEMENTS),
        "elements in MuJoCo": lambda: in_mujoco.mujoco_elements(
            rig, time, load, "tension", MUJOCO_ELEMENTS, mass, damping
        ),
    }
    traces = {"closed form": exact}
    for done, (name, run) in enumerate(others.items()):
        traces[name] = run()
        progress("Fig. 4 (a)", done + 1, len(others) + 1)
    straight = _straight(rig)
    progress("Fig. 4 (a)", len(others) + 1, len(others) + 1)
    skip = SAMPLES // 4
    top = float(exact.output_tension.max())
    numbers = {name: loop_numbers(rig, trace, exact, skip) for name, trace in traces.items()}
    theory = theory_numbers(rig, top)
    largest = largest_difference(traces, skip)
    return Figure4a(rig, time, traces, numbers, theory, straight, largest)


def _straight(rig: Rig) -> dict[str, float]:
    """Departure from Hooke's line without friction, over the range of T_out."""
    free = rig.but(friction=0.0)
    time, load = sine(FREQUENCY, AMPLITUDE, rig.pretension, 1.0, 500)
    exact = routes.closed_form(free, load, "tension")
    # real masses here: the sine begins with a kink, and what it rings with must be small
    chain = routes.elements_chain(free, ELEMENTS, mass=1e-6, damping=2e-3)
    traces = {
        "closed form": exact,
        "continuum": routes.continuum(free, load, "tension"),
        "elements": routes.elements(chain, time, load, "tension", 1e-3),
        "sheath alone": routes.sheath_alone(free, load, "tension", ELEMENTS),
        "plugin in MuJoCo": in_mujoco.plugin(free, time, exact.input_displacement, ELEMENTS),
    }
    gaps = {name: _bend(free, trace) for name, trace in traces.items()}
    stiff = free.stiffened(STIFF)
    trace = in_mujoco.plugin(stiff, time, exact.input_displacement / STIFF, ELEMENTS)
    return {**gaps, f"plugin in MuJoCo, EA × {STIFF:g}": _bend(stiff, trace)}


def _bend(rig: Rig, trace: Trace) -> float:
    line = rig.pretension + rig.slope(1.0) * trace.input_displacement
    return float(np.abs(trace.output_tension - line).max() / np.ptp(trace.output_tension))
