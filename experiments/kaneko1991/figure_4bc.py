"""Fig. 4 (b), (c) of the paper: μ_s = 0.3 against μ_d = 0.1 at 0.5 Hz and at 5 Hz.

The paper sees the operating point shift at the switching points at 0.5 Hz and not at 5 Hz, but
gives neither mass nor damping nor step. The *shift* here is what static friction adds to the same
chain: T_out with μ_s = 0.3 less T_out with μ_s = μ_d = 0.1, largest in a period, over the range.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from experiments.kaneko1991 import mujoco_routes, routes
from experiments.kaneko1991.figure_4a import AMPLITUDE
from experiments.kaneko1991.loop import tension_sine
from experiments.kaneko1991.paper_tendon import PaperTendon
from experiments.kaneko1991.routes import Trace
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.typing import FloatArray

TENDON = PaperTendon(friction=0.1, static_friction=0.3)  # the paper's
FREQUENCIES = (0.5, 5.0)  # the paper's (b) and (c) [Hz]
PERIODS = 3  # that are evaluated
START = 1.25  # periods before them: the first quarter, and one in which the start dies away
SAMPLES = 1000  # a period
GUIDES = (8, 16, 32, 64, 128)


@dataclass(frozen=True, kw_only=True)
class Dynamics:
    """Elements, mass, damping and time steps, which the paper does not give.

    Args:
        name: of the choice.
        elements: n.
        mass, damping: of the whole tendon [kg], [N s/m].
        steps: time steps to integrate with, coarse to fine [s].
    """

    name: str
    elements: int
    mass: float
    damping: float
    steps: tuple[float, ...]


# Inertia carries a slip on to the neighbouring elements; the lowest mode is at 29 Hz.
HEAVY = Dynamics(
    name="heavy", elements=20, mass=3.0, damping=500.0, steps=(3.2e-5, 1.6e-5, 8e-6, 4e-6, 2e-6)
)
# An element that breaks loose creeps to its new place.
OVERDAMPED = Dynamics(
    name="overdamped", elements=16, mass=0.01, damping=1000.0, steps=(2e-5, 1e-5, 5e-6)
)


@dataclass(frozen=True, eq=False)
class Shift:
    """Change of T_out that static friction makes on elements with mass, at one frequency.

    Args:
        dynamics: of the elements.
        frequency: of T_in [Hz].
        largest: of T_out over its range. Shape (steps, periods) [-].
        rms: root mean square of T_out over the period, over its range. Shape (steps, periods) [-].
        phase: where in the period it is largest, 0 where T_in rises through T_0 [-].
        drag: largest |T_out − play(T_in)| with μ_s = μ_d, over the range [-].
    """

    dynamics: Dynamics
    frequency: float
    largest: FloatArray
    rms: FloatArray
    phase: FloatArray
    drag: float


@dataclass(frozen=True, eq=False)
class Figure4bc:
    """Shift of T_out by static friction, with inertia and without.

    Args:
        tendon: of every run.
        shifts: by frequency and dynamics.
        loops: by frequency the traces by route, of the heavy elements with their finest step.
        guides: n of the sheath, which has no inertia. Shape (k,).
        quasi_static: its shift [-]. Shape (k,).
        quasi_static_phase: where in the period that is largest [-]. Shape (k,).
        switches: where in the period the closed form's T_out begins to fall, and to rise [-].
        one_guide: (e^{(μ_s−μ_d)φ/n} − 1) T*/range, the most that one guide can hold back [-]. (k,).
        plugin_difference: T_out of the plugin less that of the sheath alone, over the range [-].
    """

    tendon: PaperTendon
    shifts: tuple[Shift, ...]
    loops: dict[float, dict[str, Trace]]
    guides: FloatArray
    quasi_static: FloatArray
    quasi_static_phase: FloatArray
    switches: tuple[float, float]
    one_guide: FloatArray
    plugin_difference: float


def simulate_figure_4bc(progress: Progress = silent) -> Figure4bc:
    """Simulate Fig. 4 (b) and (c) with both dynamics, and without inertia."""
    shifts, loops = [], {}
    total = 2 * len(FREQUENCIES) + 1
    for frequency in FREQUENCIES:
        for dynamics in (HEAVY, OVERDAMPED):
            shift, sticky, smooth = measure_shift(TENDON, dynamics, frequency)
            shifts.append(shift)
            if dynamics is HEAVY:
                loops[frequency] = _run_routes(frequency, sticky, smooth)
            progress("Fig. 4 (b), (c)", len(shifts), total)
    _, load = _sine(1.0)
    smooth_tendon = TENDON.without_static_excess()
    exact = routes.closed_form(smooth_tendon, load, "tension").output_tension
    span = np.ptp(exact)
    quasi_static, phase = [], []
    for guides in GUIDES:
        sheath = routes.sheath_alone(TENDON, load, "tension", guides)
        change = _by_period(sheath.output_tension - exact)
        quasi_static.append(np.abs(change).max() / span)
        phase.append(_phase_of_largest(change)[-1])
    progress("Fig. 4 (b), (c)", total, total)
    counts = np.array(GUIDES, float)
    one_guide = np.expm1((0.3 - 0.1) * TENDON.bend / counts) * exact.max() / span
    slow = loops[FREQUENCIES[0]]
    difference = slow["plugin in MuJoCo"].output_tension - slow["sheath alone"].output_tension
    return Figure4bc(
        TENDON,
        tuple(shifts),
        loops,
        counts,
        np.array(quasi_static),
        np.array(phase),
        _switches(smooth_tendon, exact),
        one_guide,
        float(np.abs(difference).max() / span),
    )


def measure_shift(
    tendon: PaperTendon, dynamics: Dynamics, frequency: float
) -> tuple[Shift, Trace, Trace]:
    """Shift of elements, with their traces of the finest step with and without μ_s > μ_d."""
    smooth_tendon = tendon.without_static_excess()
    _, load = _sine(frequency, tendon.pretension)
    exact = routes.closed_form(smooth_tendon, load, "tension").output_tension
    span = np.ptp(exact)
    largest, rms, phase = [], [], []
    for step in dynamics.steps:
        sticky = _run_elements(tendon, dynamics, frequency, step)
        smooth = _run_elements(smooth_tendon, dynamics, frequency, step)
        change = _by_period(sticky.output_tension - smooth.output_tension) / span
        largest.append(np.abs(change).max(1))
        rms.append(np.sqrt(np.mean(change**2, axis=1)))
        phase.append(_phase_of_largest(change))
    drag = float(np.abs(smooth.output_tension - exact).max() / span)
    shift = Shift(dynamics, frequency, np.array(largest), np.array(rms), np.array(phase), drag)
    return shift, sticky, smooth


def _sine(frequency: float, pretension: float = TENDON.pretension) -> tuple[FloatArray, FloatArray]:
    return tension_sine(frequency, AMPLITUDE, pretension, PERIODS + START, SAMPLES)


def _run_elements(tendon: PaperTendon, dynamics: Dynamics, frequency: float, step: float) -> Trace:
    time, load = _sine(frequency, tendon.pretension)
    chain = routes.element_chain(tendon, dynamics.elements, dynamics.mass, dynamics.damping)
    return routes.elements(chain, time, load, "tension", step)


def _run_routes(frequency: float, sticky: Trace, smooth: Trace) -> dict[str, Trace]:
    """Traces by route, those of the reference's elements given."""
    time, load = _sine(frequency)
    sheath = routes.sheath_alone(TENDON, load, "tension", HEAVY.elements)
    travel = sheath.input_displacement
    return {
        "closed form, μ_d": routes.closed_form(TENDON.without_static_excess(), load, "tension"),
        "elements, μ_s = μ_d": smooth,
        "elements": sticky,
        "elements in MuJoCo": mujoco_routes.mujoco_elements(
            TENDON, time, load, "tension", HEAVY.elements, HEAVY.mass, HEAVY.damping
        ),
        "sheath alone": sheath,
        "plugin in MuJoCo": mujoco_routes.plugin(TENDON, time, travel, HEAVY.elements),
    }


def _by_period(values: FloatArray) -> FloatArray:
    """Rows of the periods evaluated, each from a quarter past the rise of T_in through T_0."""
    return values[-PERIODS * SAMPLES :].reshape(PERIODS, SAMPLES)


def _phase_of_largest(rows: FloatArray) -> FloatArray:
    """Phase at which each row's magnitude is largest, 0 where T_in rises through T_0 [-]."""
    return np.asarray((0.25 + (np.abs(rows).argmax(1) + 1) / SAMPLES) % 1.0)


def _switches(tendon: PaperTendon, output: FloatArray) -> tuple[float, float]:
    """Phases at which T_in = T_0 + T_m sin ωt has left the backlash by the closed form [-]."""
    near = (output.max() * np.exp(-tendon.exponent), output.min() * np.exp(tendon.exponent))
    fall, rise = (np.arcsin((end - tendon.pretension) / AMPLITUDE) / (2.0 * np.pi) for end in near)
    return float(0.5 - fall), float((1.0 + rise) % 1.0)
