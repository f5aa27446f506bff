"""Verdict from the errors on held-out data."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tendon_mj.diagnosis import ErrorReduction, diagnose
from tendon_mj.diagnosis.effects.effect import Candidate
from tendon_mj.diagnosis.model_selection.confidence import SelectedEffect
from tendon_mj.diagnosis.model_selection.select import Selection
from tendon_mj.diagnosis.result.diagnosis import Verdict
from tendon_mj.diagnosis.result.entries import ranking
from tendon_mj.diagnosis.verdict import decide
from tests.diagnosis.linear_rig import context, effect, select
from tests.diagnosis.toy import Toy, rig

LIMIT = 0.2
A, WRONG = effect("a"), effect("b", "parameter")


def verdict(
    effects: tuple[Candidate, ...],
    before: float,
    after: float,
    *,
    left: float = 0.0,
    stated: float | None = None,
    beyond: bool = False,
    largest: float = 8.0,
) -> Verdict:
    """Verdict on effects that take the held-out error from ``before`` to ``after`` [noise].

    ``left`` is the calibrated model's excess on training data, ``stated`` the error after with
    the model's own step.
    """
    given = context({"a": {"a": 1.0}}, {"a": np.sqrt(left)}, [])
    selection = select(given)
    found = tuple(SelectedEffect(candidate, (), 1.0) for candidate in effects)
    selection = Selection(selection.calibrated, selection.final, found, None)
    stated = after if stated is None else stated
    errors = ErrorReduction(before, after, 1.0, {})
    own = ErrorReduction(before, stated, 1.0, {})
    return decide(given, selection, errors, own, (LIMIT, largest), beyond)


def test_nothing_is_missing_where_both_data_leave_less_than_the_limit() -> None:
    assert verdict((), 1.09, 1.09) == "nothing missing"
    assert verdict((), 1.09, 1.09, left=0.25) == "unknown"
    assert verdict((), 1.11, 1.11) == "unknown"


def test_only_wrong_parameters_are_a_verdict_of_their_own() -> None:
    assert verdict((A,), 10.0, 1.0) == "named"
    assert verdict((WRONG,), 10.0, 1.0) == "parameter"
    assert verdict((WRONG, A), 10.0, 1.0) == "named"


@pytest.mark.parametrize(("after", "proven"), [(2.48, True), (2.52, False)])
def test_effects_are_proven_where_98_5_percent_of_the_error_closes(
    after: float, proven: bool
) -> None:
    assert verdict((A,), 101.0, after) == ("named" if proven else "unknown")


def test_a_small_error_need_not_close_by_as_much_where_the_rest_is_below_the_limit() -> None:
    assert verdict((A,), 2.0, 1.09) == "named"
    assert verdict((A,), 2.0, 1.11) == "unknown"


def test_more_than_three_noise_rms_is_never_proven() -> None:
    assert verdict((A,), 1e3, 2.9) == "named"
    assert verdict((A,), 1e3, 3.1) == "unknown"
    assert verdict((A,), 1e3, 3.1, largest=20.0) == "named"
    assert verdict((), 3.1, 3.1) == "unknown"


def test_effects_that_leave_more_with_the_models_own_step_are_not_proven() -> None:
    assert verdict((A,), 10.0, 1.0, stated=9.0) == "named"
    assert verdict((A,), 10.0, 1.0, stated=10.0) == "unknown"


def test_an_explanation_beyond_the_range_of_an_uncertain_parameter_is_none() -> None:
    assert verdict((A,), 10.0, 1.0, beyond=True) == "unknown"
    inside, outside = (
        diagnose(*rig(1, {"sheath.constant_friction": 10.0, "sheath.friction": friction}), Toy)
        for friction in (0.39, 0.403)
    )
    assert inside.verdict == "named"
    assert outside.verdict == "unknown"
    assert outside.closest == ("constant_friction",)
    assert outside.held_out.reducible_closed == 0.0  # nothing was added
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
    assert ranked[1].left is None  # promised too little to be fitted
    assert ranking(replace(selection, first=None), given.problem.in_train) == ()
