"""First motions in both directions: stiffness and backlash over λ, and how far off they are."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from tendon_mj import theory
from tendon_mj.view.figures.style import (
    BLACK,
    BLUE,
    GREY,
    VERMILLION,
    legend_below,
    new_figure,
    print_style,
)

Array = NDArray[np.float64]
_KINDS = ((1.0, "pulling", BLUE, "o"), (-1.0, "loosening", VERMILLION, "s"))


def sweep_figure(
    *,
    exponent: ArrayLike,
    apparent_stiffness: ArrayLike,
    analytic_stiffness: ArrayLike,
    backlash: ArrayLike,
    analytic_backlash: ArrayLike,
    backlash_error: ArrayLike,
    title: str = "",
) -> Figure:
    """Draw K_ap/K_w and ξ_B over λ with their closed form, and below the errors of both.

    Args:
        exponent: (n,) λ with its sign, none 0 [-].
        apparent_stiffness, analytic_stiffness: (n,) K_ap [N/m].
        backlash, analytic_backlash: (n,) ξ_B [m].
        backlash_error: (n,) their difference over T_in L/EA [-].
        title: of the figure.

    Returns:
        A figure of two by two panels.
    """
    lam = np.asarray(exponent, float)
    measured, analytic = (
        np.asarray(apparent_stiffness, float),
        np.asarray(analytic_stiffness, float),
    )
    tendon = float(np.median(analytic / theory.apparent_stiffness(lam, 1.0, 1.0)))
    free = float(np.median(np.asarray(analytic_backlash, float) / _unit_backlash(lam)))
    fine = np.linspace(min(lam.min(), 0.0), max(lam.max(), 0.0), 301)
    with print_style():
        figure = new_figure(8.0, 5.6)
        if title:
            figure.suptitle(title)
        grid = figure.subplots(2, 2, sharex=True, height_ratios=(1.6, 1.0))
        (stiffness, lost), (stiffness_error, lost_error) = grid
        curve = theory.apparent_stiffness(fine, 1.0, 1.0)
        stiffness.plot(fine, curve, color=BLACK, label="closed form")
        lost.plot(fine, 1e6 * free * _unit_backlash(fine), color=BLACK)
        for axes, values, named in (
            (stiffness, measured / tendon, True),
            (lost, 1e6 * np.asarray(backlash, float), False),
            (stiffness_error, 100.0 * (measured / analytic - 1.0), False),
            (lost_error, 100.0 * np.asarray(backlash_error, float), False),
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


def _unit_backlash(lam: Array) -> Array:
    return np.asarray(theory.equivalent_backlash(lam, 1.0, 1.0, 1.0))


def _draw_points(axes: Axes, lam: Array, values: Array, named: bool) -> None:
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
