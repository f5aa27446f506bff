"""Fig. 4 (b), (c) of the paper: μ_s = 0.3 against μ_d = 0.1 at 0.5 Hz and at 5 Hz.

The paper sees the operating point shift at the switching points at 0.5 Hz and not at 5 Hz, but
gives neither mass nor damping nor step. The *shift* here is what static friction adds to the same
chain: T_out with μ_s = 0.3 less T_out with μ_s = μ_d = 0.1, largest in a period, over the range.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from experiments.kaneko1991 import mujoco_route as in_mujoco
from experiments.kaneko1991 import routes
from experiments.kaneko1991.figure4 import AMPLITUDE, sine
from experiments.kaneko1991.rig import Rig
from experiments.kaneko1991.routes import Array, Trace
from tendon_mj import reference
from tendon_mj.progress import Progress, silent

RIG = Rig(friction=0.1, static_friction=0.3)  # the paper's
FREQUENCIES = (0.5, 5.0)  # the paper's (b) and (c) [Hz]
PERIODS = 3  # that count
START = 1.25  # periods before them: the first quarter, and one in which the start dies away
SAMPLES = 1000  # a period
GUIDES = (8, 16, 32, 64, 128)


@dataclass(frozen=True, kw_only=True)
class Tendon:
    """A choice of what the paper leaves out.

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


# Heavy: inertia carries a slip on to its neighbours; its lowest mode is at 29 Hz.
HEAVY = Tendon(
    name="heavy", elements=20, mass=3.0, damping=500.0, steps=(3.2e-5, 1.6e-5, 8e-6, 4e-6, 2e-6)
)
# Overdamped: an element that breaks loose creeps to its new place.
OVERDAMPED = Tendon(
    name="overdamped", elements=16, mass=0.01, damping=1000.0, steps=(2e-5, 1e-5, 5e-6)
)


@dataclass(frozen=True, eq=False)
class Shift:
    """The shift of one tendon at one frequency.

    Args:
        tendon, frequency: which [Hz].
        largest: of T_out over its range. Shape (steps, periods) [-].
        rms: the same, root mean square over the period [-].
        phase: where in the period it is largest, 0 where T_in rises through T_0 [-].
        drag: largest |T_out − play(T_in)| with μ_s = μ_d, over the range [-].
    """

    tendon: Tendon
    frequency: float
    largest: Array
    rms: Array
    phase: Array
    drag: float


@dataclass(frozen=True, eq=False)
class Stiction:
    """All that was found out about Fig. 4 (b) and (c).

    Args:
        rig: of every run.
        shifts: by tendon and frequency.
        loops: by frequency the traces by route, the heavy tendon's with its finest step.
        guides: n of the quasi-static sheath. Shape (k,).
        quasi_static: its shift [-]. Shape (k,).
        quasi_static_phase: where in the period that is largest [-]. Shape (k,).
        switches: where in the period the closed form's T_out begins to fall, and to rise [-].
        one_guide: (e^{(μ_s−μ_d)φ/n} − 1) T*/range, the most that one guide can hold back [-]. (k,).
        plugin_difference: T_out of the plugin less that of the sheath alone, over the range [-].
    """

    rig: Rig
    shifts: tuple[Shift, ...]
    loops: dict[float, dict[str, Trace]]
    guides: Array
    quasi_static: Array
    quasi_static_phase: Array
    switches: tuple[float, float]
    one_guide: Array
    plugin_difference: float


def _run(rig: Rig, tendon: Tendon, frequency: float, step: float) -> Trace:
    time, load = sine(frequency, AMPLITUDE, rig.pretension, PERIODS + START, SAMPLES)
    chain: reference.ElementChain = routes.elements_chain(
        rig, tendon.elements, tendon.mass, tendon.damping
    )
    return routes.elements(chain, time, load, "tension", step)


def _by_period(values: Array) -> Array:
    """Rows: the periods that count, each from a quarter past the rise of T_in through T_0."""
    return values[-PERIODS * SAMPLES :].reshape(PERIODS, SAMPLES)


def _phase(values: Array) -> Array:
    """Where in each of its rows |values| is largest, 0 where T_in rises through T_0 [-]."""
    return np.asarray((0.25 + (np.abs(values).argmax(1) + 1) / SAMPLES) % 1.0)


