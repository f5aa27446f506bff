"""Figure of the limit cycles."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.force_servo.limit_cycle import VARIED, LimitCycles
from tendon_mj.show import BLACK, BLUE, SERIES, legend_below, new_figure, print_style


def draw_limit_cycles(found: LimitCycles) -> Figure:
    """Draw the amplitude over ξ_B for every case, the line through them and the prediction."""
    backlash, amplitude, predicted = found.columns()
    names = {"exponent": "$\\lambda$", "pretension": "$T_0$", "axial_stiffness": "$EA$"}
    with print_style():
        figure = new_figure(8.0, 4.2)
        left, right = figure.subplots(1, 2, width_ratios=(1.25, 1.0))
        for name, (colour, _, marker) in zip(VARIED, SERIES, strict=False):
            mine = np.array([c.varied == name for c in found.cycles])
            left.plot(
                1e3 * backlash[mine],
                1e3 * amplitude[mine],
                marker,
                color=colour,
                label=f"MuJoCo, {names[name]} varied",
            )
            left.plot(
                1e3 * backlash[mine],
                1e3 * predicted[mine],
                marker,
                color=colour,
                markerfacecolor="none",
                label=f"describing function, {names[name]} varied",
            )
        reach = np.array([0.0, 1.08 * backlash.max()])
        left.plot(
            1e3 * reach,
            1e3 * (found.factor * reach + found.intercept),
            color=BLACK,
            label=f"fit: {found.factor:.2f} $\\xi_B$ + {1e3 * found.intercept:.3f} mm, "
            f"$R^2$ = {found.r_squared:.4f}",
        )
        left.set(
            title="amplitude of the limit cycle",
            xlabel="equivalent backlash $\\xi_B$ [mm]",
            ylabel="amplitude of $\\xi_\\mathrm{in}$ [mm]",
        )
        left.set_xlim(left=0.0)
        left.set_ylim(bottom=0.0)
        cycle = max(found.cycles, key=lambda c: c.backlash)
        _draw_cycle(right, cycle.response.angle, cycle.response.output_tension)
        right.set_title(
            f"$\\lambda$ = {cycle.bench.exponent:.2g}, $T_0$ = {cycle.bench.pretension:g} N, "
            f"$EA$ = {cycle.bench.axial_stiffness / 1e3:g} kN"
        )
        legend_below(figure, left, columns=2)
    return figure


def _draw_cycle(axes: Axes, angle: np.ndarray, tension: np.ndarray) -> None:
    last = slice(-len(angle) // 2, None)
    axes.plot(angle[last], tension[last], color=BLUE)
    axes.set(xlabel="motor angle $\\theta$ [rad]", ylabel="output tension $T_\\mathrm{out}$ [N]")
