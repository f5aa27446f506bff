"""The removable singularities, against decimals of 120 digits."""

from collections.abc import Callable
from decimal import Decimal, localcontext

import numpy as np
import pytest

from tendon_mj.theory import apparent_stiffness, equivalent_backlash, reversal_backlash
from tendon_mj.theory._exponential import log_ratio, mean_excess

SIZES = np.concatenate([np.geomspace(1e-30, 1e-8, 20), np.geomspace(1e-8, 60.0, 200)])
EXPONENTS = np.concatenate([-SIZES[::-1], SIZES])


def worst_error(values: np.ndarray, exact: Callable[[Decimal], Decimal]) -> float:
    """Largest relative error over EXPONENTS."""
    with localcontext() as context:
        context.prec = 120  # 1e-30 beside 1, twice over, leaves 60 digits
        errors = [
            abs(Decimal(float(value)) / exact(Decimal(float(z))) - 1)
            for value, z in zip(values, EXPONENTS, strict=True)
        ]
    return float(max(errors))


def test_apparent_stiffness_is_accurate_everywhere():
    values = apparent_stiffness(EXPONENTS, 1.0, 1.0)
    assert worst_error(values, lambda z: z / (z.exp() - 1)) < 2e-15


def test_equivalent_backlash_is_accurate_everywhere():
    values = equivalent_backlash(EXPONENTS, 1.0, 1.0, 1.0)
    assert worst_error(values, lambda z: (z.exp() - z - 1) / z) < 4e-15


def test_reversal_backlash_is_accurate_everywhere():
    values = reversal_backlash(EXPONENTS, 1.0, 1.0, 1.0)
    assert worst_error(values, lambda z: (z.exp() + (-z).exp() - 2) / z) < 2e-15


@pytest.mark.parametrize("start", [1.0 + 1e-9, 2.0, 300.0])
def test_mean_excess_is_accurate_relative_to_the_tension(start):
    values = mean_excess(np.asarray(start), np.asarray(1.0), EXPONENTS)
    with localcontext() as context:
        context.prec = 120
        for value, z in zip(values, EXPONENTS, strict=True):
            d = Decimal(float(z))
            stretched = Decimal(start) * (d.exp() - 1) / d
            error = abs(Decimal(float(value)) - (stretched - 1))
            assert error <= Decimal("2e-15") * max(stretched, Decimal(1))


def test_log_ratio_is_accurate_near_one_and_far_from_it():
    ratios = np.concatenate([1 + np.geomspace(1e-15, 1, 50), np.geomspace(1e-200, 1e200, 60)])
    values = log_ratio(ratios, np.asarray(1.0))
    for value, ratio in zip(values, ratios, strict=True):
        with localcontext() as context:
            context.prec = 50
            assert value == pytest.approx(float(Decimal(float(ratio)).ln()), rel=2e-15)
