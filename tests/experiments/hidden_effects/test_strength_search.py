"""Laws of the search for a strength and of calibration."""

import numpy as np
import pytest

from experiments.hidden_effects.strengths import calibration_projector, find_strength


def test_calibration_removes_the_projection_on_its_sensitivities_and_nothing_else():
    rng = np.random.default_rng(0)
    along, other = rng.normal(size=(2, 50))
    left = calibration_projector([along])
    assert left(3.0 * along) == pytest.approx(np.zeros(50), abs=1e-12)
    assert left(other) @ along == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("power", [0.5, 1.0, 3.0])
def test_the_search_finds_a_strength_or_says_that_the_range_ends(power):
    found = find_strength(lambda s: 7.0 * s**power, 2.0, 1e-4, 10.0, 1.0)
    assert found.reached
    assert 7.0 * found.strength**power == pytest.approx(2.0, rel=0.1)
    assert not find_strength(lambda s: 7.0 * s**power, 2.0, 1e-4, 0.01, 0.001).reached
