"""Pictures of the study: data in, figures out."""

from __future__ import annotations

from collections.abc import Iterator

from matplotlib.figure import Figure

from experiments.force_servo.figures.limit_cycle import draw_limit_cycles
from experiments.force_servo.figures.phase_plane import draw_phase_plane
from experiments.force_servo.figures.staircase import draw_staircase
from experiments.force_servo.figures.strategies import draw_strategies
from experiments.force_servo.study import Study


def draw_figures(found: Study) -> Iterator[tuple[str, Figure]]:
    """Yield each picture's name and figure."""
    yield "fig6_phase_plane", draw_phase_plane(found.phase_plane)
    yield "fig7_steps", draw_staircase(found.staircase)
    yield "limit_cycle", draw_limit_cycles(found.limit_cycles)
    yield "strategies", draw_strategies(found.gains_output_held, found.tracking)
