"""Panel beside a clip: colour bar, charts over time, and the current values."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Iterable, Sequence
from functools import cache
from typing import Literal, NamedTuple

import mujoco
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize, to_hex
from matplotlib.font_manager import findfont
from matplotlib.lines import Line2D
from PIL import Image as Picture
from PIL import ImageDraw, ImageFont

from tendon_mj.lab.frames import Frames
from tendon_mj.lab.friction_effect import free_joints
from tendon_mj.lab.replay import control_unit
from tendon_mj.lab.units import EngineeringUnit, engineering_unit, force_unit
from tendon_mj.plugin import sheaths
from tendon_mj.show import style
from tendon_mj.show.render.offscreen import COLOURS, Image, colour_limits, without_spikes
from tendon_mj.typing import FloatArray

_DPI, _LEGIBLE = 100.0, 84.0  # at 720 pixels of height; the least that is read with ease
_LEAST_INCHES = 5.0  # height that a chart, a colour bar and the values take
HEIGHT = 720  # [pixels]
_TABLE_ROWS = 4  # sheaths whose tensions are also written as numbers
_CHART, _BAR = 1.2, 0.6  # least height of a chart without its legend, and of the bar [inch]
_LEGEND = 0.92  # width of a legend over the panel's
_CELL = 0.31  # width of a cell of the table over the panel's; its columns are 0.33 apart
INK = style.LIGHT.ink
# of legends: text [pt]; line, gaps and rows over the text's size
_TEXT_SIZE = 8.0
_HANDLE, _TEXT_GAP, _COLUMN = 1.3, 0.4, 0.8
_ROW, _ROWS_APART = 1.25, 0.1
_MOST_COLUMNS = 4
_MOST_LONG = 6  # entries in a single column
_TEXT_PIXELS = 16  # pixels to a point that text is measured in

Style = Literal["-", "--", "-.", ":"]
# for tendons with the same colour in the model; the last two are of Paul Tol's palette
TENDON_PALETTE = (
    style.BLUE,
    style.VERMILLION,
    style.GREEN,
    style.PURPLE,
    style.ORANGE,
    style.SKY,
    "#332288",
    "#882255",
)
_OTHER_COLOURS = TENDON_PALETTE[2:6]  # of joints, apart from the colours of two tendons
_END_STYLES: tuple[Style, Style] = ("-", "--")  # input and output end
_MOST_LINES = 4  # lines of one kind in a chart
_UNCOLOURED = (0.5, 0.5, 0.5)  # MuJoCo's default colour of a tendon
_Cell = str | tuple[FloatArray, ...]  # a text, or values by frame, from the input to the output


def text_scale(height: int) -> float:
    """Size of text in a clip over that at 720 pixels of height [pixels]."""
    return max(height / HEIGHT, min(_LEGIBLE, height / _LEAST_INCHES) / _DPI)


class Panel:
    """The panel of a clip. Its background is drawn once; `draw` adds the current values.

    The twin is frames of the same motion without friction; width and height are in pixels.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        frames: Frames,
        scale: Normalize,
        width: int,
        height: int,
        twin: Frames | None = None,
        theme: style.Theme = style.LIGHT,
    ) -> None:
        self._frames, self._theme = frames, theme
        self._unit = text_scale(height)
        unit = unit_of_forces(frames)
        self._rows = _value_rows(model, frames, twin, unit)
        dpi, table = _DPI * self._unit, (66 + 24 * len(self._rows)) * self._unit / height
        inches = height / dpi
        shown = charts(model, frames, twin)  # of which the first are drawn, as many as fit
        heights = [_CHART + Legend(_entries(c)[0], _LEGEND * width / dpi).height for c in shown]
        fitting = np.cumsum(heights) <= (1.0 - table) * inches - _BAR
        shown = shown[: max(1, int(fitting.sum()))]
        with style.print_style(theme):
            figure = style.new_figure(width / dpi, inches)
            figure.set_dpi(dpi)
            figure.get_layout_engine().set(rect=(0.02, 0.01, 0.95, 1.0 - table))  # type: ignore[union-attr,call-arg]
            ratios = [*([0.09] if frames.drawn else []), *(1.0 for _ in shown)]
            grid = [*figure.subplots(len(ratios), 1, height_ratios=ratios, squeeze=False)[:, 0]]
            if frames.drawn:
                bar, low, high = grid.pop(0), scale.vmin or 0.0, scale.vmax or 1.0
                colours = ScalarMappable(Normalize(unit.factor * low, unit.factor * high), COLOURS)
                figure.colorbar(colours, cax=bar, orientation="horizontal")
                title = style.labelled("tension along the tendon", unit)
                bar.set_title(title, fontweight="normal", fontsize=9.0)
            for axes, chart in zip(grid, shown, strict=True):
                for line in (*chart.twin, *chart.lines):
                    colour = style.on_theme(line.colour, theme)
                    axes.plot(frames.time, line.values, color=colour, linestyle=line.style)
                values = np.concatenate([line.values for line in (*chart.twin, *chart.lines)])
                values = values[np.isfinite(values)]
                if values.size and (top := without_spikes(values)) < values.max():
                    margin = 0.1 * (top - values.min())
                    axes.set_ylim(values.min() - margin, top + margin)
                names, entries = _entries(chart, theme)
                Legend(names, _LEGEND * width / dpi).draw(axes, entries, left=-0.12)
                axes.set_ylabel(chart.label)
                axes.tick_params(labelbottom=axes is grid[-1])
                axes.set_xlim(frames.time[0], max(frames.time[-1], frames.time[0] + 1e-3))
            grid[-1].set_xlabel("time [s]")
            figure.align_ylabels(grid)
            figure.draw_without_rendering()
            figure.canvas.draw()
        self._plots = list(zip(grid, shown, strict=True))
        self._background = np.array(figure.canvas.buffer_rgba())[:height, :width, :3]  # type: ignore[attr-defined]
        face = ImageFont.truetype(findfont("DejaVu Sans"), max(6, round(20 * self._unit)))
        cells = [cell for _, _, row in self._rows for cell in row]
        written = {_text(cell, k) for cell in cells for k in range(len(frames.time))}
        widest = max(face.getlength(text) for text in written) / face.size
        small = min(round(14 * self._unit), int(_CELL * width / widest))
        self._font, self._small = face, face.font_variant(size=max(6, small))

    def draw(self, frame: int) -> Image:
        """(height, width, 3) picture of the panel for a frame."""
        picture = Picture.fromarray(self._background)
        draw = ImageDraw.Draw(picture)
        self._write_table(draw, frame)
        time, radius = self._frames.time[frame], 4.0 * self._unit
        for axes, chart in self._plots:
            low, high = (self._pixel(axes, time, y) for y in axes.get_ylim())
            draw.line([low, high], fill=self._theme.grey, width=1)
            for line in (*chart.twin, *chart.lines):
                x, y = self._pixel(axes, time, float(line.values[frame]))
                colour = style.on_theme(line.colour, self._theme)
                draw.ellipse([x - radius, y - radius, x + radius, y + radius], fill=colour)
        return np.array(picture)

    def _pixel(self, axes: Axes, x: float, y: float) -> tuple[float, float]:
        column, row = axes.transData.transform((x, y))
        return float(column), self._background.shape[0] - float(row)

    def _write_table(self, draw: ImageDraw.ImageDraw, frame: int) -> None:
        width, small = self._background.shape[1], self._small
        y, columns = 10 * self._unit, (0.64 * width, 0.97 * width)
        now = f"{self._frames.time[frame]:.2f} s"
        draw.text((0.05 * width, y), now, fill=self._theme.ink, font=self._font)
        y += 10 * self._unit
        for name, colour, cells in self._rows:
            y += 24 * self._unit
            ink = style.on_theme(colour, self._theme)
            kept = shortened(name, (0.32 if cells[0] else 0.58) * width / small.size)
            draw.text((0.05 * width, y), kept, fill=ink, font=small)
            for cell, x in zip(cells, columns, strict=True):
                draw.text((x, y), _text(cell, frame), fill=ink, font=small, anchor="ra")


