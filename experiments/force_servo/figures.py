"""Pictures of the study: data in, figures out."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.force_servo.gain_scheduling import GainScheduling
from experiments.force_servo.limit_cycle import VARIED, LimitCycles
from experiments.force_servo.phase_plane import Nullcline, PhasePlane, output_is_held
from experiments.force_servo.servo_bench import ServoResponse
from experiments.force_servo.staircase import Staircase
from experiments.force_servo.study import Study
from experiments.force_servo.tracking import Tracking
from tendon_mj.show.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    SERIES,
    VERMILLION,
    legend_below,
    new_figure,
    print_style,
)

_PHASES_THIN, _THIN = 10, 20  # every so many samples are drawn


def draw_phase_plane(phase_plane: PhasePlane) -> Figure:
    """Draw θ̇ over θ: both lines ẋ₂ = 0, trajectories from below and above, and the backlash.

    Left with gains critical for pulling, right lightly damped, so that the motor turns back and
    crosses the backlash again and again.
    """
    with print_style():
        figure = new_figure(8.6, 4.6)
        left, right = figure.subplots(1, 2)
        up, down, up_back, down_back = phase_plane.trajectories
        for response, label, colour in (
            (up, "(I) from below", BLUE),
            (down, "(II) from above", VERMILLION),
        ):
            _draw(left, response, phase_plane.origin, colour, label)
        for response, label, colour in (
            (up_back, "(I) after a reversal", BLUE),
            (down_back, "(II) after a reversal", VERMILLION),
        ):
            _draw(left, response, phase_plane.origin, colour, label, "--")
            _draw_held(left, response, phase_plane.origin)
        for line in phase_plane.lines:
            _draw_line(left, line)
        left.set_title(
            f"critical for pulling, $G_v$ = {phase_plane.servo.velocity_gain:.2f} N m s/rad"
        )
        _draw(right, phase_plane.swing, phase_plane.origin, BLUE, "from below")
        _draw_held(right, phase_plane.swing, phase_plane.origin)
        right.set_title(
            f"$\\zeta$ = 0.2, $G_v$ = {phase_plane.swinging.velocity_gain:.2f} N m s/rad"
        )
        for axes in (left, right):
            axes.axhline(0.0, color=GREY, linewidth=0.8)
            axes.set(
                xlabel="$x_1 = \\theta - \\theta_{ref}$ [rad]",
                ylabel="$x_2 = \\dot\\theta$ [rad/s]",
            )
        legend_below(figure, left, columns=4)
    return figure


def _draw(
    axes: Axes, response: ServoResponse, origin: float, colour: str, label: str, style: str = "-"
) -> None:
    axes.plot(
        response.angle[::_PHASES_THIN] - origin,
        response.speed[::_PHASES_THIN],
        color=colour,
        linestyle=style,
        label=label,
    )


def _draw_held(axes: Axes, response: ServoResponse, origin: float) -> None:
    """Mark the samples at which the motor turns and the output tension does not change."""
    speed = np.where(output_is_held(response), response.speed, np.nan)
    axes.plot(
        response.angle[::_PHASES_THIN] - origin,
        speed[::_PHASES_THIN],
        color=ORANGE,
        linewidth=5.0,
        alpha=0.45,
        zorder=1,
        label=None if _has_backlash_label(axes) else "backlash: output held",
    )


def _has_backlash_label(axes: Axes) -> bool:
    return any("backlash" in str(line.get_label()) for line in axes.lines)


def _draw_line(axes: Axes, line: Nullcline) -> None:
    far = line.angle[np.argmax(np.abs(line.speed))]
    rest = line.angle + line.speed / line.analytic_slope  # where the line meets x₂ = 0
    angle = np.array([1.25 * (far - rest.mean()) + rest.mean(), rest.mean()])
    axes.plot(
        angle,
        -line.analytic_slope * (angle - rest.mean()),
        color=GREEN,
        linestyle=":" if line.direction > 0 else "-.",
        linewidth=1.8,
        label=f"$\\dot x_2 = 0$, {'pulling' if line.direction > 0 else 'loosening'}: "
        f"$\\omega/2\\zeta$ = {line.analytic_slope:.2f}/s",
    )
    axes.plot(
        line.angle,
        line.speed,
        "o",
        color=GREEN,
        markersize=3.5,
        label="_points",
    )


def draw_staircase(staircase: Staircase) -> Figure:
    """Draw T_out over time for the six steps, with G_v as in the paper and critical for pulling."""
    with print_style():
        figure = new_figure(8.0, 5.2)
        upper, lower = figure.subplots(2, 1, sharex=True)
        for axes, gains, servo, response in (
            (upper, "paper's gains", staircase.paper, staircase.paper_response),
            (lower, "critical for pulling", staircase.critical, staircase.critical_response),
        ):
            time, pretension = response.time[::_THIN], staircase.bench.pretension
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
            for k, share in enumerate(staircase.overshoots(response)):
                level = response.reference[
                    round((k + 1.5) * staircase.time / staircase.bench.timestep)
                ]
                axes.annotate(
                    f"{share:.1%}",
                    ((k + 1.55) * staircase.time, level - pretension),
                    xytext=(0, 5 if k < 3 else -12),
                    textcoords="offset points",
                    ha="center",
                    fontsize=8,
                    color=GREY,
                )
            axes.set_title(
                f"{gains}: $G_t$ = {servo.tension_gain:.1f}, "
                f"$G_v$ = {servo.velocity_gain:.2f} N m s/rad, $J_m$ = {servo.inertia:g} kg m², "
                f"$r$ = {1e3 * servo.radius:g} mm, $\\lambda$ = {staircase.bench.exponent:.2g}"
            )
            axes.set_ylabel("tension above $T_0$ [N]")
            axes.set_ylim(-9.0, 69.0)
        upper.plot([], [], " ", label="in grey: overshoot over the step")
        lower.set_xlabel("time $t$ [s]")
        legend_below(figure, upper, columns=3)
    return figure


def draw_limit_cycles(limit_cycles: LimitCycles) -> Figure:
    """Draw the amplitude over ξ_B for every case, the line through them and the prediction."""
    backlash, amplitude, predicted = limit_cycles.columns()
    names = {"exponent": "$\\lambda$", "pretension": "$T_0$", "axial_stiffness": "$EA$"}
    with print_style():
        figure = new_figure(8.0, 4.2)
        left, right = figure.subplots(1, 2, width_ratios=(1.25, 1.0))
        for name, (colour, _, marker) in zip(VARIED, SERIES, strict=False):
            mine = np.array([c.varied == name for c in limit_cycles.cycles])
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
            1e3 * (limit_cycles.factor * reach + limit_cycles.intercept),
            color=BLACK,
            label=f"fit: {limit_cycles.factor:.2f} $\\xi_B$ + "
            f"{1e3 * limit_cycles.intercept:.3f} mm, "
            f"$R^2$ = {limit_cycles.r_squared:.4f}",
        )
        left.set(
            title="amplitude of the limit cycle",
            xlabel="equivalent backlash $\\xi_B$ [mm]",
            ylabel="amplitude of $\\xi_\\mathrm{in}$ [mm]",
        )
        left.set_xlim(left=0.0)
        left.set_ylim(bottom=0.0)
        cycle = max(limit_cycles.cycles, key=lambda c: c.backlash)
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
            for way, result in (("pulling", runs[2]), ("loosening", runs[3])):
                run = result.response
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
    top = 100.0 * (1.0 + max(result.overshoot for result in gains.plain_steps))
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


def draw_figures(study: Study) -> Iterator[tuple[str, Figure]]:
    """Yield each picture's name and figure."""
    yield "fig6_phase_plane", draw_phase_plane(study.phase_plane)
    yield "fig7_steps", draw_staircase(study.staircase)
    yield "limit_cycle", draw_limit_cycles(study.limit_cycles)
    yield "strategies", draw_strategies(study.gains_output_held, study.tracking)
