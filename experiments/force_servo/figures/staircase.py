"""Figure of the six steps (Fig. 7 of the paper)."""

from __future__ import annotations

from matplotlib.figure import Figure

from experiments.force_servo.staircase import Staircase
from tendon_mj.show import BLUE, GREY, legend_below, new_figure, print_style

_THIN = 20  # every so many samples are drawn


def draw_staircase(found: Staircase) -> Figure:
    """Draw T_out over time for the six steps, with G_v as in the paper and critical for pulling."""
    with print_style():
        figure = new_figure(8.0, 5.2)
        upper, lower = figure.subplots(2, 1, sharex=True)
        for axes, gains, servo, response in (
            (upper, "paper's gains", found.paper, found.paper_response),
            (lower, "critical for pulling", found.critical, found.critical_response),
        ):
            time, pretension = response.time[::_THIN], found.bench.pretension
            axes.plot(
                time,
                response.reference[::_THIN] - pretension,
                color=GREY,
                linestyle="--",
                label="reference $T_r$",
            )
            axes.plot(
                time,
                response.output_tension[::_THIN] - pretension,
                color=BLUE,
                label="output tension $T_\\mathrm{out}$",
            )
            for k, share in enumerate(found.overshoots(response)):
                level = response.reference[round((k + 1.5) * found.time / found.bench.timestep)]
                axes.annotate(
                    f"{share:.1%}",
                    ((k + 1.55) * found.time, level - pretension),
                    xytext=(0, 5 if k < 3 else -12),
                    textcoords="offset points",
                    ha="center",
                    fontsize=8,
                    color=GREY,
                )
            axes.set_title(
                f"{gains}: $G_t$ = {servo.tension_gain:.1f}, "
                f"$G_v$ = {servo.velocity_gain:.2f} N m s/rad, $J_m$ = {servo.inertia:g} kg m², "
                f"$r$ = {1e3 * servo.radius:g} mm, $\\lambda$ = {found.bench.exponent:.2g}"
            )
            axes.set_ylabel("tension above $T_0$ [N]")
            axes.set_ylim(-9.0, 69.0)
        upper.plot([], [], " ", label="in grey: overshoot over the step")
        lower.set_xlabel("time $t$ [s]")
        legend_below(figure, upper, columns=3)
    return figure
