"""Plain numbers of the reproduction, for `result.json`."""

from __future__ import annotations

import dataclasses
from typing import Any

from experiments.kaneko1991.agreement import Agreement
from experiments.kaneko1991.figure_4a import Figure4a
from experiments.kaneko1991.figure_4bc import Figure4bc, Shift
from experiments.kaneko1991.figure_5 import BOUND, Figure5
from experiments.kaneko1991.refinement import Refinement
from experiments.kaneko1991.reproduction import Reproduction


def result(found: Reproduction) -> dict[str, Any]:
    """Nested dictionary of numbers in SI units; shares of a range are ratios, not percent."""
    return {
        "agreement": _agreement(found.agreement),
        "refinement": _refinement(found.refinement),
        "figure_4a": _figure_4a(found.figure_4a),
        "figure_4bc": _figure_4bc(found.figure_4bc),
        "figure_5": _figure_5(found.figure_5),
        "seconds_per_simulated_second": {c.route: c.seconds for c in found.costs},
        "cost": [dataclasses.asdict(c) for c in found.costs],
    }


def _refinement(found: Refinement) -> dict[str, Any]:
    return {
        "elements": found.elements.tolist(),
        "rms_error_of_range": {name: values.tolist() for name, values in found.error.items()},
        "order": found.order,
    }


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
        "slope_error_by_route": {name: found.slope_errors(name) for name in found.measured},
        "theory": dataclasses.asdict(found.predicted),
        "loops": {name: dataclasses.asdict(n) for name, n in found.measured.items()},
        "departure_from_line_without_friction": found.nonlinearity,
        "max_difference_of_range": found.largest,
    }


def _figure_4bc(found: Figure4bc) -> dict[str, Any]:
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
    dynamics = dataclasses.asdict(found.dynamics)
    dynamics["steps"] = list(dynamics["steps"])
    return {
        "tendon": dynamics,
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
            "constant_friction": tendon.constant_friction,
            "theory": dataclasses.asdict(predicted),
            "loops": {name: dataclasses.asdict(n) for name, n in measured.items()},
            "max_difference_of_range": largest,
        }
        for tendon, predicted, measured, largest in zip(
            found.tendons, found.predicted, found.measured, found.largest, strict=True
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