def measure_shift(rig: Rig, tendon: Tendon, frequency: float) -> tuple[Shift, Trace, Trace]:
    """Shift of a tendon, with the traces of the finest step with and without μ_s > μ_d."""
    level = rig.but(static_friction=None)
    _, load = sine(frequency, AMPLITUDE, rig.pretension, PERIODS + START, SAMPLES)
    exact = routes.closed_form(level, load, "tension").output_tension
    span = np.ptp(exact)
    largest, rms, phase = [], [], []
    for step in tendon.steps:
        sticky = _run(rig, tendon, frequency, step)
        smooth = _run(level, tendon, frequency, step)
        gap = _by_period(sticky.output_tension - smooth.output_tension) / span
        largest.append(np.abs(gap).max(1))
        rms.append(np.sqrt(np.mean(gap**2, axis=1)))
        phase.append(_phase(gap))
    drag = float(np.abs(smooth.output_tension - exact).max() / span)
    found = Shift(tendon, frequency, np.array(largest), np.array(rms), np.array(phase), drag)
    return found, sticky, smooth


def _loops(rig: Rig, frequency: float, sticky: Trace, smooth: Trace) -> dict[str, Trace]:
    time, load = sine(frequency, AMPLITUDE, rig.pretension, PERIODS + START, SAMPLES)
    sheath = routes.sheath_alone(rig, load, "tension", HEAVY.elements)
    return {
        "closed form, μ_d": routes.closed_form(rig.but(static_friction=None), load, "tension"),
        "elements, μ_s = μ_d": smooth,
        "elements": sticky,
        "elements in MuJoCo": in_mujoco.mujoco_elements(
            rig, time, load, "tension", HEAVY.elements, HEAVY.mass, HEAVY.damping
        ),
        "sheath alone": sheath,
        "plugin in MuJoCo": in_mujoco.plugin(rig, time, sheath.input_displacement, HEAVY.elements),
    }


def _switches(level: Rig, output: Array) -> tuple[float, float]:
    """Phases at which T_in = T_0 + T_m sin ωt has left the backlash by the closed form."""
    near = (output.max() * np.exp(-level.exponent), output.min() * np.exp(level.exponent))
    fall, rise = (np.arcsin((end - level.pretension) / AMPLITUDE) / (2.0 * np.pi) for end in near)
    return float(0.5 - fall), float((1.0 + rise) % 1.0)


def stiction(progress: Progress = silent) -> Stiction:
    """Simulate Fig. 4 (b) and (c) with both tendons and the quasi-static routes."""
    rig = RIG
    level = rig.but(static_friction=None)
    shifts, loops = [], {}
    total = 2 * len(FREQUENCIES) + 1
    for frequency in FREQUENCIES:
        for tendon in (HEAVY, OVERDAMPED):
            shift, sticky, smooth = measure_shift(rig, tendon, frequency)
            shifts.append(shift)
            if tendon is HEAVY:
                loops[frequency] = _loops(rig, frequency, sticky, smooth)
            progress("Fig. 4 (b), (c)", len(shifts), total)
    _, load = sine(1.0, AMPLITUDE, rig.pretension, PERIODS + START, SAMPLES)
    exact = routes.closed_form(level, load, "tension").output_tension
    found, phase = [], []
    for guides in GUIDES:
        sheath = routes.sheath_alone(rig, load, "tension", guides)
        gap = _by_period(sheath.output_tension - exact)
        found.append(np.abs(gap).max() / np.ptp(exact))
        phase.append(_phase(gap)[-1])
    progress("Fig. 4 (b), (c)", total, total)
    counts = np.array(GUIDES, float)
    held = np.expm1((0.3 - 0.1) * rig.bend / counts) * exact.max() / np.ptp(exact)
    last = loops[FREQUENCIES[0]]
    difference = last["plugin in MuJoCo"].output_tension - last["sheath alone"].output_tension
    return Stiction(
        rig,
        tuple(shifts),
        loops,
        counts,
        np.array(found),
        np.array(phase),
        _switches(level, exact),
        held,
        float(np.abs(difference).max() / np.ptp(exact)),
    )