def _text(cell: _Cell, frame: int) -> str:
    """What is written in a cell of the table."""
    values = [cell] if isinstance(cell, str) else [_number(v[frame]) for v in cell]
    return " → ".join(values).replace("-", "−")


def _number(value: float) -> str:
    """A reading with three digits or more: two of them have place beside two others."""
    return f"{value:z.0f}" if abs(value) >= 99.95 else f"{value:z.1f}"


def _value_rows(
    model: mujoco.MjModel, frames: Frames, twin: Frames | None, unit: EngineeringUnit
) -> list[tuple[str, str, tuple[_Cell, _Cell]]]:
    """Rows of the table: name, colour, and two cells."""
    rows: list[tuple[str, str, tuple[_Cell, _Cell]]] = []
    if twin:
        rows.append(("", style.GREY, ("with friction", "no friction")))
    forces = touch_forces(model, frames, twin)
    if len(forces) == 1:
        ((name, both),) = forces.items()
        label = style.labelled(name.replace("_", " "), unit)
        felt = [(unit.factor * values,) for values in both]
        rows.append((label, INK, (felt[0], felt[1]) if twin else ("", felt[0])))
    ends = "input → output"
    rows.append((style.labelled("tension", unit), style.GREY, (ends if twin else "", ends)))
    colours, cables, names = tendon_colours(model, frames.cables), frames.cables, listed(frames)
    for name in names:
        cable = cables[name]
        shown = [tuple(unit.factor * f.cables[name].end_tensions.T) for f in (frames, twin) if f]
        colour = colours[name] if len(cables) > 1 else INK
        cells = (shown[0], shown[1]) if twin else ("", shown[0])
        rows.append((f"  {sheaths(model)[name].tendon}{cable.branch.words}", colour, cells))
    if len(names) < len(cables):
        rows.append((f"  … and {len(cables) - len(names)} more", style.GREY, ("", "")))
    return rows


