"""The servo in the phase plane (Fig. 6 of the paper)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.force_servo.bench import Response
from experiments.force_servo.phase_plane import Line, PhasePlane
from tendon_mj.view.figures.style import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    VERMILLION,
    legend_below,
    new_figure,
    print_style,
)

_STILL = 0.2  # share of the usual dT_out/dθ below which the output counts as holding still
_THIN = 10


def phase_plane_figure(found: PhasePlane) -> Figure:
    """Draw θ̇ over θ: both lines ẋ₂ = 0, motions from below and above, and the backlash.

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
            _draw_still(left, response, found.origin)
        for line in found.lines:
            _draw_line(left, line)
        left.set_title(f"critical for pulling, $G_v$ = {found.servo.velocity_gain:.2f} N m s/rad")
        _draw(right, found.swing, found.origin, BLUE, "from below")
        _draw_still(right, found.swing, found.origin)
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
    axes: Axes, response: Response, origin: float, colour: str, label: str, style: str = "-"
) -> None:
    axes.plot(
        response.angle[::_THIN] - origin,
        response.speed[::_THIN],
        color=colour,
        linestyle=style,
        label=label,
    )


def _draw_still(axes: Axes, response: Response, origin: float) -> None:
    """Mark where the motor moves and the output does not."""
    rate, speed = np.gradient(response.output_tension, response.time), response.speed
    fast = np.abs(speed) > 0.01 * np.abs(speed).max()
    slope = np.abs(rate) / np.where(fast, np.abs(speed), 1.0)
    still = fast & (slope < _STILL * np.quantile(slope[fast], 0.9))
    speed = np.where(still, speed, np.nan)
    axes.plot(
        response.angle[::_THIN] - origin,
        speed[::_THIN],
        color=ORANGE,
        linewidth=5.0,
        alpha=0.45,
        zorder=1,
        label="backlash: output holds still" if not _named(axes) else None,
    )


def _named(axes: Axes) -> bool:
    return any("backlash" in str(line.get_label()) for line in axes.lines)


def _draw_line(axes: Axes, line: Line) -> None:
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
        f"$\\omega_1/2\\zeta$ = {line.analytic_slope:.2f}/s",
    )
    axes.plot(
        line.angle,
        line.speed,
        "o",
        color=GREEN,
        markersize=3.5,
        label="_points",
    )
