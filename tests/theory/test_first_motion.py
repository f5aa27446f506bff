"""Laws of a first motion: its profile along the tendon, and its ends."""

import numpy as np
import pytest

from tendon_mj.theory import (
    elongation_profile,
    equivalent_backlash,
    first_displacement,
    first_input_tension,
    first_output_tension,
    series_stiffness,
    sliding_length,
    tendon_stiffness,
    transmission_stiffness,
)
from tendon_mj.theory import tension_profile as tension_at

EA, LENGTH, PRETENSION = 20e3, 0.5, 20.0
SPRING = float(series_stiffness(10e3, 40e3))
SLACK = -PRETENSION * (1 / SPRING + LENGTH / EA)
MOTIONS = np.concatenate([np.linspace(SLACK, 0, 50), np.linspace(0, 8e-3, 50), [1e-12, -1e-12]])
LAMS = [0.0, 1e-9, 1e-3, 0.47, 1.0, 3.0]
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


def ends(xi, lam, pretension=PRETENSION, spring=SPRING):
    """T_in and T_out."""
    arguments = (xi, lam, pretension, EA, LENGTH, spring)
    return first_input_tension(*arguments), first_output_tension(*arguments)


@pytest.mark.parametrize("lam", LAMS)
def test_output_holds_still_in_the_backlash_and_follows_a_line_outside(lam):
    _, out = ends(MOTIONS, lam)
    for sgn in (1.0, -1.0):
        backlash = equivalent_backlash(sgn * lam, PRETENSION, EA, LENGTH)
        side = np.sign(MOTIONS) == sgn
        inside = side & (np.abs(MOTIONS) <= np.abs(backlash))
        np.testing.assert_array_equal(out[inside], PRETENSION)
        slope = transmission_stiffness(sgn * lam, EA, LENGTH, 10e3, 40e3)
        outside = side & ~inside
        line = PRETENSION + slope * (MOTIONS[outside] - backlash)
        np.testing.assert_allclose(out[outside], line, rtol=1e-13, atol=1e-12)


@pytest.mark.parametrize("lam", LAMS)
@pytest.mark.parametrize("spring", [SPRING, np.inf])
def test_displacement_and_input_tension_are_inverse(lam, spring):
    slack = -PRETENSION * (1 / spring + LENGTH / EA)
    xi = MOTIONS[slack < MOTIONS]
    near, _ = ends(xi, lam, spring=spring)
    back = first_displacement(near, lam, PRETENSION, EA, LENGTH, spring)
    np.testing.assert_allclose(back, xi, rtol=1e-12, atol=1e-18)


@pytest.mark.parametrize("lam", LAMS)
def test_end_tensions_stay_within_the_capstan_ratio(lam):
    near, far = ends(MOTIONS, lam)
    assert np.all(near <= far * np.exp(lam) * (1 + 1e-13))
    assert np.all(near >= far * np.exp(-lam) * (1 - 1e-13))


def test_without_friction_the_transmission_is_springs_in_a_row():
    near, far = ends(MOTIONS, 0.0)
    stiffness = series_stiffness(SPRING, tendon_stiffness(EA, LENGTH))
    np.testing.assert_allclose(far, PRETENSION + stiffness * MOTIONS, rtol=1e-14, atol=1e-13)
    np.testing.assert_array_equal(near, far)


def test_transmission_is_continuous_at_the_edge_of_the_backlash():
    for lam in (1.0, -1.0):
        edge = equivalent_backlash(lam, PRETENSION, EA, LENGTH)
        near, far = ends(edge * np.array([1 - 1e-12, 1, 1 + 1e-12]), lam)
        np.testing.assert_allclose(near, PRETENSION * np.exp(lam), rtol=1e-11)
        np.testing.assert_allclose(far, PRETENSION, rtol=1e-11)


def test_the_smallest_motion_moves_the_input_tension_by_a_square_root():
    xi = np.array([1e-15, -1e-15])
    near, _ = ends(xi, 1.0)
    expected = np.sign(xi) * np.sqrt(2 * np.abs(xi) * EA / (LENGTH * PRETENSION))
    np.testing.assert_allclose(near / PRETENSION - 1, expected, rtol=1e-5)


def test_at_the_slack_limit_there_is_no_tension():
    near, far = ends(SLACK, 1.0)
    assert near == pytest.approx(0, abs=1e-12)
    assert far == pytest.approx(0, abs=1e-12)


def test_without_pretension_there_is_no_backlash():
    near, far = ends([0.0, 1e-3], 1.0, pretension=0.0)
    stiffness = transmission_stiffness(1.0, EA, LENGTH, SPRING)
    np.testing.assert_allclose(far, [0.0, 1e-3 * stiffness])
    np.testing.assert_allclose(near, far * np.e)
