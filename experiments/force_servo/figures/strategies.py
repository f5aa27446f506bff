"""Figure of the strategies against friction: scheduled gains, and feed-forward on a sine."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.force_servo.gain_scheduling import GainScheduling
from experiments.force_servo.tracking import Tracking
from tendon_mj.show import BLACK, BLUE, GREEN, VERMILLION, new_figure, print_style

_THIN = 20  # every so many samples are drawn


def draw_strategies(gains: GainScheduling, tracking: Tracking) -> Figure:
    """Draw a loosening step with and without scheduled gains, a tracked sine, and all errors."""
    with print_style():
        figure = new_figure(8.6, 6.4)
        upper, lower = figure.subfigures(2, 1, height_ratios=(1.0, 1.2))  # type: ignore[misc]
        step, error = upper.subplots(1, 2)
        sine, bars = lower.subplots(1, 2)
        _draw_step(step, error, gains)
        _draw_sine(sine, tracking)
        _draw_errors(bars, tracking)
    return figure


def _draw_step(whole: Axes, close: Axes, gains: GainScheduling) -> None:
    for label, runs, colour, style in (
        ("plain", gains.plain_steps, VERMILLION, "--"),
        ("scheduled", gains.scheduled_steps, BLUE, "-"),
    ):
        for axes in (whole, close):
            for way, found in (("pulling", runs[2]), ("loosening", runs[3])):
                run = found.response
                height = run.reference[-1] - run.output_tension[0]
                share = (run.output_tension - run.output_tension[0]) / height
                axes.plot(
                    (run.time - run.time[0])[::_THIN],
                    100.0 * share[::_THIN],
                    color=colour,
                    linestyle=style,
                    linewidth=1.6 if way == "loosening" else 0.8,
                    label=f"{label}, {way}",
                )
    labels = {"xlabel": "time since the step [s]", "ylabel": "output tension [% of the step]"}
    whole.set(title="step after a reversal, output held", **labels)
    whole.legend()
    close.set(title="end of that step", **labels)
    top = 100.0 * (1.0 + max(found.overshoot for found in gains.plain_steps))
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
    axes.set(
        title="tracking of a sine",
        xlabel="time $t$ [s]",
        ylabel="output tension $T_\\mathrm{out}$ [N]",
    )
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
    axes.set(title="root mean square error", xlabel="error of $T_\\mathrm{out}$ [N]")
