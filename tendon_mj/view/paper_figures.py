"""Figures of the paper's reproduction: each overlays all routes and states its parameters."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tendon_mj.simulate.paper_agreement import Agreement, Refinement
from tendon_mj.simulate.paper_cost import Cost
from tendon_mj.simulate.paper_figure4 import AMPLITUDE, FREQUENCY, SAMPLES, Figure4a
from tendon_mj.simulate.paper_figure5 import AMPLITUDE as AMPLITUDE_5
from tendon_mj.simulate.paper_figure5 import BOUND, Figure5
from tendon_mj.simulate.paper_figure5 import FREQUENCY as FREQUENCY_5
from tendon_mj.simulate.paper_rig import Rig
from tendon_mj.simulate.paper_routes import Trace
from tendon_mj.simulate.paper_stiction import HEAVY, Stiction
from tendon_mj.view.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    VERMILLION,
    new_figure,
    print_style,
)

Array = NDArray[np.float64]
PALE = "#BDBDBD"
# colour, line, width: wide and pale below, narrow and dark above, so that all stay visible
_LOOKS: dict[str, tuple[str, object, float]] = {
    "closed form": (PALE, "-", 4.0),
    "closed form, μ_d": (PALE, "-", 4.0),
    "continuum": (SKY, "-", 2.6),
    "elements, μ_s = μ_d": (GREEN, (0, (1, 1)), 1.5),
    "elements": (VERMILLION, "-", 1.2),
    "elements in MuJoCo": (PURPLE, (0, (6, 1.5, 1, 1.5)), 1.0),
    "sheath alone": (ORANGE, (0, (5, 3)), 1.4),
    "plugin in MuJoCo": (BLUE, (0, (2, 2)), 1.2),
}
_MILLI = 1e3
_LINE = 0.165  # height of a caption's line [inch]


def _caption(figure: Figure, text: str) -> None:
    """Put a caption at the bottom, below everything that the layout places."""
    width, height = figure.get_size_inches()
    lines = textwrap.wrap(text, round(15.5 * width))
    share = (_LINE * len(lines) + 0.08) / (height + _LINE * len(lines))
    figure.set_size_inches(width, height + _LINE * len(lines))
    figure.get_layout_engine().set(rect=(0.0, share, 1.0, 1.0 - share))  # type: ignore[union-attr,call-arg]
    figure.text(
        0.5, 0.04 / height, "\n".join(lines), ha="center", va="bottom", size=7.5, color=GREY
    )


def _legend(figure: Figure, axes: Axes, columns: int) -> None:
    """Put the legend of ``axes`` above everything; the caption has the place below."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=columns)


def _loops(
    axes: Sequence[Axes], traces: Mapping[str, Trace], samples: slice, shift: float = 0.0
) -> None:
    """ξ_in–T_out and T_in–T_out of every route; ``shift`` [m] is taken from ξ_in."""
    for name, trace in traces.items():
        colour, line, width = _LOOKS[name]
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
    title: str, traces: Mapping[str, Trace], rig: Rig, caption: str, samples: slice
) -> Figure:
    """Loops of all routes over ξ_in and T_in, the closed form's lines dotted."""
    with print_style():
        figure = new_figure(8.2, 4.6)
        axes = figure.subplots(1, 2)
        _loops(axes, traces, samples)
        _frame(axes, traces, samples, 0.0)
        _theory_lines(axes, rig)
        axes[0].set_title(title)
        axes[1].set_title("dotted: closed form, and no friction")
        _legend(figure, axes[0], 3)
        _caption(figure, caption)
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
        f"{1e6 * HEAVY.steps[-1]:g} µs, masses and damping chosen. What μ_s > μ_d adds to T_out of "
        f"the same chain: at most {shift.largest.min():.1%} to {shift.largest.max():.1%} of range "
        f"a period, over three steps h; {shift.rms.mean():.1%} rms. Sheath alone and plugin "
        "know no inertia."
    )
    title = f"Fig. 4 ({letter}), {frequency:g} Hz"
    level = found.rig.but(static_friction=None)
    return loop_figure(title, found.loops[frequency], level, caption, slice(-1001, None))