def listed(frames: Frames) -> list[str]:
    """Sheaths that are in table, chart and scene by name: one more in place of "and 1 more"."""
    names = list(frames.cables)
    return names if len(names) == _TABLE_ROWS + 1 else names[:_TABLE_ROWS]


def _entries(chart: _Chart, theme: style.Theme = style.LIGHT) -> tuple[list[str], list[Line2D]]:
    """Names and lines of a chart's legend."""
    named = [(line.name, line.colour, line.style) for line in chart.lines if line.name]
    if chart.twin:
        named.append(("no friction", style.GREY, "-"))
    elif any(line.style == "--" for line in chart.lines) and named[0][0] != "input end":
        # colours tell the tendons apart, line styles their ends
        named += [("input", INK, "-"), ("output", INK, "--")]
    if chart.left_out:
        named.append((f"… and {chart.left_out} more", "none", "-"))
    entries = [
        Line2D([], [], color=c if c == "none" else style.on_theme(c, theme), linestyle=dashes)
        for _, c, dashes in named
    ]
    return [name for name, _, _ in named], entries


class Legend:
    """Legend above a chart, in as many columns as its width [inch] allows.

    A name that is too long for its column lacks its middle.
    """

    def __init__(self, names: Sequence[str], width: float) -> None:
        place = 72.0 * width / _TEXT_SIZE  # over the text's size
        around = _HANDLE + _TEXT_GAP + _COLUMN
        least = 1 if len(names) <= _MOST_LONG else 2
        self.names = [shortened(name, place / least - around) for name in names]
        widest = around + max((text_width(name) for name in self.names), default=0.0)
        most = max(1, min(_MOST_COLUMNS, int(place / widest + 1e-9)))
        self.rows = max(1, math.ceil(len(self.names) / most))
        self.columns = max(1, math.ceil(len(self.names) / self.rows))

    @property
    def height(self) -> float:
        """Height of all rows [inch]."""
        return self.rows * (_ROW + _ROWS_APART) * _TEXT_SIZE / 72.0

    def draw(self, axes: Axes, entries: Sequence[Line2D], left: float) -> None:
        """Draw the legend above a chart, from ``left`` of its width on, and keep its place free."""
        # the layout leaves the place of a title, which is as wide as the chart, unlike the legend
        axes.set_title(" ", fontsize=_TEXT_SIZE, pad=72.0 * self.height - _TEXT_SIZE)
        drawn = axes.legend(
            entries,
            self.names,
            loc="lower left",
            bbox_to_anchor=(left, 1.0),
            ncols=self.columns,
            borderpad=0.2,
            borderaxespad=0.1,
            labelspacing=_ROWS_APART,
            columnspacing=_COLUMN,
            handlelength=_HANDLE,
            handletextpad=_TEXT_GAP,
            fontsize=_TEXT_SIZE,
        )
        drawn.set_in_layout(False)


