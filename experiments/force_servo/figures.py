"""Figures of the servo: steps of Fig. 7, limit cycles, strategies compared."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.force_servo.limit_cycle import VARIED, Cycles
from experiments.force_servo.steps import Staircase
from experiments.force_servo.study import Steps
from experiments.force_servo.tracking import Tracking
from tendon_mj.view.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    SERIES,
    VERMILLION,
    legend_below,
    new_figure,
    print_style,
)

_THIN = 20  # of the samples drawn, one in so many


def staircase_figure(found: Staircase) -> Figure:
    """Draw T_out over time for the six steps, with G_v as in the paper and critical for pulling."""
    with print_style():
        figure = new_figure(8.0, 5.2)
        upper, lower = figure.subplots(2, 1, sharex=True)
        for axes, servo, response in (
            (upper, found.paper, found.paper_response),
            (lower, found.critical, found.critical_response),
        ):
            time, floor = response.time[::_THIN], found.bench.pretension
            axes.plot(
                time,
                response.reference[::_THIN] - floor,
                color=GREY,
                linestyle="--",
                label="reference $T_r$",
            )
            axes.plot(
                time,
                response.output_tension[::_THIN] - floor,
                color=BLUE,
                label="output tension $T_\\mathrm{out}$",
            )
            for k, share in enumerate(found.overshoots(response)):
                level = response.reference[round((k + 1.5) * found.time / found.bench.timestep)]
                axes.annotate(
                    f"{share:.1%}",
                    ((k + 1.55) * found.time, level - floor),
                    xytext=(0, 5 if k < 3 else -12),
                    textcoords="offset points",
                    ha="center",
                    fontsize=8,
                    color=GREY,
                )
            axes.set_title(
                f"$G_t$ = {servo.tension_gain:.1f}, $G_v$ = {servo.velocity_gain:.2f} N m s/rad, "
                f"$J_m$ = {servo.inertia:g} kg m², $r$ = {1e3 * servo.radius:g} mm, "
                f"$\\lambda$ = {found.bench.exponent:.2g} (in grey: overshoot)"
            )
            axes.set_ylabel("tension above $T_0$ [N]")
            axes.set_ylim(-9.0, 69.0)
        lower.set_xlabel("time $t$ [s]")
        legend_below(figure, upper, columns=2)
    return figure


def cycles_figure(found: Cycles) -> Figure:
    """Draw amplitude over ξ_B for every case, the line through them and the prediction."""
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


def strategies_figure(steps: Steps, tracking: Tracking) -> Figure:
    """Draw a loosening step with and without scheduled gains, a tracked sine, and all errors."""
    with print_style():
        figure = new_figure(8.6, 6.4)
        upper, lower = figure.subfigures(2, 1, height_ratios=(1.0, 1.2))  # type: ignore[misc]
        step, error = upper.subplots(1, 2)
        sine, bars = lower.subplots(1, 2)
        _draw_step(step, error, steps)
        _draw_sine(sine, tracking)
        _draw_errors(bars, tracking)
    return figure


def _draw_step(whole: Axes, close: Axes, steps: Steps) -> None:
    for label, runs, colour, style in (
        ("plain", steps.plain_steps, VERMILLION, "--"),
        ("scheduled", steps.scheduled_steps, BLUE, "-"),
    ):
        for axes in (whole, close):
            for way, found in (("pulling", runs[2]), ("loosening", runs[3])):
                seen = found.response
                height = seen.reference[-1] - seen.output_tension[0]
                share = (seen.output_tension - seen.output_tension[0]) / height
                axes.plot(
                    (seen.time - seen.time[0])[::_THIN],
                    100.0 * share[::_THIN],
                    color=colour,
                    linestyle=style,
                    linewidth=1.6 if way == "loosening" else 0.8,
                    label=f"{label}, {way}",
                )
    whole.set(title="step after a reversal", xlabel="time $t$ [s]", ylabel="share of the step [%]")
    whole.legend()
    close.set(title="the same, at its end", xlabel="time $t$ [s]", ylabel="share of the step [%]")
    top = 100.0 * (1.0 + max(found.overshoot for found in steps.plain_steps))
    close.set_ylim(97.0 if top < 102.0 else 90.0, top + 0.5)


def _draw_sine(axes: Axes, tracking: Tracking) -> None:
    part = slice(None, None, _THIN)
    axes.plot(
        tracking.time[part], tracking.reference[part], color=BLACK, linewidth=3.0, alpha=0.25,
        label="reference",
    )  # fmt: skip
    axes.plot(
        tracking.time[part], tracking.frictionless[part], color=VERMILLION, linestyle="-.",
        label="frictionless inverse",
    )  # fmt: skip
    for name, label, colour, style in (
        ("plain", "plain servo", GREEN, "--"),
        ("feedforward", "servo with feed-forward", BLUE, "-"),
    ):
        output = tracking.responses[name].output_tension
        axes.plot(tracking.time[part], output[part], color=colour, linestyle=style, label=label)
    axes.set_xlim(tracking.time[-1] * 0.4, tracking.time[-1])
    axes.set(title="sine", xlabel="time $t$ [s]", ylabel="output tension $T_\\mathrm{out}$ [N]")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.22), ncols=2)


def _draw_errors(axes: Axes, tracking: Tracking) -> None:
    names = list(tracking.rmse)
    values = [tracking.rmse[name] for name in names]
    place = np.arange(len(names))[::-1]
    colours = [VERMILLION if name == "frictionless" else BLUE for name in names]
    axes.barh(place, values, color=colours)
    for y, name, value in zip(place, names, values, strict=True):
        cut = (
            ""
            if name == "frictionless"
            else f" ({-tracking.reduction(name):+.0%})".replace("-", "−")
        )
        axes.text(value, float(y), f" {value:.2f}{cut}", va="center", fontsize=7.5)
    words = [
        name.replace("_friction_high", ", $\\mu$ +20 %")
        .replace("_friction_low", ", $\\mu$ −20 %")
        .replace("_", ", ")
        for name in names
    ]
    axes.set_yticks(place, words, fontsize=7.5)
    axes.set_xlim(0.0, 1.5 * max(values))
    axes.grid(False, axis="y")
    axes.set(title="root mean square error", xlabel="of $T_\\mathrm{out}$ [N]")
