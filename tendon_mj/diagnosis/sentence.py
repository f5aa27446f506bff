"""A verdict in words."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from tendon_mj.diagnosis.gap import Gap
from tendon_mj.diagnosis.verdict import Finding, Value, Verdict

_SLIPS = (
    " Where a tendon sticks and slips it may also be its values that were not found, or the steps"
    " that are too long."
)
_QUIET = 0.7  # times the noise: a model cannot be off by less, unless the noise is said too large
_COARSE = 1.5  # times what shorter steps would leave: worth saying
_PLAIN = 1.05  # times the noise: more wants a word on what the rest is put down to


def say(
    verdict: Verdict,
    findings: Sequence[Finding],
    gap: Gap,
    refined: float,
    least: float,
    beyond: Sequence[str],
    excluded: Sequence[str] = (),
    non_smooth: bool = False,
) -> str:
    """The verdict, where, and what it is worth on data that chose nothing.

    Args:
        verdict, findings: what was decided, and on what.
        gap: between calibrated and final model on those data, in the model's own steps.
        refined: what the final model would leave in ever shorter ones [noise].
        least: gap that is put down to the simulation [noise power].
        beyond: uncertain parameters that the explanation would take beyond their ranges.
        excluded: effects of the catalogue that were not to be considered.
        non_smooth: whether one of the findings is of a non-smooth effect.
    """
    if verdict == "nothing missing":
        return _nothing(gap, least)
    shrank = (
        f"on data that chose nothing the error goes from {gap.before:.2f} to {gap.after:.2f} times"
        f" the noise"
    )
    if gap.after > _COARSE * refined:
        shrank += f" ({refined:.2f} in ever shorter steps: the model's timestep is too long for it)"
    if gap.reducible_closed > 0.0:
        shrank += f", which closes {min(gap.reducible_closed, 1.0):.0%} of what could be closed"
    if verdict == "unknown":
        taken = f", and it would take {', '.join(beyond)} beyond its range" if beyond else ""
        closest = f" The closest is {_list(findings)}, but {shrank}{taken}."
        alone = f" On data that chose nothing the model is off by {gap.before:.2f} times the noise."
        without = f", without {', '.join(excluded)}," if excluded else ""
        return (
            f"Something is missing that the catalogue{without} does not hold."
            + (closest if findings else alone)
            + (_SLIPS if non_smooth else "")
        )
    missing = [finding for finding in findings if finding.kind == "missing"]
    wrong = [finding for finding in findings if finding.kind != "missing"]
    parts = [f"Missing: {_list(missing)}"] if missing else []
    if wrong:
        parts.append(f"{'a' if parts else 'A'} parameter was wrong: {_list(wrong)}")
    return f"{'; '.join(parts)}; {shrank}."


def doubt(calibrated: Mapping[str, Value]) -> str:
    """What to say of uncertain values that the data do not hold within their range."""
    return "".join(
        f" {name} stands at an end of its range, {value.low:g} … {value.high:g}{value.suffix}:"
        " if that is not the rig's limit, widen it."
        for name, value in calibrated.items()
        if value.at_end
    )


def _nothing(gap: Gap, least: float) -> str:
    said = f"Nothing is missing: calibrated, the model is off by {gap.before:.2f} times the noise"
    if gap.before > _PLAIN:
        said += (
            f"; up to {math.sqrt(1.0 + least):.2f} is put down to the simulation itself, its steps"
            " and its guides in place of a smooth sheath"
        )
    if gap.before < _QUIET:
        said += (
            ". No model is that good: the noise in [measured], or its estimate where none is"
            " stated, is too large and hides what is smaller"
        )
    return said + "."


def _list(findings: Sequence[Finding]) -> str:
    return ", and ".join(
        f"{finding.name} ({' or '.join((finding.where, *finding.elsewhere))})"
        + (
            f" – or {' or '.join(finding.rivals)}, these data can't tell –"
            if finding.rivals
            else ""
        )
        for finding in findings
    )
