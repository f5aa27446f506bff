"""Laws of the tension and elongation profile of a first motion."""

import numpy as np
import pytest

from tendon_mj.theory import elongation_profile, equivalent_backlash, sliding_length
from tendon_mj.theory import tension_profile as tension_at

EA, LENGTH, PRETENSION = 20e3, 0.5, 20.0
X = np.linspace(0.0, LENGTH, 41)
# (T_in, λ): pulling and loosening, in the backlash and out of it, with and without friction
CASES = [(25.0, 1.0), (90.0, 1.0), (16.0, 1.0), (3.0, 1.0), (30.0, 0.0), (20.0, 1.0), (30.0, 1e-9)]


@pytest.mark.parametrize(("tension", "lam"), CASES)
def test_elongation_is_the_integral_of_strain(tension, lam):
    knots = np.append(X, sliding_length(tension, lam, PRETENSION, LENGTH))
    knots.sort()
    nodes, weights = np.polynomial.legendre.leggauss(12)
    half = np.diff(knots)[:, None] / 2
    inner = knots[:-1, None] + half * (nodes + 1)
    strain = (tension_at(inner, tension, lam, PRETENSION, LENGTH) - PRETENSION) / EA
    integral = np.append(0.0, np.cumsum(np.sum(strain * weights * half, axis=1)))
    closed = elongation_profile(knots, tension, lam, PRETENSION, EA, LENGTH)
    np.testing.assert_allclose(closed, integral, rtol=1e-13, atol=1e-18)


@pytest.mark.parametrize(("tension", "lam"), CASES)
def test_slope_of_elongation_is_the_strain(tension, lam):
    slid = float(sliding_length(tension, lam, PRETENSION, LENGTH))
    x, h = X[1:-1], 1e-6
    x = x[np.abs(x - slid) > 2 * h]
    after, before = (
        elongation_profile(x + d, tension, lam, PRETENSION, EA, LENGTH) for d in (h, -h)
    )
    strain = (tension_at(x, tension, lam, PRETENSION, LENGTH) - PRETENSION) / EA
    np.testing.assert_allclose((after - before) / (2 * h), strain, atol=1e-11)


@pytest.mark.parametrize(("tension", "lam"), CASES)
def test_tension_starts_at_the_input_and_holds_the_capstan_law(tension, lam):
    profile = tension_at(X, tension, lam, PRETENSION, LENGTH)
    assert profile[0] == tension
    slope = np.abs(np.diff(np.log(profile))) / np.diff(X)
    assert np.all(slope <= lam / LENGTH * (1 + 1e-9) + 1e-13)
    beyond = sliding_length(tension, lam, PRETENSION, LENGTH) < X
    np.testing.assert_array_equal(profile[beyond], PRETENSION)


def test_motion_reaches_the_end_exactly_at_the_capstan_ratio():
    lam = 1.3
    for sgn in (1, -1):
        limit = PRETENSION * np.exp(sgn * lam)
        slid = sliding_length(limit, lam, PRETENSION, LENGTH)
        assert slid == pytest.approx(LENGTH, rel=1e-15)
        end = elongation_profile(LENGTH, limit, lam, PRETENSION, EA, LENGTH)
        backlash = equivalent_backlash(sgn * lam, PRETENSION, EA, LENGTH)
        assert end == pytest.approx(backlash, rel=1e-14)


def test_without_friction_the_tension_is_uniform():
    np.testing.assert_array_equal(tension_at(X, 30.0, 0.0, PRETENSION, LENGTH), 30.0)
    elongation = elongation_profile(X, 30.0, 0.0, PRETENSION, EA, LENGTH)
    np.testing.assert_allclose(elongation, 10.0 / EA * X, rtol=1e-15)


def test_without_pretension_any_pull_slides_the_whole_tendon():
    assert sliding_length(1e-9, 5.0, 0.0, LENGTH) == LENGTH
    assert tension_at(LENGTH, 1.0, 5.0, 0.0, LENGTH) == pytest.approx(np.exp(-5.0))
    assert sliding_length(0.0, 5.0, 0.0, LENGTH) == 0


def test_letting_go_leaves_no_tension():
    np.testing.assert_array_equal(tension_at(X, 0.0, 2.0, PRETENSION, LENGTH), 0.0)
    end = elongation_profile(LENGTH, 0.0, 2.0, PRETENSION, EA, LENGTH)
    assert end == pytest.approx(-PRETENSION * LENGTH / EA)


def test_sign_of_lam_does_not_matter():
    for tension in (25.0, 16.0):
        one, other = (tension_at(X, tension, lam, PRETENSION, LENGTH) for lam in (1.0, -1.0))
        np.testing.assert_array_equal(one, other)


def test_arguments_broadcast():
    tension, lam = np.full((4, 1, 1), 30.0), np.full((3, 1), 1.0)
    assert tension_at(X, tension, lam, PRETENSION, LENGTH).shape == (4, 3, 41)
    assert elongation_profile(X, tension, lam, PRETENSION, EA, LENGTH).shape == (4, 3, 41)
