"""Verdict from the errors on held-out data."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tendon_mj.lab.diagnosis import ErrorReduction, diagnose
from tendon_mj.lab.diagnosis.limits import LARGEST_EXCESS
from tendon_mj.lab.diagnosis.proof import ranking
from tendon_mj.lab.diagnosis.verdict import Evidence, Verdict, decide
from tests.lab.diagnosis.linear_rig import context, effect, select
from tests.lab.diagnosis.toy import Toy, rig

LIMIT = 0.2
COLUMN = "tension_N"


def verdict(
    kinds: tuple[str, ...],
    before: float,
    after: float,
    *,
    calibrated: bool = True,
    agrees: bool = False,
    stated: float | None = None,
    beyond: bool = False,
    largest: float = LARGEST_EXCESS,
    signals: dict[str, tuple[float, float, float]] | None = None,
) -> Verdict:
    """Verdict on findings that take the held-out error from ``before`` to ``after`` [bars]."""
    own_step = ErrorReduction(before, after if stated is None else stated, 1.0, {})
    return decide(
        Evidence(
            kinds=kinds,
            calibrated=calibrated,
            agrees=agrees,
            held_out=own_step,
            weighed=own_step,
            extrapolated=ErrorReduction(before, after, 1.0, signals or {}),
            limit=LIMIT,
            largest=largest,
            at_end=beyond,
        )
    )


def test_nothing_is_missing_where_both_data_leave_less_than_the_limit() -> None:
    assert verdict((), 1.09, 1.09) == "nothing missing"
    assert verdict((), 1.09, 1.09, calibrated=False) == "unknown"
    assert verdict((), 1.11, 1.11) == "unknown"


def test_nothing_is_missing_where_only_ever_shorter_steps_would_leave_more() -> None:
    assert verdict((), 4.66, 4.66, calibrated=False, agrees=True) == "nothing missing"
    assert verdict(("missing",), 4.66, 1.0, agrees=True) == "named"


def test_only_wrong_parameters_are_a_verdict_of_their_own() -> None:
    assert verdict(("missing",), 10.0, 1.0) == "named"
    assert verdict(("parameter",), 10.0, 1.0) == "parameter"
    assert verdict(("parameter", "missing"), 10.0, 1.0) == "named"


@pytest.mark.parametrize(("after", "proven"), [(2.48, True), (2.52, False)])
def test_effects_are_the_whole_answer_where_98_5_percent_of_the_error_closes(
    after: float, proven: bool
) -> None:
    assert verdict(("missing",), 101.0, after) == ("named" if proven else "partly")


def test_a_small_error_need_not_close_by_as_much_where_the_rest_is_below_the_limit() -> None:
    assert verdict(("missing",), 2.0, 1.09) == "named"
    assert verdict(("missing",), 2.0, 1.11) == "partly"


def test_more_than_three_bars_are_never_the_whole_answer() -> None:
    assert verdict(("missing",), 1e3, 2.9) == "named"
    assert verdict(("missing",), 1e3, 3.1) == "partly"
    assert verdict(("missing",), 1e3, 3.1, largest=20.0) == "named"
    assert verdict((), 3.1, 3.1) == "unknown"


def test_effects_that_remove_less_than_two_thirds_of_the_error_are_not_proven() -> None:
    assert verdict(("missing",), 10.0, 3.9) == "partly"
    assert verdict(("missing",), 10.0, 4.1) == "unknown"


def test_effects_that_worsen_a_signal_are_not_proven() -> None:
    better, worse = (10.0, 2.0, 1.0), (2.0, 2.2, 1.0)
    assert verdict(("missing",), 11.0, 3.5, signals={COLUMN: better}) == "partly"
    assert verdict(("missing",), 11.0, 3.5, signals={COLUMN: better, "b_N": worse}) == "unknown"
    hidden = (0.2, 0.9, 1.0)  # it got worse, and none could tell
    assert verdict(("missing",), 11.0, 3.5, signals={COLUMN: better, "b_N": hidden}) == "partly"


def test_effects_that_leave_more_with_the_models_own_step_are_not_proven() -> None:
    assert verdict(("missing",), 10.0, 1.0, stated=9.0) == "named"
    assert verdict(("missing",), 10.0, 1.0, stated=10.0) == "unknown"


def test_an_explanation_beyond_the_range_of_an_uncertain_parameter_is_none() -> None:
    assert verdict(("missing",), 10.0, 1.0, beyond=True) == "unknown"
    inside, outside = (
        diagnose(*rig(1, {"sheath.constant_friction": 10.0, "sheath.friction": friction}), Toy)
        for friction in (0.39, 0.403)
    )
    assert inside.verdict == "named"
    assert outside.verdict == "unknown"
    assert outside.closest == ("constant_friction",)
    assert not outside.proven
    assert outside.held_out.reducible_closed > 0.9  # the closest model is there all the same
    assert "sheath.constant_friction" in outside.parameters
    assert "it would take sheath.friction beyond its range" in outside.sentence


def test_the_ranking_holds_what_explains_at_least_a_hundredth() -> None:
    shapes = {"a": {"a": 1.0}, "b": {"b": 1.0}, "c": {"c": 1.0}}
    truth = {"a": 10.0, "b": 5.0, "c": 0.5}
    given = context(shapes, truth, [effect(name) for name in "cba"])
    selection = select(given)
    ranked = ranking(selection, given.problem.in_train)
    assert [row.identifier for row in ranked] == ["a", "b"]
    assert [row.explains for row in ranked] == pytest.approx([100 / 125.25, 25 / 125.25], rel=1e-3)
    assert ranked[0].left == pytest.approx(np.sqrt(26.25), rel=1e-3)
    assert ranked[1].left == pytest.approx(np.sqrt(101.25), rel=1e-3)  # as a leaves much by itself
    assert ranking(replace(selection, first=None), given.problem.in_train) == ()


def test_the_ranking_says_at_which_end_of_its_range_a_candidate_stands() -> None:
    shapes = {"a": {"a": 1.0}, "b": {"b": 1.0}}
    given = context(shapes, {"a": 10.0, "b": 9.0}, [effect("a", most=5.0), effect("b")])
    first, second = ranking(select(given), given.problem.in_train)
    assert (first.identifier, first.at_end) == ("b", None)
    assert (second.identifier, second.at_end) == ("a", 5.0)
    assert second.left is not None


@pytest.mark.parametrize(("small", "named"), [(0.9, False), (2.5, True)])
def test_under_a_remainder_an_effect_is_named_if_it_explains_more_than_that(
    small: float, named: bool
) -> None:
    """Play, a hum of 0.28 N rms that nothing explains, and friction F_c that grows past it."""
    train, held_out = rig(3, {"sheath.backlash": 6e-5, "sheath.constant_friction": small}, 0.4)
    result = diagnose(train, held_out, Toy)
    assert result.verdict == "partly"
    named_effects = [f.identifier for f in result.findings]
    assert named_effects[0] == "backlash"
    assert ("constant_friction" in named_effects) == named
