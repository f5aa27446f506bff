"""Sentences on a verdict: every number in its unit, and every doubt next to it."""

from __future__ import annotations

from dataclasses import replace

from tendon_mj.lab.diagnosis import ErrorReduction, Finding
from tendon_mj.lab.diagnosis.verdict import Evidence, Verdict
from tendon_mj.lab.diagnosis.wording import state

PLAY = Finding("backlash", "play", "", "sheath", "missing", 1.0, ())


def sentence(
    verdict: Verdict,
    findings: list[Finding],
    errors: ErrorReduction,
    weighed: ErrorReduction | None = None,
    **more: object,
) -> str:
    """Sentence on a verdict with these held-out errors, judged by the noise unless weighed."""
    judged = weighed or errors
    given = {"zero_step": errors.after, "limit": 0.2, **more}
    evidence = Evidence(held_out=errors, weighed=judged, extrapolated=judged, **given)  # type: ignore[arg-type]
    return state(verdict, findings, evidence)


def gap(before: float, after: float, unit: str = "noise", **signals: tuple[float, float, float]):
    return ErrorReduction(before, after, 1.0, signals, unit)


def test_every_signal_is_stated_in_its_own_unit_before_all_together() -> None:
    errors = gap(9.0, 2.0, elbow_rad=(0.1, 0.02, 0.01), input_tension_N=(3.0, 0.5, 0.2))
    text = sentence("named", [PLAY], errors)
    assert "elbow 5.73° to 1.15°; input tension 3 to 0.5 N; over all from 9.00 to 2.00" in text


def test_a_finding_that_others_explain_nearly_as_well_is_no_flat_sentence() -> None:
    doubtful = replace(PLAY, confidence=0.25)
    text = sentence("partly", [doubtful], gap(9.0, 3.0))
    assert "play (sheath) – 25 % sure: others explain nearly as much –" in text
    assert "sure" not in sentence("partly", [PLAY], gap(9.0, 3.0))
    assert "can't tell" in sentence("partly", [replace(doubtful, rivals=("creep",))], gap(9.0, 3.0))
