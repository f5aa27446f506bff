"""A bounded least-squares step is where no direction that its bounds leave goes down."""

from __future__ import annotations

import numpy as np
import pytest

from tendon_mj.lab.diagnosis import bounded_least_squares


@pytest.mark.parametrize("decades", [0, 3, 6])
@pytest.mark.parametrize("seed", range(20))
def test_the_step_ends_where_nothing_within_its_bounds_is_less(decades: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    count = int(random.integers(1, 9))
    lengths = 10.0 ** random.uniform(-decades / 2, decades / 2, count)
    matrix = random.normal(size=(300, count)) @ random.normal(size=(count, count)) * lengths
    residual = random.normal(size=300)
    bounds = np.array([-1.0, 1.0])[:, None] * 10.0 ** random.uniform(-3, 1, (2, count)) / lengths
    step = bounded_least_squares(matrix, residual, bounds)
    assert (bounds[0] <= step).all()
    assert (step <= bounds[1]).all()
    # what is gained by moving a term by its width, of what there is to gain
    slope = matrix.T @ (residual + matrix @ step) * (bounds[1] - bounds[0]) / residual.size
    inside = 1e-9 * (bounds[1] - bounds[0])
    assert (slope[step > bounds[0] + inside] < 1e-6).all()
    assert (slope[step < bounds[1] - inside] > -1e-6).all()


@pytest.mark.parametrize("seed", range(20))
def test_columns_that_differ_by_more_than_a_number_has_digits_come_to_an_end(seed: int) -> None:
    """As those of a session's spread of 1e29 are."""
    random = np.random.default_rng(seed)
    lengths = 10.0 ** random.uniform(-30.0, 30.0, 6)
    matrix = random.normal(size=(300, 6)) @ random.normal(size=(6, 6)) * lengths
    bounds = np.array([-1.0, 1.0])[:, None] * 10.0 ** random.uniform(-9, 9, (2, 6))
    step = bounded_least_squares(matrix, random.normal(size=300), bounds)
    assert (bounds[0] <= step).all()
    assert (step <= bounds[1]).all()
