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


def result(reproduction: Reproduction) -> dict[str, Any]:
    """Nested dictionary of numbers in SI units; shares of a range are ratios, not percent."""
    return {
        "agreement": _agreement(reproduction.agreement),
        "refinement": _refinement(reproduction.refinement),
        "figure_4a": _figure_4a(reproduction.figure_4a),
        "figure_4bc": _figure_4bc(reproduction.figure_4bc),
        "figure_5": _figure_5(reproduction.figure_5),
        "seconds_per_simulated_second": {c.route: c.seconds for c in reproduction.costs},
        "cost": [dataclasses.asdict(c) for c in reproduction.costs],
    }


def _refinement(refinement: Refinement) -> dict[str, Any]:
    return {
        "elements": refinement.elements.tolist(),
        "rms_error_of_range": {name: values.tolist() for name, values in refinement.error.items()},
        "order": refinement.order,
    }


def _agreement(agreement: Agreement) -> dict[str, Any]:
    pairs = [(i, j) for i in range(len(agreement.routes)) for j in range(i)]
    return {
        "max_difference_of_range": agreement.largest,
        "max_difference_of_input_tension_of_range": agreement.largest_input,
        "random_histories": agreement.histories,
        **{
            key: {
                name: {
                    f"{agreement.routes[j]} / {agreement.routes[i]}": float(table[i, j])
                    for i, j in pairs
                }
                for name, table in tables.items()
            }
            for key, tables in (
                ("by_history", agreement.difference),
                ("input_tension_by_history", agreement.input_difference),
            )
        },
    }


def _figure_4a(data: Figure4a) -> dict[str, Any]:
    return {
        "slope_error": data.slope_error,
        "slope_error_by_route": {name: data.slope_errors(name) for name in data.measured},
        "theory": dataclasses.asdict(data.predicted),
        "loops": {name: dataclasses.asdict(n) for name, n in data.measured.items()},
        "departure_from_line_without_friction": data.nonlinearity,
        "max_difference_of_range": data.largest,
    }


def _figure_4bc(data: Figure4bc) -> dict[str, Any]:
    return {
        "shift_of_range": [_shift(s) for s in data.shifts],
        "switch_phase_of_closed_form": data.switches,
        "quasi_static": {
            "guides": data.guides.tolist(),
            "shift_of_range": data.quasi_static.tolist(),
            "one_guide_of_range": data.one_guide.tolist(),
            "phase_of_period": data.quasi_static_phase.tolist(),
            "plugin_less_sheath_alone_of_range": data.plugin_difference,
        },
    }


def _shift(shift: Shift) -> dict[str, Any]:
    dynamics = dataclasses.asdict(shift.dynamics)
    dynamics["steps"] = list(dynamics["steps"])
    return {
        "tendon": dynamics,
        "frequency": shift.frequency,
        "mean": float(shift.largest.mean()),
        "least": float(shift.largest.min()),
        "most": float(shift.largest.max()),
        "mean_by_step": shift.largest.mean(1).tolist(),
        "by_step_and_period": shift.largest.tolist(),
        "phase_by_step_and_period": shift.phase.tolist(),
        "mean_rms": float(shift.rms.mean()),
        "drag": shift.drag,
    }


def _figure_5(data: Figure5) -> dict[str, Any]:
    loops = [
        {
            "constant_friction": tendon.constant_friction,
            "theory": dataclasses.asdict(predicted),
            "loops": {name: dataclasses.asdict(n) for name, n in measured.items()},
            "max_difference_of_range": largest,
        }
        for tendon, predicted, measured, largest in zip(
            data.tendons, data.predicted, data.measured, data.largest, strict=True
        )
    ]
    return {
        "loops": loops,
        "widening_by_constant_friction": {
            f"{1e3 * travel:g} mm": data.widening_at(travel)
            for travel in (0.5 * BOUND, BOUND, 2 * BOUND, 6 * BOUND)
        },
        "departure_by_constant_friction": dataclasses.asdict(data.departure),
    }
