"""Panel beside a clip: colour bar, tensions and controls over time, and their current values."""

from __future__ import annotations

import mujoco
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.font_manager import findfont
from matplotlib.lines import Line2D
from PIL import Image as Picture
from PIL import ImageDraw, ImageFont

from tendon_mj.replay.frames import Array, Frames
from tendon_mj.view.figures.style import (
    BLUE,
    GREEN,
    GREY,
    PURPLE,
    VERMILLION,
    new_figure,
    print_style,
)
from tendon_mj.view.render.cable import COLOURS
from tendon_mj.view.render.offscreen import Image

HEIGHT = 720  # at which font sizes are in pixels [pixels]
_PAIR = (BLUE, VERMILLION)
_MANY = (BLUE, VERMILLION, GREEN, PURPLE)
_ROWS = 4  # sheaths whose tensions are also written as numbers
INK = "#202020"


class Panel:
    """The panel of a clip. What does not change is drawn once; `draw` adds what does.

    Args:
        model: whose actuators are named.
        frames: of the clip.
        scale: of the colours.
        width, height: of the panel [pixels].
    """

    def __init__(
        self, model: mujoco.MjModel, frames: Frames, scale: Normalize, width: int, height: int
    ) -> None:
        self._frames = frames
        self._unit = height / HEIGHT
        rows = min(len(frames.cables), _ROWS)
        self._table = (96 + 28 * rows) / HEIGHT
        with print_style():
            figure = new_figure(width / height * 7.2, 7.2)
            figure.set_dpi(height / 7.2)
            figure.get_layout_engine().set(rect=(0.02, 0.01, 0.95, 1.0 - self._table))  # type: ignore[union-attr,call-arg]
            bar, tension, control = figure.subplots(
                3, 1, height_ratios=(0.06, 1.0, 0.55), squeeze=True
            )
            _draw_bar(figure, bar, scale)
            self._lines = _draw_tensions(tension, frames)
            _draw_controls(control, model, frames)
            tension.sharex(control)
            figure.draw_without_rendering()
            figure.canvas.draw()
        self._axes = (tension, control)
        self._background = np.array(figure.canvas.buffer_rgba())[..., :3]  # type: ignore[attr-defined]
        self._font = {
            size: ImageFont.truetype(findfont("DejaVu Sans"), max(6, round(size * self._unit)))
            for size in (22, 15)
        }

    def draw(self, frame: int) -> Image:
        """(height, width, 3) picture of the panel for a frame."""
        picture = Picture.fromarray(self._background)
        draw = ImageDraw.Draw(picture)
        self._write_table(draw, frame)
        for axes in self._axes:
            x, top = self._pixel(axes, self._frames.time[frame], axes.get_ylim()[1])
            bottom = self._pixel(axes, self._frames.time[frame], axes.get_ylim()[0])[1]
            draw.line([(x, top), (x, bottom)], fill=GREY, width=max(1, round(self._unit)))
        radius = 4.5 * self._unit
        for colour, values in self._lines:
            x, y = self._pixel(self._axes[0], self._frames.time[frame], float(values[frame]))
            draw.ellipse([x - radius, y - radius, x + radius, y + radius], fill=colour)
        return np.array(picture)

    def _pixel(self, axes: Axes, x: float, y: float) -> tuple[float, float]:
        column, row = axes.transData.transform((x, y))
        return float(column), self._background.shape[0] - float(row)

    def _write_table(self, draw: ImageDraw.ImageDraw, frame: int) -> None:
        width = self._background.shape[1]
        line, ends = 28 * self._unit, (0.66 * width, 0.95 * width)
        large, small = self._font[22], self._font[15]
        y = 14 * self._unit
        draw.text((0.05 * width, y), f"{self._frames.time[frame]:.2f} s", fill=INK, font=large)
        y += 1.5 * line
        draw.text((0.05 * width, y), "tension [N]", fill=INK, font=small)
        for text, x in zip(("input", "output"), ends, strict=True):
            draw.text((x, y), text, fill=INK, font=small, anchor="ra")
        colours = iter(colour for colour, _ in self._lines)
        for name, cable in list(self._frames.cables.items())[:_ROWS]:
            y += line
            pair = (next(colours), next(colours))
            many = len(self._frames.cables) > 1
            draw.text((0.05 * width, y), name, fill=pair[0] if many else INK, font=small)
            for x, colour, value in zip(ends, pair, cable.tensions[frame, [0, -1]], strict=True):
                draw.text((x, y), f"{value:.1f}", fill=colour, font=small, anchor="ra")


def _draw_bar(figure: Figure, axes: Axes, scale: Normalize) -> None:
    figure.colorbar(ScalarMappable(scale, COLOURS), cax=axes, orientation="horizontal")
    axes.set_title("tension along the tendon, $T$ [N]", fontweight="normal")


def _draw_tensions(axes: Axes, frames: Frames) -> list[tuple[str, Array]]:
    """Input and output tension of every cable; returns colour and values of each line."""
    lines: list[tuple[str, Array]] = []
    for k, cable in enumerate(frames.cables.values()):
        several = len(frames.cables) > 1
        ends = (_MANY[k % len(_MANY)],) * 2 if several else _PAIR
        for end, colour, style in zip((0, -1), ends, ("-", "--"), strict=True):
            values = cable.tensions[:, end]
            axes.plot(frames.time, values, color=colour, linestyle=style)
            lines.append((colour, values))
    axes.set_ylabel("$T$ [N]")
    axes.tick_params(labelbottom=False)
    ends = (GREY, GREY) if len(frames.cables) > 1 else _PAIR
    handles = [
        Line2D([], [], color=ends[0], linestyle="-"),
        Line2D([], [], color=ends[1], linestyle="--"),
    ]
    axes.legend(
        handles, ["input end", "output end"], loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2
    )
    return lines


def _draw_controls(axes: Axes, model: mujoco.MjModel, frames: Frames) -> None:
    moving = [k for k in range(model.nu) if np.ptp(frames.controls[:, k]) > 0.0]
    for colour, k in zip(_MANY, moving, strict=False):
        name = model.actuator(k).name or f"actuator {k}"
        name += " [m]" if model.actuator_plugin[k] >= 0 else ""
        axes.plot(
            frames.time,
            frames.controls[:, k],
            color=colour if len(moving) > 1 else GREY,
            label=name,
        )
    if moving:
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)
    axes.set_ylabel("control")
    axes.set_xlabel("time $t$ [s]")
