"""Table of held-out errors in Markdown: every candidate beside the published figure."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from experiments.cable_tool import asked
from experiments.cable_tool.candidates import CANDIDATES, CHOSEN
from experiments.cable_tool.cross_validation import HeldOut
from experiments.cable_tool.result import mean_and_worst
from experiments.cable_tool.study import Study

_COLUMNS = (
    ("loads, straight wrist", "load", "straight"),
    ("pitch", "pose", "pitch"),
    ("roll", "pose", "roll"),
    ("faster sine", "rate", "straight"),
)


def table(found: Study) -> str:
    """The whole page."""
    return "\n".join([*_errors(found), "", *_numbers(found), "", *_shares(found), ""])


def _errors(found: Study) -> Iterator[str]:
    names = " | ".join(name for name, *_ in _COLUMNS)
    yield f"| left out: torque error, mean (worst) [mN m] | numbers | {names} |"
    yield "|---" * (2 + len(_COLUMNS)) + "|"
    for kind, where in (("torque", ""), ("torque_sliding", ", where the output slides")):
        for candidate in CANDIDATES:
            cells = [
                _cell(found.errors(candidate.name, left_out, group), kind, 1e3)
                for _, left_out, group in _COLUMNS
            ]
            yield f"| {candidate.name}{where} | {candidate.numbers} | {' | '.join(cells)} |"
    network = f"{1e3 * asked.TORQUE_PUBLISHED:.2f}, {math.degrees(asked.ANGLE_PUBLISHED):.2f}°"
    yield f"| published neural network, other recordings | – | {' | '.join([network] * 4)} |"
    for kind, what in (
        ("angle", "output angle, its mean apart"),
        ("angle_zeroed", "output angle, zero from fitted recordings"),
    ):
        cells = [
            _cell(found.errors(CHOSEN, left_out, group), kind, math.degrees(1.0))
            for _, left_out, group in _COLUMNS
        ]
        yield f"| {CHOSEN}: {what} [°] | 8 | {' | '.join(cells)} |"


def _cell(errors: Sequence[HeldOut], name: str, scale: float) -> str:
    pair = mean_and_worst(errors, name)
    return f"{scale * pair[0]:.2f} ({scale * pair[1]:.2f})" if pair else "–"


def _numbers(found: Study) -> Iterator[str]:
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
        low, high = found.intervals.get(name, (math.nan, math.nan))
        interval = f"{low:.4f} … {high:.4f}" if math.isfinite(low) else "–"
        yield f"| `{name}`, {unit} | {getattr(found.tool, name):.4f} | {interval} |"


def _shares(found: Study) -> Iterator[str]:
    yield "| wrist | λ, mid-stroke | 95 % | ϱ | constant friction [mN m] | zero [mN m] |"
    yield "|---|---|---|---|---|---|"
    for share in found.load_shares:
        low, high = share.exponent_interval
        yield (
            f"| {share.pose} | {share.exponent:.3f} | {low:.3f} … {high:.3f} "
            f"| {share.radius_ratio:.3f} | {1e3 * share.constant_friction:.1f} "
            f"| {1e3 * share.zero:.1f} |"
        )
