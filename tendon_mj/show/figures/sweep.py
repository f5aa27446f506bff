"""First motions in both directions: stiffness and backlash over λ, and their errors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tendon_mj import theory
from tendon_mj.lab.verification import FirstMotion
from tendon_mj.show.figures.style import (
    BLACK,
    BLUE,
    GREY,
    VERMILLION,
    legend_below,
    new_figure,
    print_style,
)
from tendon_mj.typing import FloatArray

_KINDS = ((1.0, "pulling", BLUE, "o"), (-1.0, "loosening", VERMILLION, "s"))


def sweep_figure(motions: Sequence[FirstMotion]) -> Figure:
    """Draw K_ap/K_w and ξ_B over λ with their closed form, and below the errors of both.

    Args:
        motions: first motions in both directions, at any λ but 0.

    Returns:
        A figure of two by two panels.
    """
    ordered = sorted(motions, key=lambda motion: motion.exponent)
    lam = np.array([m.exponent for m in ordered])
    measured = np.array([m.apparent_stiffness for m in ordered])
    analytic = np.array([m.analytic_stiffness for m in ordered])
    analytic_backlash = np.array([m.analytic_backlash for m in ordered])
    tendon = float(np.median(analytic / theory.apparent_stiffness(lam, 1.0, 1.0)))
    free = float(np.median(analytic_backlash / _unit_backlash(lam)))
    fine = np.linspace(min(lam.min(), 0.0), max(lam.max(), 0.0), 301)
    with print_style():
        figure = new_figure(8.0, 5.6)
        grid = figure.subplots(2, 2, sharex=True, height_ratios=(1.6, 1.0))
        (stiffness, lost), (stiffness_error, lost_error) = grid
        curve = theory.apparent_stiffness(fine, 1.0, 1.0)
        stiffness.plot(fine, curve, color=BLACK, label="closed form")
        lost.plot(fine, 1e6 * free * _unit_backlash(fine), color=BLACK)
        for axes, values, named in (
            (stiffness, measured / tendon, True),
            (lost, 1e6 * np.array([m.backlash for m in ordered]), False),
            (stiffness_error, 100.0 * (measured / analytic - 1.0), False),
            (lost_error, 100.0 * np.array([m.backlash_error for m in ordered]), False),
        ):
            _draw_points(axes, lam, values, named)
        for axes in (stiffness_error, lost_error):
            axes.axhline(0.0, color=GREY, linewidth=0.9)
            axes.set_xlabel("friction exponent $\\lambda$ [–]")
        stiffness.set(title="apparent stiffness", ylabel="$K_{ap}/K_w$ [–]")
        lost.set(title="equivalent backlash", ylabel="$\\xi_B$ [µm]")
        stiffness_error.set_ylabel("error [% of $K_{ap}$]")
        lost_error.set_ylabel("error [% of $T_\\mathrm{in}L/EA$]")
        legend_below(figure, stiffness, columns=3)
    return figure


def _unit_backlash(lam: FloatArray) -> FloatArray:
    return np.asarray(theory.equivalent_backlash(lam, 1.0, 1.0, 1.0))


def _draw_points(axes: Axes, lam: FloatArray, values: FloatArray, named: bool) -> None:
    for sign, label, colour, marker in _KINDS:
        chosen = np.sign(lam) == sign
        axes.plot(
            lam[chosen],
            values[chosen],
            linestyle="none",
            marker=marker,
            color=colour,
            markerfacecolor="none",
            markeredgewidth=1.3,
            label=f"MuJoCo, {label}" if named else None,
        )
