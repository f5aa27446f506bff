"""Laws of apparent stiffness and backlash."""

import numpy as np
import pytest

from tendon_mj.theory import (
    apparent_stiffness,
    equivalent_backlash,
    reversal_backlash,
    transmission_stiffness,
)
from tendon_mj.theory.stiffness import tendon_stiffness

EA, LENGTH, PRETENSION = 20e3, 0.5, 20.0
LAMS = np.array([1e-12, 1e-6, 0.01, 0.47, 1.0, 1.5, 3.0, 10.0])


def test_without_friction_the_tendon_is_a_plain_spring():
    assert apparent_stiffness(0.0, EA, LENGTH) == tendon_stiffness(EA, LENGTH) == 40e3
    assert equivalent_backlash(0.0, PRETENSION, EA, LENGTH) == 0
    assert reversal_backlash(0.0, PRETENSION, EA, LENGTH) == 0


def test_little_friction_gives_the_first_term_of_the_series():
    lam = np.array([-1e-9, 1e-9])
    free = PRETENSION * LENGTH / EA
    backlash = equivalent_backlash(lam, PRETENSION, EA, LENGTH)
    np.testing.assert_allclose(backlash, free * lam / 2, rtol=1e-9)
    reversal = reversal_backlash(lam, PRETENSION, EA, LENGTH)
    np.testing.assert_allclose(reversal, free * lam, rtol=1e-9)


def test_stiffness_of_loosening_over_pulling_is_the_capstan_ratio():
    pull, loosen = apparent_stiffness(LAMS, EA, LENGTH), apparent_stiffness(-LAMS, EA, LENGTH)
    np.testing.assert_allclose(loosen, np.exp(LAMS) * pull, rtol=1e-14)


def test_pulling_is_softer_and_loosening_stiffer_than_the_tendon():
    assert np.all(apparent_stiffness(LAMS, EA, LENGTH) < tendon_stiffness(EA, LENGTH))
    assert np.all(apparent_stiffness(-LAMS, EA, LENGTH) > tendon_stiffness(EA, LENGTH))


def test_apparent_stiffness_has_no_overflow_at_extreme_friction():
    np.testing.assert_allclose(apparent_stiffness([-1e4, 1e4], 1.0, 1.0), [1e4, 0.0])
    assert transmission_stiffness(1e4, EA, LENGTH, 10e3, 40e3) == 0
    assert equivalent_backlash(1e4, PRETENSION, EA, LENGTH) == np.inf


def test_backlash_has_the_sign_of_friction_and_is_proportional_to_pretension():
    for lam in (LAMS, -LAMS):
        backlash = equivalent_backlash(lam, PRETENSION, EA, LENGTH)
        np.testing.assert_array_equal(np.sign(backlash), np.sign(lam))
        np.testing.assert_allclose(equivalent_backlash(lam, 60.0, EA, LENGTH), 3 * backlash)
    assert equivalent_backlash(1.0, 0.0, EA, LENGTH) == 0


def test_reversal_takes_both_backlashes():
    both = equivalent_backlash(LAMS, PRETENSION, EA, LENGTH) - equivalent_backlash(
        -LAMS, PRETENSION, EA, LENGTH
    )
    reversal = reversal_backlash(LAMS, PRETENSION, EA, LENGTH)
    np.testing.assert_allclose(reversal, both, rtol=1e-13)
    np.testing.assert_array_equal(reversal_backlash(-LAMS, PRETENSION, EA, LENGTH), -reversal)


def test_transmission_is_tendon_environment_and_sensor_in_a_row():
    tendon = apparent_stiffness(0.47, EA, LENGTH)
    full = transmission_stiffness(0.47, EA, LENGTH, 10e3, 40e3)
    assert full == pytest.approx(1.0 / (1.0 / 8e3 + 1.0 / tendon), rel=1e-14)
    assert transmission_stiffness(0.47, EA, LENGTH) == tendon
