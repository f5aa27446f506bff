"""Figures of the bench with the closed form: loops, first motions, convergence; bars of costs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator
from numpy.typing import ArrayLike

from tendon_mj import theory
from tendon_mj.lab.bench_comparison import BenchReadings, FirstMotion
from tendon_mj.models import Bench
from tendon_mj.show import style
from tendon_mj.typing import FloatArray

_MARGIN = 0.06  # of the data's span, by which lines run on
_DIRECTIONS = (
    (1, "pulling, $+|\\lambda|$", style.BLUE, "--"),
    (-1, "loosening, $-|\\lambda|$", style.VERMILLION, "-."),
)
_KINDS = ((1.0, "pulling", style.BLUE, "o"), (-1.0, "loosening", style.VERMILLION, "s"))
ORDER = 2  # of the trapezoidal rule, which a row of guides with half end segments is


def loops_figure(bench: Bench, readings: BenchReadings) -> Figure:
    """Draw T_out over T_in and over ξ_in, with the branches that the closed form allows.

    Left T_out = T_in e^{∓|λ|}; right T_out − T_0 = K_t(±|λ|) (ξ_in − ξ_B(±|λ|)); in both the line
    without friction, of slope 1 and K_t(0).
    """
    went_in, came_out = readings.input_tension, readings.output_tension
    wound, pretension = readings.reel_displacement, bench.pretension
    with style.print_style():
        figure = style.new_figure(8.0, 4.3)
        left, right = figure.subplots(1, 2)
        left.plot(went_in, came_out, color=style.SKY, linewidth=3.0, label="MuJoCo with the plugin")
        right.plot(1e3 * wound, came_out, color=style.SKY, linewidth=3.0)
        span = _padded_span(came_out)
        for sign, label, colour, dashes in _DIRECTIONS:
            lam = sign * bench.exponent
            _line(left, span * np.exp(lam), span, f"closed form, {label}", colour, dashes)
            stiffness, backlash = _branch(lam, bench)
            xi = backlash + (span - pretension) / stiffness
            _line(right, 1e3 * xi, span, f"_{label}", colour, dashes)
            right.plot(1e3 * backlash, pretension, "o", color=colour, markerfacecolor="white")
            name = f"$\\xi_B({'+' if sign > 0 else '-'}|\\lambda|)$"
            place, offset = (1e3 * backlash, pretension), (sign * 8, -sign * 4)
            aligned = ("left", "top") if sign > 0 else ("right", "bottom")
            _annotate(right, name, place, offset, *aligned, colour)
        _line(left, span, span, "closed form, no friction", style.GREY, ":")
        stiffness, _ = _branch(0.0, bench)
        _line(right, 1e3 * (span - pretension) / stiffness, span, "_free", style.GREY, ":")
        left.plot(pretension, pretension, "o", color=style.BLACK, label="start, $T_0$")
        right.plot(0.0, pretension, "o", color=style.BLACK)
        left.set_title("tension: slopes $e^{\\mp|\\lambda|}$")
        left.set_xlabel("input tension $T_\\mathrm{in}$ [N]")
        right.set_title("displacement: slopes $K_t(\\pm|\\lambda|)$")
        right.set_xlabel("reel displacement $\\xi_\\mathrm{in}$ [mm]")
        for axes, values in ((left, went_in), (right, 1e3 * wound)):
            axes.set_xlim(*_padded_span(values))
            axes.set_ylim(*span)
            axes.set_ylabel("output tension $T_\\mathrm{out}$ [N]")
        style.legend_below(figure, left, columns=3)
    return figure


def _branch(lam: float, bench: Bench) -> tuple[float, float]:
    """K_t [N/m] and ξ_B [m]."""
    ea, length = bench.axial_stiffness, bench.length
    stiffness = theory.transmission_stiffness(lam, ea, length, bench.output_stiffness)
    backlash = theory.equivalent_backlash(lam, bench.pretension, ea, length)
    return float(stiffness), float(backlash)


def _padded_span(values: FloatArray) -> FloatArray:
    low, high = float(values.min()), float(values.max())
    margin = _MARGIN * (high - low) or 1.0
    return np.array([low - margin, high + margin])


def _line(axes: Axes, x: FloatArray, y: FloatArray, label: str, colour: str, dashes: str) -> None:
    axes.plot(x, y, color=colour, linestyle=dashes, linewidth=1.3, label=label)


def _annotate(
    axes: Axes,
    text: str,
    place: tuple[float, float],
    offset: tuple[float, float],
    ha: str,
    va: str,
    colour: str = style.GREY,
) -> None:
    """Write a text at an offset [points] from a place."""
    look: dict[str, Any] = {"textcoords": "offset points", "ha": ha, "va": va, "color": colour}
    axes.annotate(text, place, xytext=offset, **look)


def sweep_figure(motions: Sequence[FirstMotion]) -> Figure:
    """Draw K_ap/K_w and ξ_B over λ, never 0, with their closed form, and below the errors."""
    ordered = sorted(motions, key=lambda motion: motion.exponent)
    lam = np.array([m.exponent for m in ordered])
    measured = np.array([m.apparent_stiffness for m in ordered])
    analytic = np.array([m.analytic_stiffness for m in ordered])
    analytic_backlash = np.array([m.analytic_backlash for m in ordered])
    tendon = float(np.median(analytic / theory.apparent_stiffness(lam, 1.0, 1.0)))
    free = float(np.median(analytic_backlash / _unit_backlash(lam)))
    fine = np.linspace(min(lam.min(), 0.0), max(lam.max(), 0.0), 301)
    with style.print_style():
        figure = style.new_figure(8.0, 5.6)
        grid = figure.subplots(2, 2, sharex=True, height_ratios=(1.6, 1.0))
        (stiffness, lost), (stiffness_error, lost_error) = grid
        curve = theory.apparent_stiffness(fine, 1.0, 1.0)
        stiffness.plot(fine, curve, color=style.BLACK, label="closed form")
        lost.plot(fine, 1e6 * free * _unit_backlash(fine), color=style.BLACK)
        for axes, values, named in (
            (stiffness, measured / tendon, True),
            (lost, 1e6 * np.array([m.backlash for m in ordered]), False),
            (stiffness_error, 100.0 * (measured / analytic - 1.0), False),
            (lost_error, 100.0 * np.array([m.backlash_error for m in ordered]), False),
        ):
            for sign, kind, colour, marker in _KINDS:
                chosen, label = np.sign(lam) == sign, f"MuJoCo, {kind}" if named else None
                look: dict[str, Any] = {"markerfacecolor": "none", "markeredgewidth": 1.3}
                axes.plot(lam[chosen], values[chosen], marker, color=colour, label=label, **look)
        for axes in (stiffness_error, lost_error):
            axes.axhline(0.0, color=style.GREY, linewidth=0.9)
            axes.set_xlabel("friction exponent $\\lambda$ [–]")
        stiffness.set(title="apparent stiffness", ylabel="$K_{ap}/K_w$ [–]")
        lost.set(title="equivalent backlash", ylabel="$\\xi_B$ [µm]")
        stiffness_error.set_ylabel("error [% of $K_{ap}$]")
        lost_error.set_ylabel("error [% of $T_\\mathrm{in}L/EA$]")
        style.legend_below(figure, stiffness, columns=3)
    return figure


def _unit_backlash(lam: FloatArray) -> FloatArray:
    return np.asarray(theory.equivalent_backlash(lam, 1.0, 1.0, 1.0))


def convergence_figure(guides: ArrayLike, error: ArrayLike, order: float) -> Figure:
    """Draw the (k,) errors |K_ap/K_ap(finest) − 1| over the guides, with a line of order 2.

    ``order`` is the fitted p of error ∝ guides^−p.
    """
    count, off = np.asarray(guides, float), np.asarray(error, float)
    with style.print_style():
        figure = style.new_figure(4.6, 4.0)
        axes = figure.subplots()
        axes.loglog(count, off, "o", color=style.BLUE, label=f"MuJoCo, fitted order {order:.2f}")
        line = off[-1] * (count / count[-1]) ** -ORDER
        axes.loglog(count, line, "--", color=style.GREY, label=f"order {ORDER}")
        # a triangle under the line, one octave wide
        middle = float(np.sqrt(count[0] * count[-1]))
        x = np.array([middle, 2.0 * middle])
        y = 0.45 * off[-1] * (x / count[-1]) ** -ORDER
        axes.loglog([x[0], x[0], x[1], x[0]], [y[0], y[1], y[1], y[0]], "-", color=style.GREY)
        _annotate(axes, f"{ORDER}", (x[0], float(np.sqrt(y[0] * y[1]))), (-4, 0), "right", "center")
        _annotate(axes, "1", (float(np.sqrt(x[0] * x[1])), y[1]), (0, -3), "center", "top")
        axes.set_xticks(count, [f"{n:g}" for n in count])
        axes.xaxis.set_minor_locator(NullLocator())
        axes.set_xlabel("guides $n$ [–]")
        error_label = "$|K_{ap}/K_{ap}(\\mathrm{finest})-1|$ [–]"
        axes.set_ylabel(f"error of the apparent stiffness,\n{error_label}")
        style.legend_below(figure, axes, columns=2)
    return figure


def bars_figure(
    spreads: Mapping[str, Sequence[float]],
    text: str,
    *,
    title: str,
    label: str,
    reference: tuple[float, str] | None = None,
) -> Figure:
    """Draw a bar for each (low quartile, median, high quartile), with its value in format ``text``.

    The reference is a value to mark by a line, and its name.
    """
    low, median, high = np.array([list(spread) for spread in spreads.values()]).T
    rows = np.arange(len(spreads))
    with style.print_style():
        figure = style.new_figure(5.2, 1.4 + 0.34 * len(spreads))
        axes = figure.subplots()
        look: dict[str, Any] = {"ecolor": style.BLACK, "elinewidth": 1.0, "capsize": 2.0}
        errors = [median - low, high - median]
        bars = axes.barh(rows, median, 0.7, color=style.BLUE, xerr=errors, error_kw=look)
        axes.bar_label(bars, [text.format(value) for value in median], padding=5, fontsize=8.0)
        axes.set_xlim(min(0.0, 1.1 * float(low.min())), 1.3 * float(high.max()))
        axes.set_yticks(rows, list(spreads))
        axes.invert_yaxis()
        axes.grid(visible=False, axis="y")
        axes.set(title=title, xlabel=label)
        if reference:
            value, name = reference
            axes.axvline(value, color=style.BLACK, linestyle=":", linewidth=1.3, label=name)
            style.legend_below(figure, axes, columns=1)
    return figure
