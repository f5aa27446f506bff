"""Loops of the bench: what went in against what came out, with the closed form's lines."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from tendon_mj import theory
from tendon_mj.builders.bench import Bench
from tendon_mj.verification.first_motion import Loop
from tendon_mj.view.figures.style import (
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


def bench_loops_figure(bench: Bench, loop: Loop) -> Figure:
    """``loops_figure`` of what a bench's sensors showed."""
    return loops_figure(
        input_tension=loop.input_tension,
        output_tension=loop.output_tension,
        reel_displacement=loop.reel_displacement,
        exponent=bench.exponent,
        pretension=bench.pretension,
        axial_stiffness=bench.axial_stiffness,
        length=bench.length,
        output_stiffness=bench.output_stiffness,
    )


def loops_figure(
    *,
    input_tension: ArrayLike,
    output_tension: ArrayLike,
    reel_displacement: ArrayLike,
    exponent: float,
    pretension: float,
    axial_stiffness: float,
    length: float,
    output_stiffness: float,
    source: str = "MuJoCo with the plugin",
) -> Figure:
    """Draw T_out over T_in and over ξ_in, with the branches that the closed form allows.

    Left T_out = T_in e^{∓|λ|}; right T_out − T_0 = K_t(±|λ|) (ξ_in − ξ_B(±|λ|)); in both the line
    without friction, of slope 1 and K_t(0).

    Args:
        input_tension, output_tension: (n,) T_in and T_out [N].
        reel_displacement: (n,) ξ_in [m].
        exponent: |λ| [-].
        pretension: T_0 [N].
        axial_stiffness: EA [N].
        length: L [m].
        output_stiffness: k_se, of environment and sensor in series [N/m].
        source: what made the loops.

    Returns:
        A figure of two panels.
    """
    went_in, came_out = np.asarray(input_tension, float), np.asarray(output_tension, float)
    wound = np.asarray(reel_displacement, float)
    with print_style():
        figure = new_figure(8.0, 4.3)
        left, right = figure.subplots(1, 2)
        left.plot(went_in, came_out, color=SKY, linewidth=3.0, label=source)
        right.plot(1e3 * wound, came_out, color=SKY, linewidth=3.0)
        span = _span(came_out)
        for sign, label, colour, style in _DIRECTIONS:
            lam = sign * abs(exponent)
            _line(left, span * np.exp(lam), span, f"closed form, {label}", colour, style)
            stiffness, backlash = _branch(
                lam, pretension, axial_stiffness, length, output_stiffness
            )
            xi = backlash + (span - pretension) / stiffness
            _line(right, 1e3 * xi, span, f"_{label}", colour, style)
            right.plot(1e3 * backlash, pretension, "o", color=colour, markerfacecolor="white")
            _name_backlash(right, 1e3 * backlash, pretension, sign, colour)
        _line(left, span, span, "closed form, no friction", GREY, ":")
        stiffness, _ = _branch(0.0, pretension, axial_stiffness, length, output_stiffness)
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


def _branch(
    lam: float, pretension: float, axial_stiffness: float, length: float, output_stiffness: float
) -> tuple[float, float]:
    """K_t [N/m] and ξ_B [m]."""
    stiffness = theory.transmission_stiffness(lam, axial_stiffness, length, output_stiffness)
    backlash = theory.equivalent_backlash(lam, pretension, axial_stiffness, length)
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
