"""Plain numbers of the study, for `result.json`: SI units, angles in radians."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from experiments.cable_tool import asked
from experiments.cable_tool.candidates import CANDIDATES
from experiments.cable_tool.cross_validation import LEFT_OUT, HeldOut, root_mean_square
from experiments.cable_tool.study import Study

GROUPS = ("straight", "pitch", "roll")
_ERRORS = ("torque", "torque_sliding", "torque_variation", "angle", "angle_zeroed")


def result(found: Study) -> dict[str, object]:
    """Nested dictionary of numbers in SI units."""
    tool = {k: v for k, v in dataclasses.asdict(found.tool).items() if v is not None}
    return {
        "asked": {"torque_Nm": asked.TORQUE_ASKED, "rate": asked.RATE_ASKED},
        "published": {"torque_Nm": asked.TORQUE_PUBLISHED, "angle_rad": asked.ANGLE_PUBLISHED},
        "numbers": {
            name: {"value": value, "interval": found.intervals.get(name)}
            for name, value in tool.items()
        },
        "held_out": {
            candidate.name: {"numbers": candidate.numbers}
            | {left: _folds(found.held_out[candidate.name][left]) for left in LEFT_OUT}
            for candidate in CANDIDATES
        },
        "load_share": [
            dataclasses.asdict(share)
            | {"friction_exponent_of_the_fit": _exponent(found, share.pose)}
            for share in found.load_shares
        ],
        "rate": [dataclasses.asdict(pair) | {"change": pair.change} for pair in found.rates],
        "recordings": {
            r.name: {
                "torque_in_sample": root_mean_square(found.tool.load(r) - r.load),
                "load_mean": float(r.load.mean()),
                "load_variation": float(r.load.std()),
                "opening_offset": found.tool.opening(r),
            }
            for r in found.recordings
        },
    }


def mean_and_worst(errors: Sequence[HeldOut], name: str) -> tuple[float, float] | None:
    """Mean and largest of one kind of error; None where a model has no such error."""
    values = [getattr(one, name) for one in errors]
    known = [value for value in values if value is not None]
    return (float(np.mean(known)), float(np.max(known))) if known else None


def _exponent(found: Study, pose: str) -> float:
    return next(found.tool.exponent(r) for r in found.recordings if r.pose == pose)


def _folds(errors: Sequence[HeldOut]) -> dict[str, object]:
    groups = {group: [one for one in errors if one.group == group] for group in GROUPS}
    return {
        "groups": {
            group: {
                name: dict(zip(("mean", "worst"), pair, strict=True))
                for name in _ERRORS
                if (pair := mean_and_worst(mine, name))
            }
            for group, mine in groups.items()
            if mine
        },
        "recordings": [dataclasses.asdict(one) for one in errors],
    }
