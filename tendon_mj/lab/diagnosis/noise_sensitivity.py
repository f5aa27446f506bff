"""How a verdict changes if the stated noise is smaller or larger than it was stated.

Nothing is fitted or simulated again: least squares finds the same values whatever the noise is, if
it changes for all signals alike. An error of E times the noise is E/f times a noise that is f times
as large; an excess χ² that steps and guides leave is 1/f² of what it was. Where the rig differs
between sessions, that too is taken to be f times as large. With these numbers the
criteria of the verdict are applied again, to the same findings. Whether a search with another noise
would have found others is not known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from tendon_mj.lab.diagnosis.model_selection.thresholds import CLOSED, PART, SMALLEST_EXCESS
from tendon_mj.lab.diagnosis.result.diagnosis import Diagnosis, Verdict
from tendon_mj.lab.diagnosis.result.error_reduction import ErrorReduction
from tendon_mj.lab.diagnosis.result.evidence import Evidence
from tendon_mj.lab.diagnosis.verdict import LARGEST, decide

FACTORS = 0.5, 1.0, 2.0
_FARTHEST = 8.0  # factor up to which it is asked where a verdict ends
_RATIO = 2.0 ** (1.0 / 16.0)  # between the factors that are tried


@dataclass(frozen=True)
class NoiseCase:
    """The criteria of a verdict for another noise.

    Attributes:
        factor: noise over the stated one.
        before, after: rms error on held-out data [that noise and reproducibility].
        closed: share of the error above that which is removed; 1 where all is.
        verdict: that the criteria give for the same findings; None where an error remains to which
            no finding belongs, so that a search would have to decide.
        reason: the criterion that decides, in a sentence.
    """

    factor: float
    before: float
    after: float
    closed: float
    verdict: Verdict | None
    reason: str


@dataclass(frozen=True)
class NoiseSensitivity:
    """How a verdict depends on the noise.

    Attributes:
        cases: in the order of the factors.
        low, high: the verdict is the same from ``low`` to ``high`` times the stated noise.
        farthest: factor up to which, and down to whose reciprocal, this was tried.
    """

    cases: tuple[NoiseCase, ...]
    low: float
    high: float
    farthest: float = _FARTHEST


def noise_sensitivity(
    diagnosis: Diagnosis, factors: Sequence[float] = FACTORS
) -> NoiseSensitivity | None:
    """Apply the criteria of a finished diagnosis to other noises; None where it has no evidence.

    Args:
        diagnosis: that `diagnose` made.
        factors: noises over the stated one, > 0.
    """
    evidence = diagnosis.evidence
    if evidence is None:
        return None
    return NoiseSensitivity(
        cases=tuple(_case(evidence, factor) for factor in factors),
        low=_reach(evidence, diagnosis.verdict, 1.0 / _RATIO),
        high=_reach(evidence, diagnosis.verdict, _RATIO),
    )


def _case(evidence: Evidence, factor: float) -> NoiseCase:
    scaled = with_noise(evidence, factor)
    errors = scaled.extrapolated
    closed = min(errors.reducible_closed, 1.0) if errors.before > 1.0 else 1.0
    verdict, reason = _judge(scaled)
    return NoiseCase(factor, errors.before, errors.after, closed, verdict, reason)


def with_noise(evidence: Evidence, factor: float) -> Evidence:
    """The evidence in units of a noise that is ``factor`` times the stated one."""
    power = factor**2
    lumping, step = evidence.lumping / power, evidence.step / power
    excess = (1.0 + evidence.excess) / power - 1.0
    limit = max(SMALLEST_EXCESS, step, lumping)
    return replace(
        evidence,
        calibrated=excess <= limit if factor != 1.0 else evidence.calibrated,
        extrapolated=_scaled(evidence.extrapolated, factor),
        stated=_scaled(evidence.stated, factor),
        limit=limit,
        largest=max(LARGEST, lumping),
        excess=excess,
        step=step,
        lumping=lumping,
    )


def _scaled(errors: ErrorReduction, factor: float) -> ErrorReduction:
    signals = {c: (b, a, noise * factor) for c, (b, a, noise) in errors.signals.items()}
    return replace(
        errors, before=errors.before / factor, after=errors.after / factor, signals=signals
    )


def _judge(evidence: Evidence) -> tuple[Verdict | None, str]:
    """The verdict by its criteria, and the one that decides."""
    errors, limit = evidence.extrapolated, evidence.limit
    unit = f"this {errors.unit}"
    small = evidence.calibrated and errors.before**2 - 1.0 <= limit
    if small:
        return "nothing missing", (
            f"The calibrated model leaves {errors.before:.2f} times {unit}, which is below the"
            f" detection limit of {(1.0 + limit) ** 0.5:.2f}."
        )
    if not evidence.kinds:
        return None, (
            f"The calibrated model leaves {errors.before:.2f} times {unit}, above the detection"
            f" limit of {(1.0 + limit) ** 0.5:.2f}: an effect would be sought."
        )
    verdict = decide(evidence)
    if evidence.beyond:
        return verdict, "The findings would take a parameter beyond its range, at any noise."
    removed = f"{100.0 * min(errors.reducible_closed, 1.0):.1f} % of the error above {unit}"
    remains = f"{errors.after:.2f} times {unit} remains"
    wanted = f"{100.0 * CLOSED:.1f} % is wanted"
    if verdict in ("named", "parameter"):
        if errors.reducible_closed >= CLOSED:
            return verdict, f"{removed} is removed; {wanted}."
        return verdict, (
            f"{remains}, which is below the detection limit of {(1.0 + limit) ** 0.5:.2f}."
        )
    if verdict == "partly":
        asked = "two thirds are asked for a part of it"
        return verdict, f"{removed} is removed, and {asked}; {remains}, which is not explained."
    if errors.reducible_closed < PART:
        return verdict, f"{removed} is removed, and two thirds are asked; {remains}."
    if evidence.stated.after >= evidence.stated.before:
        return verdict, f"{removed} is removed, but with the model's own step the error stays."
    return verdict, f"{removed} is removed, but of a signal more remains than before."


def _reach(evidence: Evidence, verdict: Verdict, ratio: float) -> float:
    """The last factor, going from 1 in steps of a ratio, at which the verdict is the same."""
    factor = 1.0
    while 1.0 / _FARTHEST * 1.001 < factor < _FARTHEST / 1.001:
        if _judge(with_noise(evidence, factor * ratio))[0] != verdict:
            break
        factor *= ratio
    return factor
