"""Loops of the paper's Figs. 4 and 5: all routes overlaid, the parameters stated below."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.kaneko1991.figure4 import AMPLITUDE, FREQUENCY, SAMPLES, Figure4a
from experiments.kaneko1991.figure5 import AMPLITUDE as AMPLITUDE_5
from experiments.kaneko1991.figure5 import BOUND, Figure5
from experiments.kaneko1991.figure5 import FREQUENCY as FREQUENCY_5
from experiments.kaneko1991.rig import Rig
from experiments.kaneko1991.routes import Trace
from experiments.kaneko1991.stiction import HEAVY, Stiction
from experiments.kaneko1991.style import LOOKS, PALE, caption_below, legend_above
from tendon_mj.view.figures.style import BLACK, BLUE, SKY, new_figure, print_style

_MILLI = 1e3
DOTTED = "dotted: closed form at μ_d, and no friction"


def _loops(
    axes: Sequence[Axes], traces: Mapping[str, Trace], samples: slice, shift: float = 0.0
) -> None:
    """ξ_in–T_out and T_in–T_out of every route; ``shift`` [m] is taken from ξ_in."""
    for name, trace in traces.items():
        colour, line, width = LOOKS[name]
        look = {"color": colour, "linestyle": line, "linewidth": width, "label": name}
        out = trace.output_tension[samples]
        travel = _MILLI * (trace.input_displacement[samples] - shift)
        axes[0].plot(travel, out, **look)  # type: ignore[arg-type]
        axes[1].plot(trace.input_tension[samples], out, **look)  # type: ignore[arg-type]
    axes[0].set(xlabel="input displacement ξ_in [mm]", ylabel="output tension T_out [N]")
    axes[1].set(xlabel="input tension T_in [N]", ylabel="output tension T_out [N]")


def _theory_lines(axes: Sequence[Axes], rig: Rig, shift: float = 0.0) -> None:
    """Dotted: both branches of the closed form and the line without friction."""
    for sign in (1.0, -1.0, 0.0):
        lam, offset = sign * rig.exponent, rig.tension_offset
        slope = rig.but(friction=0.0).slope(1.0) if sign == 0.0 else rig.slope(sign)
        travel = np.array(axes[0].get_xlim()) / _MILLI + shift
        line = slope * (travel - rig.slack_displacement) - offset
        axes[0].plot(_MILLI * (travel - shift), line, ":", color=BLACK, lw=0.9)
        tension = np.array(axes[1].get_xlim())
        axes[1].plot(tension, (tension + offset) * np.exp(-lam) - offset, ":", color=BLACK, lw=0.9)


def _frame(axes: Sequence[Axes], traces: Mapping[str, Trace], samples: slice, shift: float) -> None:
    """Limits that hold the loops and nothing else."""
    near = np.concatenate([t.input_tension[samples] for t in traces.values()])
    far = np.concatenate([t.output_tension[samples] for t in traces.values()])
    travel = np.concatenate([t.input_displacement[samples] for t in traces.values()]) - shift
    for axis, values in ((axes[0], _MILLI * travel), (axes[1], near)):
        margin = 0.05 * float(np.ptp(values))
        axis.set_xlim(values.min() - margin, values.max() + margin)
        axis.set_ylim(far.min() - 0.05 * np.ptp(far), far.max() + 0.05 * np.ptp(far))


def loop_figure(
    title: str,
    traces: Mapping[str, Trace],
    rig: Rig,
    caption: str,
    samples: slice,
    dotted: str = "dotted: closed form, and no friction",
) -> Figure:
    """Loops of all routes over ξ_in and T_in, the closed form's lines dotted."""
    with print_style():
        figure = new_figure(8.2, 4.6)
        axes = figure.subplots(1, 2)
        _loops(axes, traces, samples)
        _frame(axes, traces, samples, 0.0)
        _theory_lines(axes, rig)
        axes[0].set_title(title)
        axes[1].set_title(dotted)
        legend_above(figure, axes[0], 3)
        caption_below(figure, caption)
    return figure


