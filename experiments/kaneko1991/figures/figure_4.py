"""Loops of the paper's Fig. 4: all routes overlaid, the parameters stated below."""

from __future__ import annotations

from collections.abc import Mapping

from matplotlib.figure import Figure

from experiments.kaneko1991.figure_4a import AMPLITUDE, FREQUENCY, SAMPLES, Figure4a
from experiments.kaneko1991.figure_4bc import SAMPLES as SAMPLES_4BC
from experiments.kaneko1991.figure_4bc import Figure4bc
from experiments.kaneko1991.figures.loops import plot_loops, plot_theory, set_limits
from experiments.kaneko1991.figures.style import caption_below, legend_above
from experiments.kaneko1991.paper_tendon import PaperTendon
from experiments.kaneko1991.routes import Trace
from tendon_mj.show import new_figure, print_style

_DOTTED = "dotted: closed form at μ_d, and no friction"


def _draw_loops(
    title: str,
    traces: Mapping[str, Trace],
    tendon: PaperTendon,
    caption: str,
    samples: slice,
    dotted: str = "dotted: closed form, and no friction",
) -> Figure:
    """Draw the loops of all routes over ξ_in and T_in, the closed form's lines dotted."""
    with print_style():
        figure = new_figure(8.2, 4.6)
        axes = figure.subplots(1, 2)
        plot_loops(axes, traces, samples)
        set_limits(axes, traces, samples, 0.0)
        plot_theory(axes, tendon)
        axes[0].set_title(title)
        axes[1].set_title(dotted)
        legend_above(figure, axes[0], 3)
        caption_below(figure, caption)
    return figure


def draw_figure_4a(found: Figure4a) -> Figure:
    """Draw Fig. 4 (a): the slow loop with μ_s = μ_d."""
    caption = (
        f"T_in = T_0 + {AMPLITUDE:g} N sin(2π {FREQUENCY:g} Hz t); {found.tendon.caption()}. "
        f"Slopes within {found.slope_error:.2%} of K_ap on every route, T_out within "
        f"{found.largest:.2%} of range of each other. The last full loop."
    )
    whole = slice(SAMPLES, 2 * SAMPLES + SAMPLES // 4 + 1)
    return _draw_loops(f"Fig. 4 (a), {FREQUENCY:g} Hz", found.traces, found.tendon, caption, whole)


def draw_figure_4bc(found: Figure4bc, frequency: float, letter: str) -> Figure:
    """Draw Fig. 4 (b) or (c): static friction above dynamic, with the heavy elements."""
    shift = next(s for s in found.shifts if s.frequency == frequency and s.dynamics.name == "heavy")
    heavy = shift.dynamics
    coarse, fine = 1e6 * heavy.steps[0], 1e6 * heavy.steps[-1]
    caption = (
        f"T_in = T_0 + {AMPLITUDE:g} N sin(2π {frequency:g} Hz t); {found.tendon.caption()}. "
        f"Elements: n = {heavy.elements}, mass {heavy.mass:g} kg, damping {heavy.damping:g} N s/m, "
        f"step {fine:g} µs, masses and damping chosen; the last period. The shift of T_out by "
        f"μ_s > μ_d on this chain, largest in a period, is {shift.largest.min():.1%} to "
        f"{shift.largest.max():.1%} of range, over periods and steps h from {fine:g} to "
        f"{coarse:g} µs, {shift.rms.mean():.1%} rms, at phases {shift.phase.min():.2f} to "
        f"{shift.phase.max():.2f} of the period (closed form: T_out turns at "
        f"{found.switches[0]:.2f} and {found.switches[1]:.2f}). Sheath alone and plugin have no "
        "inertia. The continuum has one μ only and is left out."
    )
    title = f"Fig. 4 ({letter}), {frequency:g} Hz"
    tendon = found.tendon.without_static_excess()
    period = slice(-SAMPLES_4BC - 1, None)
    return _draw_loops(title, found.loops[frequency], tendon, caption, period, _DOTTED)
