"""Pictures of the study: data in, figures out."""

from __future__ import annotations

import dataclasses
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.kaneko1991.agreement import Agreement
from experiments.kaneko1991.cost import Cost
from experiments.kaneko1991.figure_4a import AMPLITUDE, FREQUENCY, SAMPLES, Figure4a
from experiments.kaneko1991.figure_4bc import SAMPLES as SAMPLES_4BC
from experiments.kaneko1991.figure_4bc import Figure4bc
from experiments.kaneko1991.figure_5 import AMPLITUDE as AMPLITUDE_5
from experiments.kaneko1991.figure_5 import BOUND, Figure5
from experiments.kaneko1991.figure_5 import FREQUENCY as FREQUENCY_5
from experiments.kaneko1991.loop import LEG_SAMPLES, LEG_TIME
from experiments.kaneko1991.paper_tendon import PaperTendon
from experiments.kaneko1991.refinement import STIFFENING, Refinement
from experiments.kaneko1991.reproduction import Reproduction
from experiments.kaneko1991.routes import Trace
from tendon_mj.show.style import (
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

PALE = "#BDBDBD"
# colour, line, width: wide and pale below, narrow and dark above, so that all stay visible
LOOKS: dict[str, tuple[str, object, float]] = {
    "closed form": (PALE, "-", 4.0),
    "closed form, μ_d": (PALE, "-", 4.0),
    "continuum": (SKY, "-", 2.6),
    "elements, μ_s = μ_d": (GREEN, (0, (1, 1)), 1.5),
    "elements": (VERMILLION, "-", 1.2),
    "elements in MuJoCo": (PURPLE, (0, (6, 1.5, 1, 1.5)), 1.0),
    "sheath alone": (ORANGE, (0, (5, 3)), 1.4),
    "plugin in MuJoCo": (BLUE, (0, (2, 2)), 1.2),
}
_LINE = 0.165  # height of a caption's line [inch]
MILLI = 1e3
_MILLI = 1e3
_DOTTED = "dotted: closed form at μ_d, and no friction"


def caption_below(figure: Figure, text: str) -> None:
    """Put a caption at the bottom, below everything that the layout places."""
    width, height = figure.get_size_inches()
    lines = textwrap.wrap(text, round(15.5 * width))
    share = (_LINE * len(lines) + 0.08) / (height + _LINE * len(lines))
    figure.set_size_inches(width, height + _LINE * len(lines))
    figure.get_layout_engine().set(rect=(0.0, share, 1.0, 1.0 - share))  # type: ignore[union-attr,call-arg]
    figure.text(
        0.5, 0.04 / height, "\n".join(lines), ha="center", va="bottom", size=7.5, color=GREY
    )


def legend_above(figure: Figure, axes: Axes, columns: int) -> None:
    """Put the legend of ``axes`` above everything; the caption has the place below."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=columns)


def plot_loops(
    axes: Sequence[Axes], traces: Mapping[str, Trace], samples: slice, shift: float = 0.0
) -> None:
    """Plot T_out over ξ_in and over T_in for every route; ``shift`` [m] is taken from ξ_in."""
    for name, trace in traces.items():
        colour, line, width = LOOKS[name]
        look = {"color": colour, "linestyle": line, "linewidth": width, "label": name}
        out = trace.output_tension[samples]
        travel = MILLI * (trace.input_displacement[samples] - shift)
        axes[0].plot(travel, out, **look)  # type: ignore[arg-type]
        axes[1].plot(trace.input_tension[samples], out, **look)  # type: ignore[arg-type]
    axes[0].set(xlabel="input displacement ξ_in [mm]", ylabel="output tension T_out [N]")
    axes[1].set(xlabel="input tension T_in [N]", ylabel="output tension T_out [N]")


def plot_theory(axes: Sequence[Axes], tendon: PaperTendon, shift: float = 0.0) -> None:
    """Plot, dotted, both branches of the closed form and the line without friction."""
    for sign in (1.0, -1.0, 0.0):
        lam, offset = sign * tendon.exponent, tendon.tension_offset
        sliding = tendon if sign else dataclasses.replace(tendon, friction=0.0)
        slope = sliding.transmission_stiffness(sign or 1.0)
        travel = np.array(axes[0].get_xlim()) / MILLI + shift
        line = slope * (travel - tendon.slack_displacement) - offset
        axes[0].plot(MILLI * (travel - shift), line, ":", color=BLACK, lw=0.9)
        tension = np.array(axes[1].get_xlim())
        axes[1].plot(tension, (tension + offset) * np.exp(-lam) - offset, ":", color=BLACK, lw=0.9)


def set_limits(
    axes: Sequence[Axes], traces: Mapping[str, Trace], samples: slice, shift: float
) -> None:
    """Set the limits so that they hold the loops and nothing else."""
    near = np.concatenate([t.input_tension[samples] for t in traces.values()])
    far = np.concatenate([t.output_tension[samples] for t in traces.values()])
    travel = np.concatenate([t.input_displacement[samples] for t in traces.values()]) - shift
    for axis, values in ((axes[0], MILLI * travel), (axes[1], near)):
        margin = 0.05 * float(np.ptp(values))
        axis.set_xlim(values.min() - margin, values.max() + margin)
        axis.set_ylim(far.min() - 0.05 * np.ptp(far), far.max() + 0.05 * np.ptp(far))


def draw_agreement(agreement: Agreement) -> Figure:
    """Draw minor loops by all routes, and the differences between the routes."""
    with print_style():
        figure = new_figure(8.2, 4.4)
        axes = figure.subplots(1, 2)
        exact = agreement.loops["closed form"].output_tension
        time = LEG_TIME / LEG_SAMPLES * np.arange(exact.size)
        for name, trace in agreement.loops.items():
            colour, line, width = LOOKS[name]
            look = {"color": colour, "linestyle": line, "label": name}
            travel = _MILLI * trace.input_displacement
            axes[0].plot(travel, trace.output_tension, linewidth=width, **look)
            error = 100.0 * (trace.output_tension - exact) / np.ptp(exact)
            axes[1].plot(time, error, linewidth=min(width, 1.5), **look)
        axes[0].set(xlabel="ξ_in [mm]", ylabel="T_out [N]", title="Minor loops")
        axes[1].axhspan(-0.5, 0.5, color=SKY, alpha=0.15, lw=0)
        axes[1].set(
            xlabel=f"time [s], {LEG_TIME:g} s from one turning point to the next",
            ylabel="T_out less closed form [% of range]",
            title="Difference (band: ±0.5 %)",
        )
        legend_above(figure, axes[0], 5)
        caption_below(
            figure,
            f"{agreement.tendon.caption()}; 64 elements or guides, 256 grid intervals. Largest "
            "difference between two routes on all histories, "
            f"{agreement.histories} random ones among them: T_out {agreement.largest:.2%}, T_in "
            f"{agreement.largest_input:.2%} of range.",
        )
    return figure


def draw_refinement(refinement: Refinement) -> Figure:
    """Draw the error over the number of elements, with a line of order 2."""
    with print_style():
        figure = new_figure(6.0, 4.6)
        axes = figure.subplots()
        for name, error in refinement.error.items():
            colour, line, width = LOOKS[name.split(",")[0]]
            far = "×" in name
            axes.loglog(
                refinement.elements,
                error,
                color=colour,
                linestyle="-" if far else line,
                linewidth=1.0 if far else max(width, 1.4),
                marker="s" if far else "o",
                markerfacecolor="white" if far else colour,
                label=f"{name} ({_order_label(refinement, name)})",
            )
        guide = (
            refinement.error["continuum"][0] * (refinement.elements[0] / refinement.elements) ** 2
        )
        axes.loglog(refinement.elements, 0.5 * guide, ":", color=BLACK, label="order 2")
        axes.set_xticks(refinement.elements, [f"{n:g}" for n in refinement.elements])
        axes.minorticks_off()
        axes.set(xlabel="elements, guides or intervals n", ylabel="rms error of T_out / range")
        axes.set_title("Refinement")
        legend_above(figure, axes, 2)
        caption_below(
            figure,
            f"{refinement.tendon.caption()}; outer loop against the closed form. At this EA the "
            "errors of sheath and plugin level off at finite strain, ξ/L and T/EA of 1e-3, which "
            "the closed form neglects. Squares: at EA = "
            f"{STIFFENING * refinement.tendon.axial_stiffness / 1e3:g} kN, T_0 and all tensions "
            "kept, they converge. The error of the elements levels off at their inertia. The order "
            "is that of the points before a curve levels off. Elements in MuJoCo are left out: "
            "their step is proportional to 1/n, and their inertia would dominate.",
        )
    return figure


def _order_label(refinement: Refinement, name: str) -> str:
    return f"order {refinement.order[name]:.2f}" if name in refinement.order else "levels off"


def draw_costs(costs: Sequence[Cost]) -> Figure:
    """Draw the wall time of a simulated second by route."""
    with print_style():
        figure = new_figure(6.4, 3.2)
        axes = figure.subplots()
        names = [c.route for c in costs]
        axes.barh(names, [c.seconds for c in costs], color=[LOOKS[n][0] for n in names], height=0.6)
        for c in costs:
            step = f"h = {1e3 * c.step:.3g} ms" + (f", n = {c.elements}" if c.elements else "")
            axes.annotate(
                f"{c.seconds:.1e} s; {step}; error {c.error:.1%}",
                (c.seconds, c.route),
                xytext=(4, 0),
                textcoords="offset points",
                va="center",
                fontsize=7.5,
            )
        axes.set_xscale("log")
        axes.set_xlim(min(c.seconds for c in costs) / 3, 1e5 * max(c.seconds for c in costs))
        axes.invert_yaxis()
        axes.grid(visible=False, axis="y")
        axes.set(
            xlabel="wall time per simulated second [s]",
            title="Cost of an error of at most 1 % of range",
        )
    return figure


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


def draw_figure_4a(data: Figure4a) -> Figure:
    """Draw Fig. 4 (a): the slow loop with μ_s = μ_d."""
    caption = (
        f"T_in = T_0 + {AMPLITUDE:g} N sin(2π {FREQUENCY:g} Hz t); {data.tendon.caption()}. "
        f"Slopes within {data.slope_error:.2%} of K_ap on every route, T_out within "
        f"{data.largest:.2%} of range of each other. The last full loop."
    )
    whole = slice(SAMPLES, 2 * SAMPLES + SAMPLES // 4 + 1)
    return _draw_loops(f"Fig. 4 (a), {FREQUENCY:g} Hz", data.traces, data.tendon, caption, whole)


def draw_figure_4bc(data: Figure4bc, frequency: float, letter: str) -> Figure:
    """Draw Fig. 4 (b) or (c): static friction above dynamic, with the heavy elements."""
    shift = next(s for s in data.shifts if s.frequency == frequency and s.dynamics.name == "heavy")
    heavy = shift.dynamics
    coarse, fine = 1e6 * heavy.steps[0], 1e6 * heavy.steps[-1]
    caption = (
        f"T_in = T_0 + {AMPLITUDE:g} N sin(2π {frequency:g} Hz t); {data.tendon.caption()}. "
        f"Elements: n = {heavy.elements}, mass {heavy.mass:g} kg, damping {heavy.damping:g} N s/m, "
        f"step {fine:g} µs, masses and damping chosen; the last period. The shift of T_out by "
        f"μ_s > μ_d on this chain, largest in a period, is {shift.largest.min():.1%} to "
        f"{shift.largest.max():.1%} of range, over periods and steps h from {fine:g} to "
        f"{coarse:g} µs, {shift.rms.mean():.1%} rms, at phases {shift.phase.min():.2f} to "
        f"{shift.phase.max():.2f} of the period (closed form: T_out turns at "
        f"{data.switches[0]:.2f} and {data.switches[1]:.2f}). Sheath alone and plugin have no "
        "inertia. The continuum has one μ only and is left out."
    )
    title = f"Fig. 4 ({letter}), {frequency:g} Hz"
    tendon = data.tendon.without_static_excess()
    period = slice(-SAMPLES_4BC - 1, None)
    return _draw_loops(title, data.loops[frequency], tendon, caption, period, _DOTTED)


def draw_figure_5(data: Figure5) -> Figure:
    """Draw Fig. 5 without and with F_c, and the displacements below which F_c matters."""
    shift = data.tendons[0].slack_displacement
    samples = slice(SAMPLES, 2 * SAMPLES + SAMPLES // 4 + 1)
    with print_style():
        figure = new_figure(8.2, 7.6)
        axes = figure.subplots(2, 2)
        for row, (tendon, traces) in enumerate(zip(data.tendons, data.traces, strict=True)):
            plot_loops(axes[row], traces, samples, shift)
            set_limits(axes[row], traces, samples, shift)
            axes[row][0].set_xlim(left=0.0)
            axes[row][0].set_ylim(bottom=0.0)
            plot_theory(axes[row], data.tendons[0], shift)
            axes[row][0].axvspan(0.0, MILLI * BOUND, color=SKY, alpha=0.18, lw=0)
            _zoom(axes[row][0], data, row, shift, samples)
            axes[row][0].set_title(f"Fig. 5, F_c = {tendon.constant_friction:g} N")
            axes[row][0].set_xlabel("input displacement from slack [mm]")
            axes[row][1].set_title("dotted: F_c = 0; middle: no friction")
        legend_above(figure, axes[0][0], 3)
        caption_below(figure, _caption(data))
    return figure


def _zoom(axes: Axes, data: Figure5, row: int, shift: float, samples: slice) -> None:
    """Enlarge the low end of the loop in the free corner."""
    inset = axes.inset_axes((0.57, 0.07, 0.41, 0.41))
    trace = data.traces[row]["closed form"]
    travel = MILLI * (trace.input_displacement[samples] - shift)
    inset.plot(travel, trace.output_tension[samples], color=PALE, lw=4.0)
    trace = data.traces[row]["plugin in MuJoCo"]
    inset.plot(travel, trace.output_tension[samples], color=BLUE, ls=(0, (2, 2)), lw=1.2)
    ends = np.array([0.0, 1.0])
    for sign in (1.0, -1.0):
        inset.plot(
            ends,
            data.tendons[0].transmission_stiffness(sign) * ends / MILLI,
            ":",
            color=BLACK,
            lw=0.9,
        )
    inset.axvspan(0.0, MILLI * BOUND, color=SKY, alpha=0.18, lw=0)
    inset.set(xlim=(0.0, 1.0), ylim=(0.0, 11.0))
    inset.tick_params(labelsize=7)


def _caption(data: Figure5) -> str:
    departure = data.departure
    widening = ", ".join(
        f"{data.widening_at(travel):.0%} at {MILLI * travel:g} mm"
        for travel in (0.5 * BOUND, BOUND, 6 * BOUND)
    )
    return (
        f"T_in = T_0 + {AMPLITUDE_5:g} N sin(2π {FREQUENCY_5:g} Hz t); "
        f"{data.tendons[1].caption()} below, F_c = 0 above; F_c chosen, not fitted. "
        "Band: the 0.5 mm below which the paper sees "
        "its departure; inset: the same corner, closed form and plugin. F_c leaves the slopes and "
        f"moves T_out over ξ_in by {departure.travel_pulling:+.2f} N (pulling), "
        f"{departure.travel_loosening:+.2f} N (loosening) and over T_in by "
        f"{departure.tension_pulling:+.2f} N, {departure.tension_loosening:+.2f} N, everywhere on "
        f"the branches. The distance of the two lines grows by {widening} from slack. Only the "
        f"lower flat is confined to the band. T_out of all routes within {max(data.largest):.2%} "
        "of range."
    )


def draw_shift(data: Figure4bc) -> Figure:
    """Draw the shift over n without inertia, and over the time step with it."""
    with print_style():
        figure = new_figure(8.2, 4.2)
        left, right = figure.subplots(1, 2)
        left.loglog(data.guides, 100 * data.one_guide, ":", color=BLACK, label="one guide at μ_s")
        left.loglog(data.guides, 100 * data.quasi_static, "o-", color=BLUE, label="sheath alone")
        left.set(xlabel="guides n", ylabel="shift [% of range]", title="No inertia")
        left.set_xticks(data.guides, [f"{n:g}" for n in data.guides])
        left.minorticks_off()
        left.legend()
        for shift, (colour, mark) in zip(
            data.shifts,
            ((VERMILLION, "o"), (ORANGE, "s"), (BLUE, "o"), (SKY, "s")),
            strict=True,
        ):
            steps = 1e6 * np.array(shift.dynamics.steps)
            mean = 100 * shift.largest.mean(1)
            reach = 100 * np.array([shift.largest.min(1), shift.largest.max(1)])
            right.errorbar(
                steps,
                mean,
                np.abs(reach - mean),
                color=colour,
                marker=mark,
                capsize=3,
                label=f"{shift.dynamics.name}, {shift.frequency:g} Hz",
            )
        right.set_xscale("log")
        right.set(xlabel="time step h [µs]", ylabel="shift [% of range]", title="With inertia")
        right.set_ylim(bottom=0.0)
        right.set_xticks([2, 5, 10, 20, 40], ["2", "5", "10", "20", "40"])
        right.minorticks_off()
        right.legend(ncols=2, loc="upper left")
        right.set_ylim(top=1.25 * right.get_ylim()[1])
        caption_below(
            figure,
            "Shift: T_out with μ_s = 0.3 less T_out with μ_s = μ_d = 0.1, largest in a period, "
            "over the range. Right: mean over three periods after the start, with bars from least "
            "to most; heavy elements at 0.5 Hz do not converge. "
            + "; ".join(
                f"{d.name}: n = {d.elements}, {d.mass:g} kg, {d.damping:g} N s/m"
                for d in (data.shifts[0].dynamics, data.shifts[1].dynamics)
            )
            + ".",
        )
    return figure


def draw_figures(reproduction: Reproduction) -> Iterator[tuple[str, Figure]]:
    """Yield each picture's name and figure."""
    slow, fast = reproduction.figure_4bc.loops
    drawings: dict[str, Callable[[], Figure]] = {
        "agreement": lambda: draw_agreement(reproduction.agreement),
        "refinement": lambda: draw_refinement(reproduction.refinement),
        "figure_4a": lambda: draw_figure_4a(reproduction.figure_4a),
        "figure_4b": lambda: draw_figure_4bc(reproduction.figure_4bc, slow, "b"),
        "figure_4c": lambda: draw_figure_4bc(reproduction.figure_4bc, fast, "c"),
        "stiction": lambda: draw_shift(reproduction.figure_4bc),
        "figure_5": lambda: draw_figure_5(reproduction.figure_5),
        "cost": lambda: draw_costs(reproduction.costs),
    }
    for name, draw in drawings.items():
        yield name, draw()
