"""Pictures of the study: data in, figures out."""

from __future__ import annotations

from collections.abc import Iterator

from matplotlib.figure import Figure

from experiments.positioning_system.figures.friction import draw_friction
from experiments.positioning_system.figures.residual import draw_residual
from experiments.positioning_system.study import Study


def draw_figures(found: Study) -> Iterator[tuple[str, Figure]]:
    """Yield each picture's name and figure."""
    yield "friction", draw_friction(found)
    yield "residual", draw_residual(found)
