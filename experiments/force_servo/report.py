"""Report of the study: result.json, summary."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from experiments.force_servo.gain_scheduling import GainScheduling
from experiments.force_servo.limit_cycle import LimitCycles
from experiments.force_servo.linear_theory import mode
from experiments.force_servo.phase_plane import PhasePlane
from experiments.force_servo.staircase import Staircase
from experiments.force_servo.study import Study
from experiments.force_servo.tracking import Tracking


def result(study: Study) -> dict[str, object]:
    """Nested dictionary of numbers in SI units; shares are ratios, not percent."""
    return {
        "overshoot": _overshoots(study.gains),
        "overshoot_held_output": _overshoots(study.gains_output_held),
        "phase_plane": _phase_plane(study.phase_plane),
        "fig7": _staircase(study.staircase),
        "limit_cycle": _limit_cycles(study.limit_cycles),
        "tracking": _tracking(study.tracking),
    }


def _overshoots(gain_scheduling: GainScheduling) -> dict[str, object]:
    pull, loose, pull_back, loose_back = gain_scheduling.plain_steps
    numbers: dict[str, object] = {
        "pulling": pull.overshoot,
        "loosening": loose.overshoot,
        "loosening_predicted": loose.predicted_overshoot,
        "pulling_after_reversal": pull_back.overshoot,
        "loosening_after_reversal": loose_back.overshoot,
        "loosening_after_reversal_predicted": loose_back.predicted_overshoot,
        "scheduled_difference_cut": gain_scheduling.difference_cut(False),
        "scheduled_difference_cut_after_reversal": gain_scheduling.difference_cut(True),
    }
    for name, plain, better in zip(
        ("pulling", "loosening", "pulling_after_reversal", "loosening_after_reversal"),
        gain_scheduling.plain_steps,
        gain_scheduling.scheduled_steps,
        strict=True,
    ):
        numbers[f"scheduled_{name}"] = better.overshoot
        numbers[f"scheduled_rise_ratio_{name}"] = better.rise / plain.rise
    return numbers


def _staircase(staircase: Staircase) -> dict[str, object]:
    modes = {way: mode(staircase.bench, staircase.paper, way).damping for way in (1, -1)}
    return {
        "damping": {"pulling": modes[1], "loosening": modes[-1]},
        "overshoot": staircase.overshoots(staircase.paper_response).tolist(),
        "overshoot_critical": staircase.overshoots(staircase.critical_response).tolist(),
        "critical_velocity_gain": staircase.critical.velocity_gain,
        "motor_inertia_kg_m2": staircase.paper.inertia,
        "radius_m": staircase.paper.radius,
    }


def _phase_plane(phase_plane: PhasePlane) -> dict[str, object]:
    pulling, loosening = phase_plane.lines
    return {
        "slope_error": {"pulling": pulling.error, "loosening": loosening.error},
        "slope": {"pulling": pulling.slope, "loosening": loosening.slope},
    }


def _limit_cycles(limit_cycles: LimitCycles) -> dict[str, object]:
    _, amplitude, predicted = limit_cycles.columns()
    return {
        "r_squared": limit_cycles.r_squared,
        "factor": limit_cycles.factor,
        "intercept_m": limit_cycles.intercept,
        "intercept_over_mean_amplitude": limit_cycles.intercept / float(amplitude.mean()),
        "describing_function_mean_ratio": float(np.mean(predicted / amplitude)),
        "describing_function_max_error": float(np.max(np.abs(predicted / amplitude - 1.0))),
    }


def _tracking(tracking: Tracking) -> dict[str, object]:
    return {
        "rmse_reduction": tracking.reduction("feedforward"),
        "rmse_N": tracking.rmse,
        "reduction": {name: tracking.reduction(name) for name in tracking.responses},
    }


def summary(study: Study) -> Iterator[str]:
    """Yield the lines."""
    yield _steps("bench", study.gains)
    yield _steps("output held", study.gains_output_held)
    for line in study.phase_plane.lines:
        direction = "pulling" if line.direction > 0 else "loosening"
        yield f"phase plane, {direction}: slope within {abs(line.error):.2%} of ω/2ζ"
    cycles = study.limit_cycles
    yield f"limit cycle: amplitude {cycles.factor:.2f} ξ_B, R² {cycles.r_squared:.4f}"
    tracking = study.tracking
    for name in tracking.responses:
        share = 1.0 - tracking.reduction(name)
        yield (
            f"sine, {name.replace('_', ' ')}: {tracking.rmse[name]:.3f} N rms, "
            f"{share:.1%} of the frictionless inverse's"
        )


def _steps(where: str, gain_scheduling: GainScheduling) -> str:
    pull, loose, _, loose_back = gain_scheduling.plain_steps
    return (
        f"{where}, critical for pulling: overshoot {pull.overshoot:.3%} pulling, "
        f"{loose.overshoot:.2%} loosening (linear theory {loose.predicted_overshoot:.2%}), "
        f"{loose_back.overshoot:.2%} loosening after a reversal, where the motor leaves the "
        f"backlash with speed (theory {loose_back.predicted_overshoot:.2%}); scheduled gains cut "
        f"the difference by {gain_scheduling.difference_cut(False):.0%}"
    )
