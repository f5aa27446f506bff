"""`python -m experiments.force_servo`: the force servo of Kaneko and others (1991), section 3."""

from __future__ import annotations

from pathlib import Path

import tyro

from experiments.force_servo.figures import cycles_figure, staircase_figure, strategies_figure
from experiments.force_servo.phase_plane_figure import phase_plane_figure
from experiments.force_servo.study import Study, study
from tendon_mj.cli.output import Output, console, progress_bar


def servo(out: Path = Path("out/force_servo")) -> dict[str, object]:
    """Servo the output tension through λ = 1.5: steps, phase plane, limit cycle, strategies.

    Args:
        out: folder for result.json and the pictures.
    """
    output = Output(out)
    with progress_bar() as progress:
        found = study(progress=progress)
    result = found.result()
    output.figure("fig6_phase_plane", phase_plane_figure(found.plane))
    output.figure("fig7_steps", staircase_figure(found.staircase))
    output.figure("limit_cycle", cycles_figure(found.cycles))
    output.figure("strategies", strategies_figure(found.held_steps, found.tracking))
    output.result(result)
    _say(found)
    output.close()
    return result


def _say(found: Study) -> None:
    for label, steps in (("bench", found.steps), ("output held", found.held_steps)):
        pull, loose, _, back = steps.plain_steps
        console.print(
            f"{label}, critical for pulling: overshoot {pull.overshoot:.3%} pulling, "
            f"{loose.overshoot:.2%} loosening (linear theory {loose.predicted_overshoot:.2%}), "
            f"{back.overshoot:.2%} loosening after a reversal, where the motor leaves the backlash "
            f"with speed (theory {back.predicted_overshoot:.2%}); scheduled gains cut the "
            f"difference by {steps.difference_cut(False):.0%}",
            soft_wrap=True,
        )
    for line in found.plane.lines:
        way = "pulling" if line.direction > 0 else "loosening"
        console.print(f"phase plane, {way}: slope within {abs(line.error):.2%} of ω₁/2ζ")
    console.print(
        f"limit cycle: amplitude {found.cycles.factor:.2f} ξ_B, R² {found.cycles.r_squared:.4f}"
    )
    tracking = found.tracking
    for name in tracking.responses:
        console.print(
            f"sine, {name.replace('_', ' ')}: {tracking.rmse[name]:.3f} N rms, "
            f"{1.0 - tracking.reduction(name):.1%} of the frictionless inverse's",
            soft_wrap=True,
        )


if __name__ == "__main__":
    tyro.cli(servo)
