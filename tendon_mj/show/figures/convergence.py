"""Error over the number of guides, beside a line of the expected order."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator
from numpy.typing import ArrayLike

from tendon_mj.show.figures.style import BLUE, GREY, legend_below, new_figure, print_style

ORDER = 2  # of the trapezoidal rule, which a row of guides with half end segments is


def convergence_figure(guides: ArrayLike, error: ArrayLike, order: float) -> Figure:
    """Draw the error of K_ap over the guides on logarithmic axes, beside a line of order 2.

    Args:
        guides: (k,) numbers of guides.
        error: (k,) |K_ap/K_ap(finest) − 1|, each > 0 [-].
        order: fitted p of error ∝ guides^−p [-].

    Returns:
        A figure of one panel.
    """
    count, off = np.asarray(guides, float), np.asarray(error, float)
    with print_style():
        figure = new_figure(4.6, 4.0)
        axes = figure.subplots()
        axes.loglog(count, off, "o", color=BLUE, label=f"MuJoCo, fitted order {order:.2f}")
        line = off[-1] * (count / count[-1]) ** -ORDER
        axes.loglog(count, line, "--", color=GREY, label=f"order {ORDER}")
        # a triangle under the line, one octave wide
        middle = float(np.sqrt(count[0] * count[-1]))
        x = np.array([middle, 2.0 * middle])
        y = 0.45 * off[-1] * (x / count[-1]) ** -ORDER
        axes.loglog([x[0], x[0], x[1], x[0]], [y[0], y[1], y[1], y[0]], "-", color=GREY)
        axes.annotate(
            f"{ORDER}",
            (x[0], float(np.sqrt(y[0] * y[1]))),
            xytext=(-4, 0),
            textcoords="offset points",
            ha="right",
            va="center",
            color=GREY,
        )
        axes.annotate(
            "1",
            (float(np.sqrt(x[0] * x[1])), y[1]),
            xytext=(0, -3),
            textcoords="offset points",
            ha="center",
            va="top",
            color=GREY,
        )
        axes.set_xticks(count, [f"{n:g}" for n in count])
        axes.xaxis.set_minor_locator(NullLocator())
        axes.set_xlabel("guides $n$ [–]")
        axes.set_ylabel(
            "error of the apparent stiffness,\n$|K_{ap}/K_{ap}(\\mathrm{finest})-1|$ [–]"
        )
        legend_below(figure, axes, columns=2)
    return figure
