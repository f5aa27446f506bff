"""Summary of the study in a few lines of text."""

from __future__ import annotations

from collections.abc import Iterator

from experiments.force_servo.gain_scheduling import GainScheduling
from experiments.force_servo.study import Study


def summary(found: Study) -> Iterator[str]:
    """Yield the lines."""
    yield _steps("bench", found.gains)
    yield _steps("output held", found.gains_output_held)
    for line in found.phase_plane.lines:
        direction = "pulling" if line.direction > 0 else "loosening"
        yield f"phase plane, {direction}: slope within {abs(line.error):.2%} of ω/2ζ"
    cycles = found.limit_cycles
    yield f"limit cycle: amplitude {cycles.factor:.2f} ξ_B, R² {cycles.r_squared:.4f}"
    tracking = found.tracking
    for name in tracking.responses:
        share = 1.0 - tracking.reduction(name)
        yield (
            f"sine, {name.replace('_', ' ')}: {tracking.rmse[name]:.3f} N rms, "
            f"{share:.1%} of the frictionless inverse's"
        )


def _steps(where: str, found: GainScheduling) -> str:
    pull, loose, _, loose_back = found.plain_steps
    return (
        f"{where}, critical for pulling: overshoot {pull.overshoot:.3%} pulling, "
        f"{loose.overshoot:.2%} loosening (linear theory {loose.predicted_overshoot:.2%}), "
        f"{loose_back.overshoot:.2%} loosening after a reversal, where the motor leaves the "
        f"backlash with speed (theory {loose_back.predicted_overshoot:.2%}); scheduled gains cut "
        f"the difference by {found.difference_cut(False):.0%}"
    )
