"""Panel beside a clip: colour bar, charts over time, and the current values."""

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

from tendon_mj.lab.replay import Frames
from tendon_mj.plugin import sheaths
from tendon_mj.show.figures.style import GREY, new_figure, print_style
from tendon_mj.show.render.cable import COLOURS
from tendon_mj.show.render.charts import Chart, charts, tendon_colours, touch_forces
from tendon_mj.show.render.legend import Legend, shortened
from tendon_mj.show.render.offscreen import Image

_DPI, _LEGIBLE = 100.0, 84.0  # at 720 pixels of height; the least that is read with ease
_LEAST_INCHES = 5.0  # height that a chart, a colour bar and the values take
HEIGHT = 720  # [pixels]
_ROWS = 4  # sheaths whose tensions are also written as numbers
_CHART, _BAR = 1.2, 0.6  # least height of a chart without its legend, and of the bar [inch]
_LEGEND = 0.92  # width of a legend over the panel's
INK = "#202020"


def text_scale(height: int) -> float:
    """Size of text in a clip over that at 720 pixels of height [pixels]."""
    return max(height / HEIGHT, min(_LEGIBLE, height / _LEAST_INCHES) / _DPI)


class Panel:
    """The panel of a clip. What does not change is drawn once; `draw` adds what does.

    Args:
        model: whose actuators, joints and sensors are named.
        frames: of the clip.
        scale: of the colours.
        width, height: of the panel [pixels].
        twin: frames of the same motion without friction.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        frames: Frames,
        scale: Normalize,
        width: int,
        height: int,
        twin: Frames | None = None,
    ) -> None:
        self._frames = frames
        self._unit = text_scale(height)
        self._rows = _table(model, frames, twin)
        dpi, table = _DPI * self._unit, (66 + 24 * len(self._rows)) * self._unit / height
        inches = height / dpi
        shown = charts(model, frames, twin)
        shown = _that_fit(shown, (1.0 - table) * inches - _BAR, width / dpi)
        with print_style():
            figure = new_figure(width / dpi, inches)
            figure.set_dpi(dpi)
            figure.get_layout_engine().set(rect=(0.02, 0.01, 0.95, 1.0 - table))  # type: ignore[union-attr,call-arg]
            ratios = (0.09, *(1.0 for _ in shown))
            bar, *axes = figure.subplots(len(ratios), 1, height_ratios=ratios, squeeze=True)
            _draw_bar(figure, bar, scale)
            for one, chart in zip(axes, shown, strict=True):
                _draw_chart(one, chart, frames, width / dpi)
                one.tick_params(labelbottom=one is axes[-1])
                one.set_xlim(frames.time[0], max(frames.time[-1], frames.time[0] + 1e-3))
            axes[-1].set_xlabel("time [s]")
            figure.align_ylabels(axes)
            figure.draw_without_rendering()
            figure.canvas.draw()
        self._plots = list(zip(axes, shown, strict=True))
        self._background = np.array(figure.canvas.buffer_rgba())[:height, :width, :3]  # type: ignore[attr-defined]
        self._font = {
            size: ImageFont.truetype(findfont("DejaVu Sans"), max(6, round(size * self._unit)))
            for size in (20, 14)
        }

    def draw(self, frame: int) -> Image:
        """(height, width, 3) picture of the panel for a frame."""
        picture = Picture.fromarray(self._background)
        draw = ImageDraw.Draw(picture)
        self._write_table(draw, frame)
        time, radius = self._frames.time[frame], 4.0 * self._unit
        for axes, chart in self._plots:
            low, high = (self._pixel(axes, time, y) for y in axes.get_ylim())
            draw.line([low, high], fill=GREY, width=1)
            for line in (*chart.twin, *chart.lines):
                x, y = self._pixel(axes, time, float(line.values[frame]))
                draw.ellipse([x - radius, y - radius, x + radius, y + radius], fill=line.colour)
        return np.array(picture)

    def _pixel(self, axes: Axes, x: float, y: float) -> tuple[float, float]:
        column, row = axes.transData.transform((x, y))
        return float(column), self._background.shape[0] - float(row)

    def _write_table(self, draw: ImageDraw.ImageDraw, frame: int) -> None:
        width, small = self._background.shape[1], self._font[14]
        y, columns = 10 * self._unit, (0.70 * width, 0.95 * width)
        draw.text(
            (0.05 * width, y),
            f"{self._frames.time[frame]:.2f} s",
            fill=INK,
            font=self._font[20],
        )
        y += 10 * self._unit
        for name, colour, cells in self._rows:
            y += 24 * self._unit
            kept = shortened(name, 0.48 * width / small.size)
            draw.text((0.05 * width, y), kept, fill=colour, font=small)
            for cell, x in zip(cells, columns, strict=True):
                text = cell if isinstance(cell, str) else f"{cell[frame]:.1f}"
                draw.text((x, y), text, fill=colour, font=small, anchor="ra")


def _table(
    model: mujoco.MjModel, frames: Frames, twin: Frames | None
) -> list[tuple[str, str, tuple[str | np.ndarray, str | np.ndarray]]]:
    """Rows of the table: name, colour, and two columns of words or of values by frame."""
    rows: list[tuple[str, str, tuple[str | np.ndarray, str | np.ndarray]]] = []
    forces = touch_forces(model, frames, twin)
    if len(forces) == 1:
        ((name, values),) = forces.items()
        other = touch_forces(model, twin, frames)[name] if twin else None
        if other is not None:
            rows.append(("", GREY, ("friction", "none")))
        name = f"{name.replace('_', ' ')} [N]"
        rows.append((name, INK, ("", values) if other is None else (values, other)))
    rows.append(("tension [N]", INK, ("input", "output")))
    colours = tendon_colours(model)
    found = list(frames.cables.items())
    listed = found if len(found) == _ROWS + 1 else found[:_ROWS]  # one more needs no row to say so
    for name, cable in listed:
        ends = cable.tensions[:, 0], cable.tensions[:, -1]
        colour = colours[name] if len(frames.cables) > 1 else INK
        rows.append((f"  {sheaths(model)[name].tendon}", colour, ends))
    if len(listed) < len(found):
        rows.append((f"  … and {len(found) - len(listed)} more", GREY, ("", "")))
    return rows


def _that_fit(found: list[Chart], height: float, width: float) -> list[Chart]:
    """The first of some charts that there is place for [inch], at least one."""
    taken = np.cumsum([_CHART + Legend(_entries(c)[0], _LEGEND * width).height for c in found])
    return found[: max(1, int((taken <= height).sum()))]


def _draw_bar(figure: Figure, axes: Axes, scale: Normalize) -> None:
    figure.colorbar(ScalarMappable(scale, COLOURS), cax=axes, orientation="horizontal")
    axes.set_title("tension along the tendon [N]", fontweight="normal", fontsize=9.0)


def _draw_chart(axes: Axes, chart: Chart, frames: Frames, width: float) -> None:
    for line in (*chart.twin, *chart.lines):
        axes.plot(frames.time, line.values, color=line.colour, linestyle=line.style)
    names, entries = _entries(chart)
    Legend(names, _LEGEND * width).draw(axes, entries, left=-0.12)
    axes.set_ylabel(chart.label)


def _entries(chart: Chart) -> tuple[list[str], list[Line2D]]:
    """Names and lines of a chart's legend."""
    entries = [Line2D([], [], color=o.colour, linestyle=o.style) for o in chart.lines if o.name]
    names = [line.name for line in chart.lines if line.name]
    if chart.twin:
        entries.append(Line2D([], [], color=GREY, linestyle="--"))
        names.append("no friction")
    elif any(line.style == "--" for line in chart.lines):
        names, entries = _with_ends(names, entries)
    if chart.left_out:
        names.append(f"… and {chart.left_out} more")
        entries.append(Line2D([], [], color="none"))
    return names, entries


def _with_ends(names: list[str], entries: list[Line2D]) -> tuple[list[str], list[Line2D]]:
    """Entries for the line styles of both ends, where colours tell the tendons apart."""
    if "input end" in names:
        return names, entries
    ends = [Line2D([], [], color=GREY, linestyle=style) for style in ("-", "--")]
    return [*names, "input", "output"], [*entries, *ends]