def shortened(text: str, width: float) -> str:
    """A text that is not wider than ``width`` over its size; "…" stands for its middle."""
    kept = text
    while len(kept) > 1 and text_width(kept) > width:
        half = (len(kept) - 2) // 2  # names differ as often at their end
        kept = f"{text[:half]}…{text[-half:] if half else ''}"
    return kept


def text_width(text: str) -> float:
    """Width of a text over its size."""
    return float(_font().getlength(text)) / (_TEXT_PIXELS * _TEXT_SIZE)


@cache
def _font() -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(findfont("DejaVu Sans"), int(_TEXT_PIXELS * _TEXT_SIZE))


class Line(NamedTuple):
    """A line of a chart, (frames,) values; no name where another one's entry stands for it."""

    name: str
    values: FloatArray
    colour: str
    style: Style = "-"


class _Chart(NamedTuple):
    """Lines over time with one axis, and grey ones of the frictionless twin behind them."""

    label: str
    lines: Sequence[Line]
    twin: Sequence[Line] = ()
    left_out: int = 0


def tendon_colours(model: mujoco.MjModel, first: Iterable[str] = ()) -> dict[str, str]:
    """Colour of the tendon of every sheath: the model's if no other has it, else the next.

    Those of the ``first`` sheaths are apart.
    """
    known = sheaths(model)
    drawn = {
        name: to_hex(model.tendon_rgba[model.tendon(known[name].tendon).id, :3])
        for name in dict.fromkeys([*first, *known])
    }
    given = Counter(drawn.values())
    kept = {c for c, times in given.items() if times == 1 and c != to_hex(_UNCOLOURED)}
    free = itertools.cycle([c for c in TENDON_PALETTE if c.lower() not in kept])
    return {name: colour if colour in kept else next(free) for name, colour in drawn.items()}


def charts(model: mujoco.MjModel, frames: Frames, twin: Frames | None = None) -> list[_Chart]:
    """Charts of the quantities that there are, the most important first."""
    unit = unit_of_forces(frames)
    drawn = (
        _forces_chart(model, frames, twin, unit),
        _tensions_chart(model, frames, unit),
        _joints_chart(model, frames, twin),
        _controls_chart(model, frames, unit),
    )
    return [chart for chart in drawn if chart.lines]


def unit_of_forces(frames: Frames) -> EngineeringUnit:
    """The unit of all forces in the panel, which is that of the colour bar."""
    return force_unit([colour_limits(frames.cables).vmax or 0.0])


def touch_forces(
    model: mujoco.MjModel, frames: Frames, twin: Frames | None
) -> dict[str, list[FloatArray]]:
    """(frames,) forces here and in the twin [N] of each touch sensor that felt any, by name."""
    forces = dict[str, list[FloatArray]]()
    for k in np.flatnonzero(model.sensor_type == mujoco.mjtSensor.mjSENS_TOUCH.value):
        felt = [f.readings[:, model.sensor_adr[k]] for f in (frames, twin) if f is not None]
        if any(values.any() for values in felt):
            forces[model.sensor(k).name or f"sensor {k}"] = felt
    return forces


def _forces_chart(
    model: mujoco.MjModel, frames: Frames, twin: Frames | None, unit: EngineeringUnit
) -> _Chart:
    forces = list(touch_forces(model, frames, twin).items())[:_MOST_LINES]
    several = len(forces) > 1
    colours = _OTHER_COLOURS if several else (style.BLACK,)
    lines = [
        Line(name.replace("_", " "), unit.factor * felt[0], colour)
        for (name, felt), colour in zip(forces, colours, strict=False)
    ]
    label = style.labelled("force" if several or not lines else lines[0].name, unit)
    behind = [Line("", unit.factor * x, style.GREY) for _, felt in forces for x in felt[1:]]
    if behind and not several:
        lines = [lines[0]._replace(name="with friction")]
    return _Chart(label, lines, behind)


