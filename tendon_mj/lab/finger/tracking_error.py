"""Tracking error of the finger: achieved − asked."""

from __future__ import annotations

import dataclasses

from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Misfit, replay_error
from tendon_mj.models import JOINTS, TENDONS


def tracking_error(answer: Recording) -> dict[str, Misfit]:
    """Misfit achieved − asked, of every joint angle or tension that a trajectory asked for.

    A tension is asked of the motor, so it is compared at the tendon's input, and at its output
    besides.

    Args:
        answer: as `simulate_finger` returns it.

    Returns:
        By the achieved column: `mcp_angle_rad`, …, or `flexor_input_tension_N`, ….
    """
    goals = {f"{joint}_angle_rad": f"asked_{joint}_rad" for joint in JOINTS}
    goals |= {
        f"{tendon}_{end}_tension_N": f"asked_{tendon}_N"
        for tendon in TENDONS
        for end in ("input", "output")
    }
    goals = {column: goal for column, goal in goals.items() if goal in answer.columns}
    wanted = dataclasses.replace(
        answer,
        columns={**answer.columns, **{c: answer.columns[goal] for c, goal in goals.items()}},
        measured={column: answer.measured[column] for column in goals},
    )
    return replay_error(wanted, answer)
