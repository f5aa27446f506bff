"""Comparison of fitted models by the χ² of blocks that their fits left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tendon_mj.lab.diagnosis import Candidate, Fit, FittedCandidate, tied
from tendon_mj.lab.diagnosis.statistics import CrossValidation, gain, rate, simplest
from tendon_mj.lab.diagnosis.thresholds import detection_limit
from tests.lab.diagnosis.linear_rig import LinearRig, context, effect

SAMPLES = 100  # in 10 blocks
NOTHING = np.zeros(0)
FIT = Fit((), (), NOTHING, NOTHING, NOTHING, np.zeros((0, 0)), NOTHING, np.zeros((2, 0)))
A, B = effect("a"), effect("b")
LONG = effect("b", shape="d")


def model(candidate: Candidate | None, excess: float, moved: float = 0.0) -> FittedCandidate:
    """Model with an excess χ², of which ``moved`` is in the other half of the blocks."""
    chi2 = np.full(10, (1.0 + excess) * SAMPLES / 10.0)
    chi2[:5] += moved * SAMPLES / 5.0
    chi2[5:] -= moved * SAMPLES / 5.0
    return FittedCandidate(candidate, FIT, CrossValidation(chi2, SAMPLES))


def test_the_standard_error_of_a_gain_comes_from_the_blocks_that_get_worse() -> None:
    before = CrossValidation(np.array([30.0, 30.0, 30.0, 30.0]), 100)
    after = CrossValidation(np.array([10.0, 10.0, 33.0, 34.0]), 100)
    got = gain(before, after)
    assert got.mean == pytest.approx(0.33)
    assert got.standard_error == pytest.approx(np.sqrt(2.0 * (3.0**2 + 4.0**2)) / 100.0)
    assert gain(before, before).standard_error == 0.0


def test_a_tie_is_a_quarter_of_what_the_best_leaves() -> None:
    assert tied(model(A, 0.0), model(B, 0.019))
    assert not tied(model(A, 0.0), model(B, 0.021))
    assert tied(model(A, 0.4), model(B, 0.4 + 0.119))
    assert not tied(model(A, 0.4), model(B, 0.4 + 0.121))


def test_a_difference_within_two_standard_errors_is_a_tie() -> None:
    """Half of the blocks of b are better by 0.1 each, so the standard error is 0.063."""
    assert tied(model(A, 0.0), model(B, 0.05, moved=0.1))
    assert not tied(model(A, 0.0), model(B, 0.2, moved=0.1))


def test_of_ties_the_simplest_goes_first_and_of_equals_the_best() -> None:
    parameter = effect("c", "parameter")
    ranked = [model(A, 0.0), model(B, 0.005), model(parameter, 0.01), model(LONG, 0.015)]
    assert simplest(ranked).candidate == parameter
    assert simplest(ranked[:2]).candidate == A
    assert simplest([model(LONG, 0.0), *ranked[:2]]).candidate == A
    assert simplest([model(A, 0.0), model(parameter, 0.1)]).candidate == A
    assert simplest([*ranked, model(None, 0.015)]).candidate is None


def test_the_detection_limit_is_the_largest_error_of_the_simulation() -> None:
    """Steps, lumping (0.25 % of the range) where there is a sheath, or 0.45 noise rms."""
    small, large = (context({}, {"a": a}, []).problem for a in (1.0, 100.0 * np.sqrt(2.0)))
    assert detection_limit(small, 0.0) == 0.2
    assert detection_limit(small, 3.0) == 3.0
    assert detection_limit(large, 0.0) == 0.2
    sheath = replace(large, simulate=LinearRig(large.recordings, {"sheath.friction": {}}))
    assert detection_limit(sheath, 0.0) == pytest.approx((0.0025 * 400.0) ** 2, rel=0.05)


def test_confidence_falls_with_every_effect_that_explains_as_much() -> None:
    others = [model(effect(name), 0.0) for name in "bcd"]
    for count in range(4):
        rated = rate(A, [model(A, 0.0), *others[:count]])
        assert rated.confidence == pytest.approx(1.0 / (1.0 + count))
        assert len(rated.rivals) == count


def test_confidence_is_certain_where_the_next_effect_leaves_much_more() -> None:
    rated = rate(A, [model(A, 0.0), model(B, 1.0)])
    assert rated.confidence == pytest.approx(1.0)
    assert rated.rivals == ()


def test_the_same_effect_elsewhere_is_a_rival_and_no_doubt_of_the_effect() -> None:
    elsewhere = effect("a", where="another")
    rated = rate(A, [model(A, 0.0), model(elsewhere, 0.0)])
    assert rated.confidence == 1.0
    assert rated.rivals == (elsewhere,)


def test_more_terms_count_as_a_rival_only_where_they_gain() -> None:
    assert rate(A, [model(A, 0.1), model(LONG, 0.101)]).confidence == 1.0
    assert rate(A, [model(LONG, 0.0), model(A, 0.1)]).confidence == pytest.approx(0.5)


def test_a_difference_that_is_uncertain_leaves_doubt_of_the_effect() -> None:
    """b leaves 0.1 more, of which half of the blocks say the contrary by 0.4 each."""
    uncertain = np.sqrt(2.0 * 5.0 * (0.04 - 0.01) ** 2)
    assert uncertain > 2.0 * 0.02
    rated = rate(A, [model(A, 0.0), model(B, 0.1, moved=0.2)])
    assert rated.confidence == pytest.approx(1.0 / (1.0 + np.exp(-0.1 / uncertain)))
    assert rated.rivals == (B,)


def test_more_terms_that_gain_no_more_than_chance_are_no_rival() -> None:
    better = model(LONG, 0.0, moved=0.2)
    assert rate(A, [better, model(A, 0.05)]).confidence == 1.0
    assert rate(A, [model(LONG, 0.0), model(A, 0.05)]).confidence < 1.0
