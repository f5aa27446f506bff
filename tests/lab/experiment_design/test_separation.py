"""What remains of a difference when one model is fitted to the data of another."""

from __future__ import annotations

import numpy as np
import pytest

from tendon_mj.lab.diagnosis import Fit, Term
from tendon_mj.lab.experiment_design import Adaptation, Alternative
from tendon_mj.typing import FloatArray

OLD, NEW = 300, 200  # samples
RANDOM = np.random.default_rng(0)
DIFFERENCE = RANDOM.normal(size=NEW)
SLOPES = RANDOM.normal(size=(NEW, 2))


def fitted(
    jacobian: FloatArray, spreads: tuple[float, ...] = (0.0, 0.0), reach: float = 1e3
) -> Fit:
    """A linear model at its optimum, with a residual of 1 noise."""
    terms = tuple(
        Term(
            (f"rig.p{k}" + " @ old" * (spread > 0.0),), "-", 0.0, -reach, reach, 1.0, spread=spread
        )
        for k, spread in enumerate(spreads)
    )
    still = np.zeros(len(terms))
    residual = np.where(np.arange(len(jacobian)) % 2, 1.0, -1.0)
    return Fit(
        calibrated=terms,
        effects=(),
        values=still,
        residual=residual,
        correction=np.zeros(len(jacobian)),
        jacobian=jacobian,
        scaled=still,
        bounds=np.array([[-reach] * len(terms), [reach] * len(terms)]),
    )


def remaining(
    fit: Fit, held: tuple[bool, ...] = (False, False), difference: FloatArray = DIFFERENCE
) -> float:
    free = [k for k, is_held in enumerate(held) if not is_held and fit.shared[k]]
    adaptation = Adaptation(Alternative("", fit, np.array(held)), np.ones(fit.residual.size, bool))
    return adaptation.remaining(SLOPES[:, free], difference, [])


def rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def test_it_is_what_least_squares_on_old_and_new_data_together_leave() -> None:
    old = RANDOM.normal(size=(OLD, 2))
    both = np.vstack([SLOPES, old])
    aim = np.append(DIFFERENCE, np.zeros(OLD))
    left = aim - both @ np.linalg.lstsq(both, aim, rcond=None)[0]
    assert remaining(fitted(old)) == pytest.approx(np.linalg.norm(left) / np.sqrt(NEW))


def test_terms_do_not_leave_their_bounds() -> None:
    along = SLOPES @ [2.0, 0.0]
    free, bounded = (fitted(np.zeros((OLD, 2)), reach=reach) for reach in (1e3, 1.0))
    assert remaining(free, difference=along) == pytest.approx(0.0, abs=1e-6)
    assert remaining(bounded, difference=along) > 0.4 * rms(along)


def test_what_makes_an_alternative_is_not_fitted_away() -> None:
    along = SLOPES @ [2.0, 0.0]
    fit = fitted(np.zeros((OLD, 2)))
    assert remaining(fit, (False, False), along) < 1e-6
    assert remaining(fit, (True, False), along) > 0.9 * rms(along)


def test_values_of_old_sessions_give_way_to_the_shared_ones() -> None:
    """Where an old session's zero explains all that a term does, the old data say nothing of it."""
    column = RANDOM.normal(size=OLD)
    fit = fitted(np.column_stack([column, column]), spreads=(0.0, 1e6))
    alone = fitted(np.column_stack([column, 0.0 * column]))
    aim = 1e-3 * SLOPES[:, 0]
    assert remaining(fit, difference=aim) == pytest.approx(0.0, abs=1e-6)
    assert remaining(alone, (False, True), aim) > 0.3 * rms(aim)


def test_a_zero_of_the_new_session_is_fitted_within_its_spread() -> None:
    offset = np.full(NEW, 3.0)
    fit = fitted(np.zeros((OLD, 0)), spreads=())
    adaptation = Adaptation(Alternative("", fit, np.zeros(0, bool)), np.ones(OLD, bool))
    left = {}
    for spread in (100.0, 0.01):
        own = Term(("sensor.offset @ next",), "N", 0.0, -1e3, 1e3, 1.0, spread=spread)
        left[spread] = adaptation.remaining(np.ones((NEW, 1)), offset, [own])
    assert left[100.0] < 0.01
    assert left[0.01] > 2.9


def test_an_experiment_in_which_a_fit_fails_counts_for_nothing() -> None:
    adaptation = Adaptation(
        Alternative("", fitted(np.eye(OLD, 2)), np.zeros(2, bool)), np.ones(OLD, bool)
    )
    assert adaptation.remaining(np.full((NEW, 2), np.nan), DIFFERENCE, []) == 0.0