def figure_5(found: Figure5) -> Figure:
    """Fig. 5: without and with F_c, and where it tells."""
    shift = found.rigs[0].slack_displacement
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
            axes[row][1].set_title("dotted: closed form, F_c = 0")
        _legend(figure, axes[0][0], 3)
        _caption(
            figure,
            f"T_in = T_0 + {AMPLITUDE_5:g} N sin(2π {FREQUENCY_5:g} Hz t); "
            f"{found.rigs[1].caption()}; F_c chosen, not fitted. "
            f"The loop is {found.widening_at(BOUND):.0%} wider for F_c at {_MILLI * BOUND:g} mm "
            f"from slack, {found.widening_at(0.5 * BOUND):.0%} at {500 * BOUND:g} mm and "
            f"{found.widening_at(6 * BOUND):.0%} at {6e3 * BOUND:g} mm; the slopes do not change. "
            f"T_out of all routes within {max(found.largest):.1%} of range.",
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


def agreement_figure(found: Agreement) -> Figure:
    """Minor loops by all routes, and what they leave between each other."""
    with print_style():
        figure = new_figure(8.2, 4.4)
        axes = figure.subplots(1, 2)
        exact = found.loops["closed form"].output_tension
        for name, trace in found.loops.items():
            colour, line, width = _LOOKS[name]
            look = {"color": colour, "linestyle": line, "label": name}
            travel = _MILLI * trace.input_displacement
            axes[0].plot(travel, trace.output_tension, linewidth=width, **look)
            error = 100.0 * (trace.output_tension - exact) / np.ptp(exact)
            axes[1].plot(error, linewidth=min(width, 1.5), **look)
        axes[0].set(xlabel="ξ_in [mm]", ylabel="T_out [N]", title="Minor loops")
        axes[1].axhspan(-0.5, 0.5, color=SKY, alpha=0.15, lw=0)
        axes[1].set(xlabel="sample", ylabel="less closed form [% of range]", title="What is left")
        _legend(figure, axes[0], 5)
        _caption(
            figure,
            f"{found.rig.caption()}; 64 elements or guides. Largest difference between two routes, "
            f"with {found.histories} random histories: {found.largest:.2%} of range.",
        )
    return figure


def refinement_figure(found: Refinement) -> Figure:
    """Error over the number of elements, with a line of order 2."""
    with print_style():
        figure = new_figure(6.0, 4.6)
        axes = figure.subplots()
        for name, error in found.error.items():
            colour, line, width = _LOOKS[name.split(",")[0]]
            far = "×" in name
            axes.loglog(
                found.elements,
                error,
                color=colour,
                linestyle="-" if far else line,
                linewidth=1.0 if far else max(width, 1.4),
                marker="s" if far else "o",
                markerfacecolor="white" if far else colour,
                label=f"{name} ({_fall(found, name)})",
            )
        guide = found.error["continuum"][0] * (found.elements[0] / found.elements) ** 2
        axes.loglog(found.elements, 0.5 * guide, ":", color=BLACK, label="order 2")
        axes.set_xticks(found.elements, [f"{n:g}" for n in found.elements])
        axes.minorticks_off()
        axes.set(xlabel="elements, guides or intervals n", ylabel="rms error of T_out / range")
        axes.set_title("Refinement")
        _legend(figure, axes, 2)
        _caption(
            figure,
            f"{found.rig.caption()}; outer loop against the closed form. Sheath and plugin level "
            "off at finite strain, ξ/L and T/EA of 1e-3, which the closed form neglects; with EA "
            "× 100 that is gone. The elements level off at their inertia.",
        )
    return figure


def _fall(found: Refinement, name: str) -> str:
    return f"order {found.order[name]:.2f}" if name in found.order else "levels off"


def stiction_figure(found: Stiction) -> Figure:
    """The shift over n without inertia, and over the step with it."""
    with print_style():
        figure = new_figure(8.2, 4.2)
        left, right = figure.subplots(1, 2)
        left.loglog(found.guides, 100 * found.one_guide, ":", color=BLACK, label="one guide at μ_s")
        left.loglog(found.guides, 100 * found.quasi_static, "o-", color=BLUE, label="sheath alone")
        left.set(xlabel="guides n", ylabel="shift [% of range]", title="No inertia")
        left.set_xticks(found.guides, [f"{n:g}" for n in found.guides])
        left.minorticks_off()
        left.legend()
        for shift, (colour, mark) in zip(
            found.shifts,
            ((VERMILLION, "o"), (ORANGE, "s"), (BLUE, "o"), (SKY, "s")),
            strict=True,
        ):
            steps = 1e6 * np.array(shift.tendon.steps)
            mean = 100 * shift.largest.mean(1)
            reach = 100 * np.array([shift.largest.min(1), shift.largest.max(1)])
            right.errorbar(
                steps,
                mean,
                np.abs(reach - mean),
                color=colour,
                marker=mark,
                capsize=3,
                label=f"{shift.tendon.name}, {shift.frequency:g} Hz",
            )
        right.set_xscale("log")
        right.set(xlabel="time step h [µs]", ylabel="shift [% of range]", title="With inertia")
        right.set_ylim(bottom=0.0)
        right.set_xticks([5, 10, 20, 40], ["5", "10", "20", "40"])
        right.minorticks_off()
        right.legend(ncols=2, loc="upper left")
        right.set_ylim(top=1.25 * right.get_ylim()[1])
        _caption(
            figure,
            "Shift: what μ_s = 0.3 against μ_d = 0.1 adds to T_out, largest in a period, over the "
            "range. Right: three periods each, bars from least to most. "
            + "; ".join(
                f"{t.name}: n = {t.elements}, {t.mass:g} kg, {t.damping:g} N s/m"
                for t in (found.shifts[0].tendon, found.shifts[1].tendon)
            )
            + ".",
        )
    return figure


def cost_figure(costs: Sequence[Cost]) -> Figure:
    """Wall time of a simulated second by route."""
    with print_style():
        figure = new_figure(6.4, 3.2)
        axes = figure.subplots()
        names = [c.route for c in costs]
        axes.barh(
            names, [c.seconds for c in costs], color=[_LOOKS[n][0] for n in names], height=0.6
        )
        for c in costs:
            step = f"h = {1e3 * c.step:.3g} ms" + (f", n = {c.elements}" if c.elements else "")
            axes.annotate(
                f"{c.seconds:.1e} s; {step}; {c.error:.1%}",
                (c.seconds, c.route),
                xytext=(4, 0),
                textcoords="offset points",
                va="center",
                fontsize=7.5,
            )
        axes.set_xscale("log")
        axes.set_xlim(min(c.seconds for c in costs) / 3, 300 * max(c.seconds for c in costs))
        axes.invert_yaxis()
        axes.grid(visible=False, axis="y")
        axes.set(xlabel="wall time per simulated second [s]", title="Cost at 1 % of range")
    return figure
