"""The whole study: fit, intervals, cross-validation; computes everything, draws nothing."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from experiments.cable_tool.candidates import CANDIDATES, CHOSEN
from experiments.cable_tool.cross_validation import LEFT_OUT, HeldOut, cross_validate
from experiments.cable_tool.fit import fit_tool
from experiments.cable_tool.load_share import LoadShare, load_share
from experiments.cable_tool.recording import ToolRecording
from experiments.cable_tool.tool import RateRatio, Tool, rate_ratios
from tendon_mj.lab.progress import Progress, silent

_QUANTILES = (0.025, 0.975)


@dataclass(frozen=True)
class Study:
    """Findings.

    Attributes:
        recordings: on which they rest.
        tool: fitted to all of them.
        intervals: 95 % interval of every number of the tool, recordings resampled within poses.
        held_out: candidate → split (`LEFT_OUT`) → errors.
        load_shares: of every wrist pose.
        rates: pairs of recordings at different rates.
    """

    recordings: list[ToolRecording]
    tool: Tool
    intervals: dict[str, tuple[float, float]]
    held_out: dict[str, dict[str, list[HeldOut]]]
    load_shares: list[LoadShare]
    rates: list[RateRatio]

    def chosen(self, left_out: str, *groups: str) -> list[HeldOut]:
        """Errors of the chosen model on some groups of recordings; on all, if none is named."""
        return self.errors(CHOSEN, left_out, *groups)

    def errors(self, candidate: str, left_out: str, *groups: str) -> list[HeldOut]:
        """Errors of a candidate on some groups of recordings; on all, if none is named."""
        result = self.held_out[candidate][left_out]
        return [one for one in result if not groups or one.group in groups]


def run_study(
    recordings: Sequence[ToolRecording], resamples: int = 100, progress: Progress = silent
) -> Study:
    """Run every part.

    Args:
        recordings: of the rig, with several loads and poses.
        resamples: fits from which the intervals come.
        progress: called with the stage, the number done and the total.
    """
    held_out = {
        candidate.name: {
            left_out: cross_validate(candidate, recordings, left_out, progress)
            for left_out in LEFT_OUT
        }
        for candidate in CANDIDATES
    }
    poses = sorted({r.pose for r in recordings})
    return Study(
        list(recordings),
        fit_tool(recordings),
        _intervals(recordings, resamples, progress),
        held_out,
        [load_share(recordings, pose) for pose in poses],
        rate_ratios(recordings),
    )


def _intervals(
    recordings: Sequence[ToolRecording], resamples: int, progress: Progress
) -> dict[str, tuple[float, float]]:
    rng = np.random.default_rng(0)
    by_pose = [
        [r for r in recordings if r.pose == pose] for pose in sorted({r.pose for r in recordings})
    ]
    tools = []
    for done in range(resamples):
        progress("intervals", done, resamples)
        drawn = [mine[k] for mine in by_pose for k in rng.integers(len(mine), size=len(mine))]
        tools.append(dataclasses.asdict(fit_tool(drawn)))
    progress("intervals", resamples, resamples)
    intervals = {}
    for name, value in (tools[0] if tools else {}).items():
        if value is not None:
            low, high = np.quantile([tool[name] for tool in tools], _QUANTILES)
            intervals[name] = (float(low), float(high))
    return intervals
