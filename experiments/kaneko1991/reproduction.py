"""Reproduction of the paper as a whole: computes everything, draws nothing."""

from __future__ import annotations

from dataclasses import dataclass

from experiments.kaneko1991.agreement import Agreement, check_histories, compare_routes
from experiments.kaneko1991.cost import Cost, measure_costs
from experiments.kaneko1991.figure_4a import Figure4a, simulate_figure_4a
from experiments.kaneko1991.figure_4bc import Figure4bc, simulate_figure_4bc
from experiments.kaneko1991.figure_5 import Figure5, simulate_figure_5
from experiments.kaneko1991.refinement import Refinement, refine
from tendon_mj.lab.progress import Progress, silent


@dataclass(frozen=True, eq=False)
class Reproduction:
    """Findings of the reproduction.

    Args:
        agreement: of the routes on many histories.
        refinement: of each route towards the closed form.
        figure_4a: slow loop with μ_s = μ_d.
        figure_4bc: shift of T_out by static friction.
        figure_5: without and with tension-independent friction.
        costs: wall time by route.
    """

    agreement: Agreement
    refinement: Refinement
    figure_4a: Figure4a
    figure_4bc: Figure4bc
    figure_5: Figure5
    costs: tuple[Cost, ...]


def reproduce(histories: int = 100, progress: Progress = silent) -> Reproduction:
    """Simulate everything; about two minutes on two cores.

    Args:
        histories: random histories that the routes are compared on, ≥ 0.
        progress: called with the stage, the number done and the total.

    Raises:
        InvalidValueError: fewer than 0 histories.
    """
    check_histories(histories)
    # the wall times first, while the process has done nothing else
    costs = measure_costs(progress)
    return Reproduction(
        agreement=compare_routes(histories, progress=progress),
        refinement=refine(progress=progress),
        figure_4a=simulate_figure_4a(progress),
        figure_4bc=simulate_figure_4bc(progress),
        figure_5=simulate_figure_5(progress),
        costs=costs,
    )
