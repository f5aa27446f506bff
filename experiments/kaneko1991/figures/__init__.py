"""Pictures of the reproduction: data in, figures out."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from matplotlib.figure import Figure

from experiments.kaneko1991.figures.agreement import draw_agreement, draw_refinement
from experiments.kaneko1991.figures.cost import draw_costs
from experiments.kaneko1991.figures.figure_4 import draw_figure_4a, draw_figure_4bc
from experiments.kaneko1991.figures.figure_5 import draw_figure_5
from experiments.kaneko1991.figures.static_friction import draw_shift
from experiments.kaneko1991.reproduction import Reproduction


def draw_figures(found: Reproduction) -> Iterator[tuple[str, Figure]]:
    """Yield each picture's name and figure."""
    slow, fast = found.figure_4bc.loops
    drawings: dict[str, Callable[[], Figure]] = {
        "agreement": lambda: draw_agreement(found.agreement),
        "refinement": lambda: draw_refinement(found.refinement),
        "figure_4a": lambda: draw_figure_4a(found.figure_4a),
        "figure_4b": lambda: draw_figure_4bc(found.figure_4bc, slow, "b"),
        "figure_4c": lambda: draw_figure_4bc(found.figure_4bc, fast, "c"),
        "stiction": lambda: draw_shift(found.figure_4bc),
        "figure_5": lambda: draw_figure_5(found.figure_5),
        "cost": lambda: draw_costs(found.costs),
    }
    for name, draw in drawings.items():
        yield name, draw()