def figure_4a(found: Figure4a) -> Figure:
    """Fig. 4 (a): the slow loop with μ_s = μ_d."""
    caption = (
        f"T_in = T_0 + {AMPLITUDE:g} N sin(2π {FREQUENCY:g} Hz t); {found.rig.caption()}. Slopes "
        f"within {found.slope_error:.2%} of K_ap on every route, T_out within {found.largest:.2%} "
        "of range of each other. The last full loop."
    )
    whole = slice(SAMPLES, 2 * SAMPLES + SAMPLES // 4 + 1)
    return loop_figure(f"Fig. 4 (a), {FREQUENCY:g} Hz", found.traces, found.rig, caption, whole)


def figure_4bc(found: Stiction, frequency: float, letter: str) -> Figure:
    """Fig. 4 (b) or (c): static friction above dynamic."""
    shift = next(s for s in found.shifts if s.frequency == frequency and s.tendon is HEAVY)
    caption = (
        f"T_in = T_0 + {AMPLITUDE:g} N sin(2π {frequency:g} Hz t); {found.rig.caption()}. Elements:"
        f" n = {HEAVY.elements}, mass {HEAVY.mass:g} kg, damping {HEAVY.damping:g} N s/m, step "
        f"{1e6 * HEAVY.steps[-1]:g} µs, masses and damping chosen; the last period. What μ_s > μ_d "
        f"adds to T_out of the same chain: its largest in a period is {shift.largest.min():.1%} to "
        f"{shift.largest.max():.1%} of range, over periods and steps h from "
        f"{1e6 * HEAVY.steps[-1]:g} to {1e6 * HEAVY.steps[0]:g} µs, {shift.rms.mean():.1%} rms, at "
        f"phases {shift.phase.min():.2f} to {shift.phase.max():.2f} of the period (closed form: "
        f"T_out turns at {found.switches[0]:.2f} and {found.switches[1]:.2f}). Sheath alone and "
        "plugin know no inertia. The continuum knows one μ only and is left out."
    )
    title = f"Fig. 4 ({letter}), {frequency:g} Hz"
    level = found.rig.but(static_friction=None)
    return loop_figure(title, found.loops[frequency], level, caption, slice(-1001, None), DOTTED)


def figure_5(found: Figure5) -> Figure:
    """Fig. 5: without and with F_c, and where it tells."""
    shift, gone = found.rigs[0].slack_displacement, found.departure
    samples = slice(SAMPLES, 2 * SAMPLES + SAMPLES // 4 + 1)
    with print_style():
        figure = new_figure(8.2, 7.6)
        axes = figure.subplots(2, 2)
        for row, (rig, traces) in enumerate(zip(found.rigs, found.traces, strict=True)):
            _loops(axes[row], traces, samples, shift)
            _frame(axes[row], traces, samples, shift)
            axes[row][0].set_xlim(left=0.0)
            axes[row][0].set_ylim(bottom=0.0)
            _theory_lines(axes[row], found.rigs[0], shift)
            axes[row][0].axvspan(0.0, _MILLI * BOUND, color=SKY, alpha=0.18, lw=0)
            _zoom(axes[row][0], found, row, shift, samples)
            axes[row][0].set_title(f"Fig. 5, F_c = {rig.constant_friction:g} N")
            axes[row][0].set_xlabel("input displacement from slack [mm]")
            axes[row][1].set_title("dotted: F_c = 0; middle: no friction")
        legend_above(figure, axes[0][0], 3)
        caption_below(
            figure,
            f"T_in = T_0 + {AMPLITUDE_5:g} N sin(2π {FREQUENCY_5:g} Hz t); "
            f"{found.rigs[1].caption()} below, F_c = 0 above; F_c chosen, not fitted. Band: the "
            "0.5 mm below which the paper sees its departure; inset: the same corner, closed form "
            "and plugin. F_c leaves the slopes and moves T_out over ξ_in by "
            f"{gone.travel_pulling:+.2f} N (pulling), {gone.travel_loosening:+.2f} N (loosening) "
            f"and over T_in by {gone.tension_pulling:+.2f} N, {gone.tension_loosening:+.2f} N, "
            "everywhere on the branches. The distance of the two lines grows by "
            f"{found.widening_at(0.5 * BOUND):.0%} at {500 * BOUND:g} mm, "
            f"{found.widening_at(BOUND):.0%} at {_MILLI * BOUND:g} mm and "
            f"{found.widening_at(6 * BOUND):.0%} at {6e3 * BOUND:g} mm from slack. Only the lower "
            "flat is confined to the band. "
            f"T_out of all routes within {max(found.largest):.2%} of range.",
        )
    return figure


def _zoom(axes: Axes, found: Figure5, row: int, shift: float, samples: slice) -> None:
    """The low end of the loop larger, in the free corner."""
    inset = axes.inset_axes((0.57, 0.07, 0.41, 0.41))
    trace = found.traces[row]["closed form"]
    travel = _MILLI * (trace.input_displacement[samples] - shift)
    inset.plot(travel, trace.output_tension[samples], color=PALE, lw=4.0)
    trace = found.traces[row]["plugin in MuJoCo"]
    inset.plot(travel, trace.output_tension[samples], color=BLUE, ls=(0, (2, 2)), lw=1.2)
    ends = np.array([0.0, 1.0])
    for sign in (1.0, -1.0):
        inset.plot(ends, found.rigs[0].slope(sign) * ends / _MILLI, ":", color=BLACK, lw=0.9)
    inset.axvspan(0.0, _MILLI * BOUND, color=SKY, alpha=0.18, lw=0)
    inset.set(xlim=(0.0, 1.0), ylim=(0.0, 11.0))
    inset.tick_params(labelsize=7)
