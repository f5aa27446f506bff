"""MuJoCo's frictionloss is one force; the sheath follows the capstan law."""

import math

import numpy as np
import pytest

from experiments.benchmarks.frictionloss import (
    compare_frictionloss,
    deviation,
    motor_bench,
    output_tension,
    slow_tension,
)
from tendon_mj import theory
from tendon_mj.models import Bench

BENCH = Bench()
PULLED = slow_tension(BENCH, 2000)
FORCE = 5.0


def coulomb(pulled, start, force):
    """T_out behind one force, whatever the tension."""
    now, found = start, []
    for tension in pulled:
        now = min(max(now, tension - force), tension + force)
        found.append(now)
    return np.array(found)


def test_the_motor_s_tension_is_between_half_and_twice_the_mean():
    assert PULLED[0] == pytest.approx(BENCH.pretension)
    assert PULLED.max() == pytest.approx(2.0 * BENCH.pretension, rel=1e-5)
    assert PULLED.min() == pytest.approx(0.5 * BENCH.pretension, rel=1e-5)


def test_without_friction_all_of_the_tension_arrives():
    found = output_tension(motor_bench(BENCH, friction=0.0), PULLED)
    np.testing.assert_allclose(found, PULLED, rtol=1e-12)


def test_a_stiff_frictionloss_is_one_force_whatever_the_tension():
    found = output_tension(motor_bench(BENCH, frictionloss=FORCE, stiff=True), PULLED)
    expected = coulomb(PULLED, BENCH.pretension, FORCE)
    assert np.quantile(np.abs(found - expected), 0.95) < 0.02 * FORCE
    assert np.abs(found - PULLED).max() == pytest.approx(FORCE, rel=1e-6)


def test_the_capstan_law_deviates_from_itself_by_nothing():
    exact = theory.output_tension(PULLED, BENCH.exponent, BENCH.pretension)
    assert deviation(PULLED, exact, BENCH).largest == 0.0
    assert deviation(PULLED, 1.1 * exact, BENCH).rms == pytest.approx(0.1)


def test_the_sheath_follows_the_capstan_law_and_frictionloss_does_not():
    found = compare_frictionloss(BENCH, rounds=1)
    assert found.force == pytest.approx(BENCH.pretension * (1.0 - math.exp(-BENCH.exponent)))
    assert found.sheath_error.largest < 0.002
    # T_in − F where F is right at half of T_in: (1 + e^{−λ})/2 over e^{−λ}
    ratio = 0.5 * (1.0 + math.exp(BENCH.exponent))
    assert found.error.at_most == pytest.approx(ratio - 1.0, abs=0.01)
    assert found.error.largest >= found.error.rms > 0.1
    assert found.default_error.largest > found.error.largest
