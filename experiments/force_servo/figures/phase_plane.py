"""Figure of the phase plane (Fig. 6 of the paper)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.force_servo.phase_plane import Nullcline, PhasePlane, output_is_held
from experiments.force_servo.servo_bench import ServoResponse
from tendon_mj.show import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    VERMILLION,
    legend_below,
    new_figure,
    print_style,
)

_THIN = 10  # every so many samples are drawn


def draw_phase_plane(found: PhasePlane) -> Figure:
    """Draw θ̇ over θ: both lines ẋ₂ = 0, trajectories from below and above, and the backlash.

    Left with gains critical for pulling, right lightly damped, so that the motor turns back and
    crosses the backlash again and again.
    """
    with print_style():
        figure = new_figure(8.6, 4.6)
        left, right = figure.subplots(1, 2)
        up, down, up_back, down_back = found.trajectories
        for response, label, colour in (
            (up, "(I) from below", BLUE),
            (down, "(II) from above", VERMILLION),
        ):
            _draw(left, response, found.origin, colour, label)
        for response, label, colour in (
            (up_back, "(I) after a reversal", BLUE),
            (down_back, "(II) after a reversal", VERMILLION),
        ):
            _draw(left, response, found.origin, colour, label, "--")
            _draw_held(left, response, found.origin)
        for line in found.lines:
            _draw_line(left, line)
        left.set_title(f"critical for pulling, $G_v$ = {found.servo.velocity_gain:.2f} N m s/rad")
        _draw(right, found.swing, found.origin, BLUE, "from below")
        _draw_held(right, found.swing, found.origin)
        right.set_title(f"$\\zeta$ = 0.2, $G_v$ = {found.swinging.velocity_gain:.2f} N m s/rad")
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
        response.angle[::_THIN] - origin,
        response.speed[::_THIN],
        color=colour,
        linestyle=style,
        label=label,
    )


def _draw_held(axes: Axes, response: ServoResponse, origin: float) -> None:
    """Mark the samples at which the motor turns and the output tension does not change."""
    speed = np.where(output_is_held(response), response.speed, np.nan)
    axes.plot(
        response.angle[::_THIN] - origin,
        speed[::_THIN],
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
