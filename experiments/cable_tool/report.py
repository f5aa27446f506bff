"""Report of the study: result.json, summary and table."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence

import numpy as np

from experiments.cable_tool.candidates import CANDIDATES, CHOSEN
from experiments.cable_tool.cross_validation import LEFT_OUT, HeldOut, root_mean_square
from experiments.cable_tool.study import Study

GROUPS = ("straight", "pitch", "roll")
_ERRORS = ("torque", "torque_sliding", "torque_variation", "angle", "angle_zeroed")
_COLUMNS = (
    ("loads, straight wrist", "load", "straight"),
    ("pitch", "pose", "pitch"),
    ("roll", "pose", "roll"),
    ("faster sine", "rate", "straight"),
)
TORQUE_ASKED = 6e-3  # error on loads and wrist poses left out [N m]
RATE_ASKED = 0.06  # change of friction over a threefold rate [-]
# neural network on motor current and encoder, O'Neill, Stephens and Kowalewski, 2018
TORQUE_PUBLISHED = 4.42e-3  # [N m]
ANGLE_PUBLISHED = math.radians(0.37)  # [rad]


def result(study: Study) -> dict[str, object]:
    """Nested dictionary of numbers in SI units."""
    tool = {k: v for k, v in dataclasses.asdict(study.tool).items() if v is not None}
    return {
        "asked": {"torque_Nm": TORQUE_ASKED, "rate": RATE_ASKED},
        "published": {"torque_Nm": TORQUE_PUBLISHED, "angle_rad": ANGLE_PUBLISHED},
        "numbers": {
            name: {"value": value, "interval": study.intervals.get(name)}
            for name, value in tool.items()
        },
        "held_out": {
            candidate.name: {"numbers": candidate.numbers}
            | {left: _folds(study.held_out[candidate.name][left]) for left in LEFT_OUT}
            for candidate in CANDIDATES
        },
        "load_share": [
            dataclasses.asdict(share)
            | {"friction_exponent_of_the_fit": _exponent(study, share.pose)}
            for share in study.load_shares
        ],
        "rate": [dataclasses.asdict(pair) | {"change": pair.change} for pair in study.rates],
        "recordings": {
            r.name: {
                "torque_in_sample": root_mean_square(study.tool.load(r) - r.load),
                "load_mean": float(r.load.mean()),
                "load_variation": float(r.load.std()),
                "opening_offset": study.tool.opening(r),
            }
            for r in study.recordings
        },
    }


def mean_and_worst(errors: Sequence[HeldOut], name: str) -> tuple[float, float] | None:
    """Mean and largest of one kind of error; None if a model has no such error."""
    values = [getattr(one, name) for one in errors]
    known = [value for value in values if value is not None]
    return (float(np.mean(known)), float(np.max(known))) if known else None


def _exponent(study: Study, pose: str) -> float:
    return next(study.tool.exponent(r) for r in study.recordings if r.pose == pose)


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


def summary(study: Study) -> Iterator[str]:
    """Yield the lines."""
    tool = study.tool
    low, high = study.intervals.get("friction_exponent", (math.nan, math.nan))
    yield (
        f"load-proportional part: sheath friction, λ = {tool.friction_exponent:.3f} "
        f"({low:.3f} … {high:.3f}), ratio e^λ = {math.exp(tool.friction_exponent):.2f} one way"
    )
    for what, left_out, group in (
        ("loads left out", "load", "straight"),
        ("wrist pitch left out", "pose", "pitch"),
        ("roll left out", "pose", "roll"),
    ):
        torque = mean_and_worst(study.chosen(left_out, group), "torque")
        angle = mean_and_worst(study.chosen(left_out, group), "angle")
        if torque and angle:
            yield (
                f"{what}: {1e3 * torque[0]:.2f} mN m rms, worst {1e3 * torque[1]:.2f} "
                f"(asked {1e3 * TORQUE_ASKED:g}), "
                f"{math.degrees(angle[0]):.2f}° with its mean apart"
            )
    for pair in study.rates:
        yield (
            f"friction at {pair.load_share:.0%} load, {pair.speeds[1] / pair.speeds[0]:.1f} times "
            f"as fast: {pair.change:+.1%} (asked within {RATE_ASKED:.0%})"
        )


def table(study: Study) -> str:
    """The whole page."""
    return "\n".join([*_errors(study), "", *_numbers(study), "", *_shares(study), ""])


def _errors(study: Study) -> Iterator[str]:
    names = " | ".join(name for name, *_ in _COLUMNS)
    yield f"| left out: torque error, mean (worst) [mN m] | numbers | {names} |"
    yield "|---" * (2 + len(_COLUMNS)) + "|"
    for kind, where in (("torque", ""), ("torque_sliding", ", where the output slides")):
        for candidate in CANDIDATES:
            cells = [
                _cell(study.errors(candidate.name, left_out, group), kind, 1e3)
                for _, left_out, group in _COLUMNS
            ]
            yield f"| {candidate.name}{where} | {candidate.numbers} | {' | '.join(cells)} |"
    network = f"{1e3 * TORQUE_PUBLISHED:.2f}, {math.degrees(ANGLE_PUBLISHED):.2f}°"
    yield f"| published neural network, other recordings | – | {' | '.join([network] * 4)} |"
    for kind, what in (
        ("angle", "output angle, its mean apart"),
        ("angle_zeroed", "output angle, zero from fitted recordings"),
    ):
        cells = [
            _cell(study.errors(CHOSEN, left_out, group), kind, math.degrees(1.0))
            for _, left_out, group in _COLUMNS
        ]
        yield f"| {CHOSEN}: {what} [°] | 8 | {' | '.join(cells)} |"


def _cell(errors: Sequence[HeldOut], name: str, scale: float) -> str:
    pair = mean_and_worst(errors, name)
    return f"{scale * pair[0]:.2f} ({scale * pair[1]:.2f})" if pair else "–"


def _numbers(study: Study) -> Iterator[str]:
    units = {
        "friction_exponent": "λ [-]",
        "wrist_friction": "dλ/dpitch [1/rad]",
        "closing_offset": "b_c [N m]",
        "load_difference": "D [N m]",
        "stiffness": "k [N m/rad]",
        "take_up": "w [rad]",
        "angle_ratio": "ρ [-]",
        "compliance": "C [rad/(N m)]",
    }
    yield "| number | value | 95 % |"
    yield "|---|---|---|"
    for name, unit in units.items():
        low, high = study.intervals.get(name, (math.nan, math.nan))
        interval = f"{low:.4f} … {high:.4f}" if math.isfinite(low) else "–"
        yield f"| `{name}`, {unit} | {getattr(study.tool, name):.4f} | {interval} |"


def _shares(study: Study) -> Iterator[str]:
    yield "| wrist | λ, mid-stroke | 95 % | ϱ | constant friction [mN m] | zero [mN m] |"
    yield "|---|---|---|---|---|---|"
    for share in study.load_shares:
        low, high = share.exponent_interval
        yield (
            f"| {share.pose} | {share.exponent:.3f} | {low:.3f} … {high:.3f} "
            f"| {share.radius_ratio:.3f} | {1e3 * share.constant_friction:.1f} "
            f"| {1e3 * share.zero:.1f} |"
        )
