"""Laws of a first motion, the shortest history: equations (5) to (18) of docs/theory.md."""

import numpy as np
import pytest

from tendon_mj.theory import (
    displacement,
    driven_tensions,
    equivalent_backlash,
    output_tension,
    transmission_stiffness,
)
from tendon_mj.theory.history import TensionMemory

EA, LENGTH, PRETENSION = 20e3, 0.5, 20.0
SPRING = 8e3  # 10e3 and 40e3 in a row
SLACK = -PRETENSION * (1 / SPRING + LENGTH / EA)
MOTIONS = np.concatenate([np.linspace(SLACK, 0, 50)[1:], np.linspace(0, 8e-3, 50), [1e-12, -1e-12]])
LAMS = [0.0, 1e-9, 1e-3, 0.47, 1.0, 3.0]


def ends(xi, lam, spring=SPRING):
    """T_in and T_out of first motions, one for each ξ_in."""
    near, far = driven_tensions(np.atleast_1d(xi)[None], lam, PRETENSION, EA, LENGTH, spring)
    return near[0], far[0]


@pytest.mark.parametrize("lam", LAMS)
@pytest.mark.parametrize("tension", [25.0, 90.0, 16.0, 3.0])
def test_what_has_slid_has_an_exponential_profile_and_the_rest_is_as_it_was(tension, lam):
    way = np.sign(tension - PRETENSION)
    reach = way * np.log(tension / PRETENSION)  # (8)
    angle = np.linspace(0.0, lam, 31)
    profile = np.where(angle < reach, tension * np.exp(-way * angle), PRETENSION)  # (5)
    memory = TensionMemory(PRETENSION).after(tension)
    np.testing.assert_allclose(memory.tension(angle), profile, rtol=1e-14)
    slid = min(lam, reach)
    strained = way * tension * -np.expm1(-way * slid) - PRETENSION * slid  # (6), in λ EA/L
    stretch = LENGTH / EA * (strained / lam if lam > 1e-6 else tension - PRETENSION)
    spring = (output_tension([tension], lam, PRETENSION)[0] - PRETENSION) / SPRING
    xi = displacement([tension], lam, PRETENSION, EA, LENGTH, SPRING)[0]
    assert xi == pytest.approx(stretch + spring, rel=1e-8)


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
        np.testing.assert_allclose(out[outside], line, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("lam", LAMS)
def test_end_tensions_stay_within_the_capstan_ratio(lam):
    near, far = ends(MOTIONS, lam)
    assert np.all(near <= far * np.exp(lam) * (1 + 1e-13))
    assert np.all(near >= far * np.exp(-lam) * (1 - 1e-13))


def test_without_friction_the_transmission_is_springs_in_a_row():
    near, far = ends(MOTIONS, 0.0)
    stiffness = 1.0 / (1.0 / SPRING + LENGTH / EA)
    np.testing.assert_allclose(far, PRETENSION + stiffness * MOTIONS, rtol=1e-12, atol=1e-12)
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


def test_towards_the_slack_limit_tension_goes_to_zero():
    near, far = ends(SLACK * (1.0 - 1e-9), 1.0)
    assert 0.0 < near[0] < far[0] < 1e-6
