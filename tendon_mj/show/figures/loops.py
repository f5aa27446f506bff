"""Loops of the bench: output tension over input tension and displacement, with the closed form."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tendon_mj import theory
from tendon_mj.lab.verification import BenchReadings
from tendon_mj.models import Bench
from tendon_mj.show.figures.style import (
    BLACK,
    BLUE,
    GREY,
    SKY,
    VERMILLION,
    legend_below,
    new_figure,
    print_style,
)

_MARGIN = 0.06  # of the data's span, by which lines run on
_DIRECTIONS = (
    (1, "pulling, $+|\\lambda|$", BLUE, "--"),
    (-1, "loosening, $-|\\lambda|$", VERMILLION, "-."),
)


def loops_figure(bench: Bench, readings: BenchReadings) -> Figure:
    """Draw T_out over T_in and over ξ_in, with the branches that the closed form allows.

    Left T_out = T_in e^{∓|λ|}; right T_out − T_0 = K_t(±|λ|) (ξ_in − ξ_B(±|λ|)); in both the line
    without friction, of slope 1 and K_t(0).

    Args:
        bench: parameters, for the closed form.
        readings: T_in, T_out and ξ_in of the loops.

    Returns:
        A figure of two panels.
    """
    went_in, came_out = readings.input_tension, readings.output_tension
    wound, pretension = readings.reel_displacement, bench.pretension
    with print_style():
        figure = new_figure(8.0, 4.3)
        left, right = figure.subplots(1, 2)
        left.plot(went_in, came_out, color=SKY, linewidth=3.0, label="MuJoCo with the plugin")
        right.plot(1e3 * wound, came_out, color=SKY, linewidth=3.0)
        span = _span(came_out)
        for sign, label, colour, style in _DIRECTIONS:
            lam = sign * bench.exponent
            _line(left, span * np.exp(lam), span, f"closed form, {label}", colour, style)
            stiffness, backlash = _branch(lam, bench)
            xi = backlash + (span - pretension) / stiffness
            _line(right, 1e3 * xi, span, f"_{label}", colour, style)
            right.plot(1e3 * backlash, pretension, "o", color=colour, markerfacecolor="white")
            _name_backlash(right, 1e3 * backlash, pretension, sign, colour)
        _line(left, span, span, "closed form, no friction", GREY, ":")
        stiffness, _ = _branch(0.0, bench)
        _line(right, 1e3 * (span - pretension) / stiffness, span, "_free", GREY, ":")
        left.plot(pretension, pretension, "o", color=BLACK, label="start, $T_0$")
        right.plot(0.0, pretension, "o", color=BLACK)
        left.set(
            title="tension: slopes $e^{\\mp|\\lambda|}$",
            xlabel="input tension $T_\\mathrm{in}$ [N]",
        )
        right.set(
            title="displacement: slopes $K_t(\\pm|\\lambda|)$",
            xlabel="reel displacement $\\xi_\\mathrm{in}$ [mm]",
        )
        for axes, values in ((left, went_in), (right, 1e3 * wound)):
            axes.set_xlim(*_span(values))
            axes.set_ylim(*span)
            axes.set_ylabel("output tension $T_\\mathrm{out}$ [N]")
        legend_below(figure, left, columns=3)
    return figure


def _branch(lam: float, bench: Bench) -> tuple[float, float]:
    """K_t [N/m] and ξ_B [m]."""
    ea, length = bench.axial_stiffness, bench.length
    stiffness = theory.transmission_stiffness(lam, ea, length, bench.output_stiffness)
    backlash = theory.equivalent_backlash(lam, bench.pretension, ea, length)
    return float(stiffness), float(backlash)


def _span(values: NDArray[np.float64]) -> NDArray[np.float64]:
    low, high = float(values.min()), float(values.max())
    margin = _MARGIN * (high - low) or 1.0
    return np.array([low - margin, high + margin])


def _line(
    axes: Axes,
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    label: str,
    colour: str,
    style: str,
) -> None:
    axes.plot(x, y, color=colour, linestyle=style, linewidth=1.3, label=label)


def _name_backlash(axes: Axes, x: float, y: float, sign: int, colour: str) -> None:
    axes.annotate(
        f"$\\xi_B({'+' if sign > 0 else '-'}|\\lambda|)$",
        (x, y),
        xytext=(sign * 8, -sign * 4),
        textcoords="offset points",
        ha="left" if sign > 0 else "right",
        va="top" if sign > 0 else "bottom",
        color=colour,
    )
