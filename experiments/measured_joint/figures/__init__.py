"""Pictures of the study: data in, figures out."""

from __future__ import annotations

from collections.abc import Iterator

from matplotlib.figure import Figure

from experiments.measured_joint.figures.held_out import draw_held_out
from experiments.measured_joint.figures.loops import draw_angles, draw_tensions
from experiments.measured_joint.study import Study


def draw_figures(found: Study) -> Iterator[tuple[str, Figure]]:
    """Yield each picture's name and figure."""
    yield "angle", draw_angles(found)
    yield "tension", draw_tensions(found)
    yield "held_out", draw_held_out(found)
