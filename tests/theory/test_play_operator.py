"""Laws of the play operator: any history of input tension."""

import numpy as np
import pytest

from tendon_mj.theory import displacement, first_displacement, output_tension, tension_profile

EA, LENGTH, PRETENSION = 20e3, 0.5, 20.0
SHEATH = (PRETENSION, EA, LENGTH, 8e3)
LAMS = [0.0, 1e-9, 0.1, 0.47, 1.0, 3.0]


def random_walk(seed, size=120):
    steps = np.random.default_rng(seed).normal(0.0, 0.3, size)
    return PRETENSION * np.exp(np.cumsum(steps) * 0.6)


@pytest.mark.parametrize("lam", LAMS)
@pytest.mark.parametrize("end", [5.0, 90.0])
def test_first_motion_is_section_one(lam, end):
    tensions = np.linspace(PRETENSION, end, 60)
    far = output_tension(tensions, lam, PRETENSION)
    closed = tension_profile(LENGTH, tensions, lam, PRETENSION, LENGTH)
    np.testing.assert_allclose(far, closed, rtol=1e-14)
    xi = displacement(tensions, lam, *SHEATH)
    closed = first_displacement(tensions, lam, *SHEATH)
    np.testing.assert_allclose(xi, closed, rtol=1e-12, atol=1e-18)


def test_without_friction_the_output_is_the_input():
    walk = random_walk(0)
    np.testing.assert_array_equal(output_tension(walk, 0.0, PRETENSION), walk)


def test_thresholds_of_sheaths_in_a_row_add():
    walk = random_walk(1)
    middle = output_tension(walk, 0.3, PRETENSION)
    twice = output_tension(middle, 0.5, PRETENSION)
    np.testing.assert_allclose(twice, output_tension(walk, 0.8, PRETENSION), rtol=1e-13)


def test_the_wave_form_between_turning_points_does_not_matter():
    walk = random_walk(2, 30)
    slow = np.interp(np.linspace(0, 29, 29 * 7 + 1), np.arange(30), walk)
    far, xi = output_tension(walk, 0.6, PRETENSION), displacement(walk, 0.6, *SHEATH)
    np.testing.assert_allclose(output_tension(slow, 0.6, PRETENSION)[::7], far, rtol=1e-14)
    np.testing.assert_allclose(displacement(slow, 0.6, *SHEATH)[::7], xi, rtol=1e-13)


def test_a_closed_minor_loop_returns_exactly():
    with_loop = displacement([60.0, 30.0, 50.0, 40.0, 45.0, 30.0, 25.0], 0.8, *SHEATH)
    without = displacement([60.0, 30.0, 25.0], 0.8, *SHEATH)
    np.testing.assert_array_equal(with_loop[[1, 5, 6]], without[[1, 1, 2]])


def test_output_stays_within_the_capstan_ratio_for_every_threshold():
    walk, lams = random_walk(3), np.array(LAMS)
    far = output_tension(walk, lams, PRETENSION)
    ratio = np.abs(np.log(far / walk[:, None]))
    assert far.shape == (len(walk), len(lams))
    assert np.all(ratio <= lams + 1e-13)


def test_history_without_samples_is_empty():
    assert output_tension([], [0.1, 0.2], PRETENSION).shape == (0, 2)
    assert displacement([], [0.1, 0.2], *SHEATH).shape == (0, 2)


def test_arguments_broadcast_behind_time():
    walk = np.tile(random_walk(5, 6)[:, None], 2)
    lam, pretension = np.array([0.2, 0.4, 0.8])[:, None], np.array([20.0, 30.0])
    assert output_tension(walk, lam, pretension).shape == (6, 3, 2)
    xi = displacement(walk, lam, pretension, EA, LENGTH)
    assert xi.shape == displacement(walk[:, 0], lam, pretension, EA, LENGTH).shape == (6, 3, 2)
    np.testing.assert_array_equal(xi[:, 1, 1], displacement(walk[:, 1], 0.4, 30.0, EA, LENGTH))
