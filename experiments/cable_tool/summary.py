"""Summary of the study in a few lines of text."""

from __future__ import annotations

import math
from collections.abc import Iterator

from experiments.cable_tool import asked
from experiments.cable_tool.result import mean_and_worst
from experiments.cable_tool.study import Study


def summary(found: Study) -> Iterator[str]:
    """Yield the lines."""
    tool = found.tool
    low, high = found.intervals.get("friction_exponent", (math.nan, math.nan))
    yield (
        f"load-proportional part: sheath friction, λ = {tool.friction_exponent:.3f} "
        f"({low:.3f} … {high:.3f}), ratio e^λ = {math.exp(tool.friction_exponent):.2f} one way"
    )
    for what, left_out, group in (
        ("loads left out", "load", "straight"),
        ("wrist pitch left out", "pose", "pitch"),
        ("roll left out", "pose", "roll"),
    ):
        torque = mean_and_worst(found.chosen(left_out, group), "torque")
        angle = mean_and_worst(found.chosen(left_out, group), "angle")
        if torque and angle:
            yield (
                f"{what}: {1e3 * torque[0]:.2f} mN m rms, worst {1e3 * torque[1]:.2f} "
                f"(asked {1e3 * asked.TORQUE_ASKED:g}), "
                f"{math.degrees(angle[0]):.2f}° with its mean apart"
            )
    for pair in found.rates:
        yield (
            f"friction at {pair.load_share:.0%} load, {pair.speeds[1] / pair.speeds[0]:.1f} times "
            f"as fast: {pair.change:+.1%} (asked within {asked.RATE_ASKED:.0%})"
        )
