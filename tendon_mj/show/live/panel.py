"""Tensions as text, the key of colours, and ranges of sliders, for windows and web pages alike."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from tendon_mj.lab.replay import engineering_unit
from tendon_mj.plugin import PARAMETERS
from tendon_mj.show.render.scene import COLOURS
from tendon_mj.typing import FloatArray

MOST_TENDONS = 6  # tendons that have curves
_DPI = 100
_FONT = 8  # [points]
_COLUMNS = 2  # of names: input and output of a tendon
# changed most, in the order in which they are shown; the others are folded away
FIRST = ("friction", "pretension", "backlash", "axial_stiffness")
_STEPS = 200
_WIDER = 3.0  # upper end of a slider over the model's value
# upper ends where the model's value is 0, of the order that real transmissions have
_TYPICAL = {
    "friction": 0.6,
    "static_friction": 0.6,
    "constant_friction": 5.0,
    "axial_stiffness": 20e3,
    "axial_damping": 100.0,
    "pretension": 40.0,
    "stribeck_friction": 0.3,
    "stribeck_velocity": 0.05,
    "viscous_friction": 100.0,
    "direction_asymmetry": 0.5,
    "friction_gradient": 1.0,
    "friction_drift": 0.1,
    "backlash": 0.005,
    "stiffening": 50.0,
    "creep": 0.5,
    "creep_time": 10.0,
    "sheath_compliance": 1e-4,
    "tendon_mass": 0.05,
    "extra_bend": math.pi,
    "slack": 0.01,
}


def tension_text(tendons: Sequence[str], tensions: FloatArray, time: float) -> tuple[str, str]:
    """Two columns of text: labels, and values of the (tendons, 2) tensions [N]."""
    left, right = ["time [s]"], [f"{time:.1f}"]
    for name, (first, last) in list(zip(tendons, tensions, strict=True))[:MOST_TENDONS]:
        left.append(f"{name}: input to output tension [N]")
        right.append(f"{first:.1f} to {last:.1f}")
    if len(tendons) > MOST_TENDONS:
        left.append(f"and {len(tendons) - MOST_TENDONS} more tendons")
        right.append("")
    return "\n".join(left), "\n".join(right)


def tension_table(tendons: Sequence[str], tensions: FloatArray, time: float) -> str:
    """Tensions as a table in Markdown; see `tension_text`."""
    rows = ["| tendon | input [N] | output [N] |", "|---|---|---|"]
    for name, (first, last) in zip(tendons, tensions, strict=True):
        rows.append(f"| {name} | {first:.2f} | {last:.2f} |")
    return "\n".join([*rows, "", f"time {time:.1f} s"])


def colour_key(
    limits: tuple[float, float],
    tendons: Sequence[str],
    colours: FloatArray,
    width: int,
    height: int,
) -> NDArray[np.uint8]:
    """(height, width, 3) picture of a horizontal colour bar, and lines with names.

    The bar ends at the tensions ``limits`` [N]; the curves of the named tendons at input and output
    have (tendons, 2, 3) colours, 0 to 1.
    """
    figure = Figure(figsize=(width / _DPI, height / _DPI), dpi=_DPI, layout="constrained")
    canvas: Any = FigureCanvasAgg(figure)
    scale = ScalarMappable(Normalize(*limits), COLOURS)
    bar = figure.colorbar(scale, cax=figure.add_subplot(), orientation="horizontal", extend="both")
    bar.set_label(
        "tension along the tendon [N], at the tips or beyond;\nmagenta: it slips over this guide",
        size=_FONT,
    )
    bar.ax.tick_params(labelsize=_FONT)
    lines = [
        Line2D([], [], color=colour, linewidth=2.5, label=f"{name} {end}")
        for name, both in zip(tendons, colours, strict=True)
        for colour, end in zip(both, ("input", "output"), strict=True)
    ]
    if lines:
        figure.legend(
            handles=lines,
            loc="outside lower center",
            ncols=_COLUMNS,
            fontsize=_FONT,
            frameon=False,
            handlelength=1.2,
            columnspacing=1.0,
        )
    canvas.draw()
    return np.array(canvas.buffer_rgba())[:, :, :3].copy()


def key_height(tendons: int) -> int:
    """Height that the picture of so many tendons' colours needs [pixels]."""
    return 92 + 17 * -(-2 * tendons // _COLUMNS)


class Slider(NamedTuple):
    """A slider of one live parameter of a sheath, in the unit of its label: ``factor`` over SI."""

    label: str
    hint: str
    low: float
    high: float
    step: float
    value: float
    factor: float


def slider(parameter: str, value: float) -> Slider | None:
    """The slider of a sheath's parameter that has this value [SI]; None for a radius."""
    if parameter not in _TYPICAL:
        return None
    known = PARAMETERS[parameter]
    high = _WIDER * abs(value)
    if value == 0.0 or parameter in ("friction", "static_friction"):
        high = max(high, _TYPICAL[parameter])
    step = high / _STEPS
    low = 0.0 if known.range.admits(0.0) else step
    if known.range.low < 0.0:
        low = max(-high, known.range.low + step)
    unit = engineering_unit(known.unit, [high])
    label = parameter.replace("_", " ") + (f" [{unit.symbol}]" if unit.symbol else "")
    low, high, step, value = (unit.factor * x for x in (low, high, step, value))
    return Slider(label, known.text, low, high, step, value, unit.factor)
