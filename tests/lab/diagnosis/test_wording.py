"""Sentences on a verdict: every number in its unit, and every doubt next to it."""

from __future__ import annotations

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


def test_steps_that_are_too_long_for_a_named_effect_are_reported() -> None:
    errors = gap(9.0, 3.0)
    assert "(1.10 in ever shorter steps: " in sentence("named", [PLAY], errors, zero_step=1.1)
    assert "steps" not in sentence("named", [PLAY], errors, zero_step=2.9)


def test_steps_that_hide_an_error_are_reported() -> None:
    hidden = {"weighed": gap(4.66, 4.66), "zero_step": 4.66}
    text = sentence("nothing missing", [], gap(1.0, 1.0), **hidden)  # type: ignore[arg-type]
    assert "1.00 times the noise (4.66 in ever shorter steps: " in text
    assert "one 5 times shorter would do" in text


def test_the_error_of_a_sound_model_is_put_down_to_its_parts() -> None:
    def text(zero_step: float, lumping: float) -> str:
        more = {"zero_step": zero_step, "lumping": lumping, "limit": 20.0}
        return sentence("nothing missing", [], gap(4.6, 4.6), **more)  # type: ignore[arg-type]

    assert "and its guides" in text(4.5, lumping=1.0)
    assert "guides" not in text(4.5, lumping=0.0)
    long = text(1.1, lumping=0.0)
    assert "(1.10 in ever shorter steps: the model's timestep is too long for it; one 5 t" in long
    assert "put down" not in long


def test_every_signal_is_stated_in_its_own_unit_before_all_together() -> None:
    errors = gap(9.0, 2.0, elbow_rad=(0.1, 0.02, 0.01), input_tension_N=(3.0, 0.5, 0.2))
    text = sentence("named", [PLAY], errors)
    assert "elbow 5.73° to 1.15°; input tension 3 to 0.5 N; over all from 9.00 to 2.00" in text
