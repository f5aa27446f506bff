"""Thresholds of the selection, on a rig of which signals, noise and parameters are known."""

from dataclasses import replace

import numpy as np
import pytest

from tendon_mj.lab.diagnosis import Problem, all_samples
from tendon_mj.lab.diagnosis.thresholds import (
    CLOSED,
    discretisation_error,
    least_share,
    unexplained_excess,
)
from tests.lab.diagnosis.toy import Toy, recording


def problem(count, known=None):
    recordings = [recording(f"r{k}", k, {}) for k in range(count)]
    if known:
        recordings = [replace(r, known={known: 0.1 * k}) for k, r in enumerate(recordings)]
    return Problem(recordings, Toy(recordings), all_samples(recordings))


def test_across_states_of_a_rig_an_effect_has_to_gain_more():
    alike, differing = problem(3), problem(3, known="sheath.constant_friction")
    assert least_share(differing) > least_share(alike) > 0.0


def test_lumping_leaves_less_where_residuals_are_judged_by_wider_bars():
    rig = problem(2)
    size = rig.residuals([{}]).shape[1]
    plain = discretisation_error(rig)
    assert plain > 0.0
    assert discretisation_error(rig, np.ones(size)) == pytest.approx(plain)
    assert discretisation_error(rig, np.full(size, 4.0)) == pytest.approx(plain / 16.0)


@pytest.mark.parametrize("rms", [1.0, 1.5, 4.0, 100.0])  # over the noise
def test_what_may_remain_is_a_part_of_the_error_above_the_noise(rms):
    left = np.sqrt(1.0 + unexplained_excess(rms**2 - 1.0))
    assert left - 1.0 == pytest.approx((1.0 - CLOSED) * (rms - 1.0), abs=1e-12)


def test_of_an_error_below_the_noise_nothing_may_remain():
    assert unexplained_excess(-0.5) == 0.0
