"""The paper reproduced as a whole: everything is computed here, nothing drawn."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

from experiments.kaneko1991.agreement import (
    Agreement,
    Refinement,
    agree,
    check_histories,
    refine,
)
from experiments.kaneko1991.cost import Cost, cost
from experiments.kaneko1991.figure4 import Figure4a, figure_4a
from experiments.kaneko1991.figure5 import BOUND, Figure5, figure_5
from experiments.kaneko1991.stiction import Shift, Stiction, stiction
from tendon_mj.progress import Progress, silent


@dataclass(frozen=True, eq=False)
class Paper:
    """What the reproduction found.

    Args:
        agreement: of the routes on many histories.
        refinement: of each route towards the closed form.
        figure4a: the slow loop with μ_s = μ_d.
        stiction: Fig. 4 (b) and (c).
        figure5: with and without tension-independent friction.
        costs: wall time by route.
    """

    agreement: Agreement
    refinement: Refinement
    figure4a: Figure4a
    stiction: Stiction
    figure5: Figure5
    costs: tuple[Cost, ...]

    def result(self) -> dict[str, Any]:
        """Plain numbers in SI units, for `result.json`."""
        return {
            "agreement": _agreement(self.agreement),
            "refinement": {
                "elements": self.refinement.elements.tolist(),
                "rms_error_of_range": {k: v.tolist() for k, v in self.refinement.error.items()},
                "order": self.refinement.order,
            },
            "figure_4a": _figure_4a(self.figure4a),
            "figure_4bc": _stiction(self.stiction),
            "figure_5": _figure_5(self.figure5),
            "seconds_per_simulated_second": {c.route: c.seconds for c in self.costs},
            "cost": [dataclasses.asdict(c) for c in self.costs],
        }


def reproduce(histories: int = 100, progress: Progress = silent) -> Paper:
    """Simulate all of it; about a minute and a half on two cores.

    Raises:
        InvalidValueError: fewer than 0 histories.
    """
    check_histories(histories)
    # the wall times first, while the process has done nothing else
    costs = cost(progress)
    return Paper(
        agreement=agree(histories, progress=progress),
        refinement=refine(progress=progress),
        figure4a=figure_4a(progress),
        stiction=stiction(progress),
        figure5=figure_5(progress),
        costs=costs,
    )


def _agreement(found: Agreement) -> dict[str, Any]:
    pairs = [(i, j) for i in range(len(found.routes)) for j in range(i)]
    return {
        "max_difference_of_range": found.largest,
        "max_difference_of_input_tension_of_range": found.largest_input,
        "random_histories": found.histories,
        **{
            key: {
                name: {
                    f"{found.routes[j]} / {found.routes[i]}": float(table[i, j]) for i, j in pairs
                }
                for name, table in tables.items()
            }
            for key, tables in (
                ("by_history", found.difference),
                ("input_tension_by_history", found.input_difference),
            )
        },
    }


def _figure_4a(found: Figure4a) -> dict[str, Any]:
    return {
        "slope_error": found.slope_error,
        "slope_error_by_route": {name: found.slope_errors(name) for name in found.numbers},
        "theory": dataclasses.asdict(found.theory),
        "loops": {name: dataclasses.asdict(n) for name, n in found.numbers.items()},
        "departure_from_line_without_friction": found.straight,
        "max_difference_of_range": found.largest,
    }


def _stiction(found: Stiction) -> dict[str, Any]:
    return {
        "shift_of_range": [_shift(s) for s in found.shifts],
        "switch_phase_of_closed_form": found.switches,
        "quasi_static": {
            "guides": found.guides.tolist(),
            "shift_of_range": found.quasi_static.tolist(),
            "one_guide_of_range": found.one_guide.tolist(),
            "phase_of_period": found.quasi_static_phase.tolist(),
            "plugin_less_sheath_alone_of_range": found.plugin_difference,
        },
    }


def _shift(found: Shift) -> dict[str, Any]:
    tendon = dataclasses.asdict(found.tendon)
    tendon["steps"] = list(tendon["steps"])
    return {
        "tendon": tendon,
        "frequency": found.frequency,
        "mean": float(found.largest.mean()),
        "least": float(found.largest.min()),
        "most": float(found.largest.max()),
        "mean_by_step": found.largest.mean(1).tolist(),
        "by_step_and_period": found.largest.tolist(),
        "phase_by_step_and_period": found.phase.tolist(),
        "mean_rms": float(found.rms.mean()),
        "drag": found.drag,
    }


def _figure_5(found: Figure5) -> dict[str, Any]:
    loops = [
        {
            "constant_friction": rig.constant_friction,
            "theory": dataclasses.asdict(theory),
            "loops": {name: dataclasses.asdict(n) for name, n in numbers.items()},
            "max_difference_of_range": largest,
        }
        for rig, theory, numbers, largest in zip(
            found.rigs, found.theory, found.numbers, found.largest, strict=True
        )
    ]
    return {
        "loops": loops,
        "widening_by_constant_friction": {
            f"{1e3 * travel:g} mm": found.widening_at(travel)
            for travel in (0.5 * BOUND, BOUND, 2 * BOUND, 6 * BOUND)
        },
        "departure_by_constant_friction": dataclasses.asdict(found.departure),
    }
