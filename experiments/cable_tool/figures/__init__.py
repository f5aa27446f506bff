"""Pictures of the study: data in, figures out."""

from __future__ import annotations

from collections.abc import Iterator

from matplotlib.figure import Figure

from experiments.cable_tool.figures.held_out import draw_held_out
from experiments.cable_tool.figures.prediction import draw_prediction
from experiments.cable_tool.figures.residual import draw_residual
from experiments.cable_tool.figures.sheath_friction import draw_sheath_friction
from experiments.cable_tool.study import Study


def draw_figures(found: Study) -> Iterator[tuple[str, Figure]]:
    """Yield each picture's name and figure."""
    yield "sheath_friction", draw_sheath_friction(found)
    yield "prediction", draw_prediction(found)
    yield "held_out", draw_held_out(found)
    yield "residual", draw_residual(found)
