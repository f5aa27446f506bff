"""Loops of the paper's Fig. 5, without and with tension-independent friction."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.kaneko1991.figure_4a import SAMPLES
from experiments.kaneko1991.figure_5 import AMPLITUDE, BOUND, FREQUENCY, Figure5
from experiments.kaneko1991.figures.loops import MILLI, plot_loops, plot_theory, set_limits
from experiments.kaneko1991.figures.style import PALE, caption_below, legend_above
from tendon_mj.show import BLACK, BLUE, SKY, new_figure, print_style


def draw_figure_5(found: Figure5) -> Figure:
    """Draw Fig. 5 without and with F_c, and the displacements below which F_c matters."""
    shift = found.tendons[0].slack_displacement
    samples = slice(SAMPLES, 2 * SAMPLES + SAMPLES // 4 + 1)
    with print_style():
        figure = new_figure(8.2, 7.6)
        axes = figure.subplots(2, 2)
        for row, (tendon, traces) in enumerate(zip(found.tendons, found.traces, strict=True)):
            plot_loops(axes[row], traces, samples, shift)
            set_limits(axes[row], traces, samples, shift)
            axes[row][0].set_xlim(left=0.0)
            axes[row][0].set_ylim(bottom=0.0)
            plot_theory(axes[row], found.tendons[0], shift)
            axes[row][0].axvspan(0.0, MILLI * BOUND, color=SKY, alpha=0.18, lw=0)
            _zoom(axes[row][0], found, row, shift, samples)
            axes[row][0].set_title(f"Fig. 5, F_c = {tendon.constant_friction:g} N")
            axes[row][0].set_xlabel("input displacement from slack [mm]")
            axes[row][1].set_title("dotted: F_c = 0; middle: no friction")
        legend_above(figure, axes[0][0], 3)
        caption_below(figure, _caption(found))
    return figure


def _zoom(axes: Axes, found: Figure5, row: int, shift: float, samples: slice) -> None:
    """Enlarge the low end of the loop in the free corner."""
    inset = axes.inset_axes((0.57, 0.07, 0.41, 0.41))
    trace = found.traces[row]["closed form"]
    travel = MILLI * (trace.input_displacement[samples] - shift)
    inset.plot(travel, trace.output_tension[samples], color=PALE, lw=4.0)
    trace = found.traces[row]["plugin in MuJoCo"]
    inset.plot(travel, trace.output_tension[samples], color=BLUE, ls=(0, (2, 2)), lw=1.2)
    ends = np.array([0.0, 1.0])
    for sign in (1.0, -1.0):
        inset.plot(
            ends,
            found.tendons[0].transmission_stiffness(sign) * ends / MILLI,
            ":",
            color=BLACK,
            lw=0.9,
        )
    inset.axvspan(0.0, MILLI * BOUND, color=SKY, alpha=0.18, lw=0)
    inset.set(xlim=(0.0, 1.0), ylim=(0.0, 11.0))
    inset.tick_params(labelsize=7)


def _caption(found: Figure5) -> str:
    departure = found.departure
    widening = ", ".join(
        f"{found.widening_at(travel):.0%} at {MILLI * travel:g} mm"
        for travel in (0.5 * BOUND, BOUND, 6 * BOUND)
    )
    return (
        f"T_in = T_0 + {AMPLITUDE:g} N sin(2π {FREQUENCY:g} Hz t); {found.tendons[1].caption()} "
        "below, F_c = 0 above; F_c chosen, not fitted. Band: the 0.5 mm below which the paper sees "
        "its departure; inset: the same corner, closed form and plugin. F_c leaves the slopes and "
        f"moves T_out over ξ_in by {departure.travel_pulling:+.2f} N (pulling), "
        f"{departure.travel_loosening:+.2f} N (loosening) and over T_in by "
        f"{departure.tension_pulling:+.2f} N, {departure.tension_loosening:+.2f} N, everywhere on "
        f"the branches. The distance of the two lines grows by {widening} from slack. Only the "
        f"lower flat is confined to the band. T_out of all routes within {max(found.largest):.2%} "
        "of range."
    )