def _tensions_chart(model: mujoco.MjModel, frames: Frames, unit: EngineeringUnit) -> _Chart:
    label = style.labelled("tension", unit)
    ends = {n: unit.factor * c.end_tensions.T for n, c in frames.cables.items()}
    if len(ends) == 1:
        ((first, last),) = ends.values()
        both = [
            Line("input end", first, style.BLUE, _END_STYLES[0]),
            Line("output end", last, style.VERMILLION, _END_STYLES[1]),
        ]
        return _Chart(label, both)
    lines, colours = [], tendon_colours(model, frames.cables)
    for name in listed(frames):
        tendon = f"{sheaths(model)[name].tendon}{frames.cables[name].branch.words}"
        for label_of, values, dashes in zip((tendon, ""), ends[name], _END_STYLES, strict=True):
            lines.append(Line(label_of, values, colours[name], dashes))
    return _Chart(label, lines, left_out=len(ends) - len(lines) // 2)


def _joints_chart(model: mujoco.MjModel, frames: Frames, twin: Frames | None) -> _Chart:
    """Hinges, or slides if there are none, that no actuator moves directly.

    Of many they are those that friction changes most, or that move most.
    """
    for kind, label, si in (
        (mujoco.mjtJoint.mjJNT_HINGE, "joint angle", "rad"),
        (mujoco.mjtJoint.mjJNT_SLIDE, "displacement", "m"),
    ):
        chosen = free_joints(model, kind)
        moves = frames.poses[:, model.jnt_qposadr[chosen]]
        apart = twin.poses[:, model.jnt_qposadr[chosen]] - moves if twin else 0.0 * moves
        size = [*zip(np.abs(apart).max(axis=0), np.ptp(moves, axis=0), strict=True)]
        most = sorted(range(len(chosen)), key=size.__getitem__, reverse=True)[:_MOST_LINES]
        shown = [chosen[k] for k in sorted(most)]
        places = model.jnt_qposadr[shown]
        if len(places):
            unit = engineering_unit(si, frames.poses[:, places].ravel())
            lines = [
                Line(model.joint(k).name or f"joint {k}", unit.factor * frames.poses[:, p], colour)
                for k, p, colour in zip(shown, places, _OTHER_COLOURS, strict=False)
            ]
            behind = [Line("", unit.factor * twin.poses[:, p], style.GREY) for p in places if twin]
            return _Chart(style.labelled(label, unit), lines, behind, len(chosen) - len(places))
    return _Chart("", [])


def _controls_chart(model: mujoco.MjModel, frames: Frames, forces: EngineeringUnit) -> _Chart:
    """Controls that change; those that are forces in the unit of the tensions."""
    moving = [k for k in range(model.nu) if np.ptp(frames.controls[:, k]) > 0.0]
    shown = moving[:_MOST_LINES]
    alike: dict[str, list[int]] = {}  # SI unit → controls in it
    for k in shown:
        alike.setdefault(control_unit(model, k), []).append(k)
    units = {
        si: forces if si == "N" else engineering_unit(si, frames.controls[:, ks].ravel())
        for si, ks in alike.items()
    }
    lines, tendons, known = [], tendon_colours(model, frames.cables), sheaths(model)
    for colour, k in zip(_OTHER_COLOURS, shown, strict=False):
        name, unit = model.actuator(k).name or f"actuator {k}", units[control_unit(model, k)]
        values = unit.factor * frames.controls[:, k]
        of_tendon = (c for sheath, c in tendons.items() if name.startswith(known[sheath].tendon))
        entry = name if len(units) == 1 else style.labelled(name, unit)
        lines.append(Line(entry, values, next(of_tendon, colour)))
    label = style.labelled("control", *(units.values() if len(units) == 1 else ()))
    return _Chart(label, lines, left_out=len(moving) - len(shown))
