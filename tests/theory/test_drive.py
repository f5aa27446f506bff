"""Laws of the sheath driven by displacement."""

import numpy as np
import pytest

from tendon_mj.theory import (
    displacement,
    driven_tensions,
    first_input_tension,
    first_output_tension,
    output_tension,
    reversal_backlash,
    series_stiffness,
    transmission_stiffness,
)

EA, LENGTH, PRETENSION = 20e3, 0.5, 20.0
SPRING = float(series_stiffness(10e3, 40e3))
SHEATH = (PRETENSION, EA, LENGTH, SPRING)
LAMS = [0.0, 1e-9, 0.1, 0.47, 1.0, 3.0]


def random_walk(seed, size=120):
    steps = np.random.default_rng(seed).normal(0.0, 0.3, size)
    return PRETENSION * np.exp(np.cumsum(steps) * 0.6)


def random_motion(seed, size=120):
    return 1.5e-3 + 1.5e-3 * np.random.default_rng(seed).uniform(-1, 1, size)


@pytest.mark.parametrize("lam", LAMS)
@pytest.mark.parametrize("spring", [SPRING, np.inf])
def test_driving_by_the_displacement_gives_the_tension_back(lam, spring):
    walk = random_walk(4)
    sheath = (PRETENSION, EA, LENGTH, spring)
    near, far = driven_tensions(displacement(walk, lam, *sheath), lam, *sheath)
    np.testing.assert_allclose(near, walk, rtol=1e-9)
    np.testing.assert_allclose(far, output_tension(walk, lam, PRETENSION), rtol=1e-9)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("lam", LAMS)
def test_driven_tensions_stand_at_the_displacement(seed, lam):
    xi = random_motion(seed)
    near, far = driven_tensions(xi, lam, *SHEATH)
    np.testing.assert_allclose(displacement(near, lam, *SHEATH), xi, rtol=1e-12, atol=1e-17)
    np.testing.assert_allclose(output_tension(near, lam, PRETENSION), far, rtol=1e-13)


@pytest.mark.parametrize("lam", LAMS)
@pytest.mark.parametrize("end", [-2.5e-3, 6e-3])
def test_first_driven_motion_is_section_one(lam, end):
    xi = np.linspace(0.0, end, 40)
    near, far = driven_tensions(xi, lam, *SHEATH)
    np.testing.assert_allclose(near, first_input_tension(xi, lam, *SHEATH), rtol=1e-11)
    np.testing.assert_allclose(far, first_output_tension(xi, lam, *SHEATH), rtol=1e-11)


@pytest.mark.parametrize("lam", [1e-3, 0.47, 1.0, 2.0])
def test_outer_branches_have_the_transmission_stiffness_and_the_reversal_backlash(lam):
    high, low = 9e-3, 1e-3
    xi = np.concatenate([np.linspace(0, high, 200), np.linspace(high, low, 2001)[1:]])
    _, far = driven_tensions(xi, lam, *SHEATH)
    for part, signed in ((slice(190, 199), lam), (slice(-9, None), -lam)):
        slope = np.diff(far[part]) / np.diff(xi[part])
        np.testing.assert_allclose(
            slope, transmission_stiffness(signed, EA, LENGTH, 10e3, 40e3), rtol=1e-8
        )
    # the line of the loosening branch meets the tension of the reversal at high − Δξ
    slope = transmission_stiffness(-lam, EA, LENGTH, 10e3, 40e3)
    edge = xi[-1] + (far[199] - far[-1]) / slope
    travel = reversal_backlash(lam, far[199], EA, LENGTH)
    assert high - edge == pytest.approx(travel, rel=1e-10)
    held = xi[199:] > edge * (1 + 1e-12)
    np.testing.assert_allclose(far[199:][held], far[199], rtol=1e-14)
    assert far[199:][~held].max() < far[199]


def test_driven_minor_loop_closes():
    xi = np.array([5e-3, 2e-3, 3e-3, 2.5e-3, 2.8e-3, 2e-3, 1e-3])
    near, far = driven_tensions(xi, 0.8, *SHEATH)
    near2, far2 = driven_tensions(xi[[0, 1, 6]], 0.8, *SHEATH)
    np.testing.assert_allclose(near[[1, 5, 6]], near2[[1, 1, 2]], rtol=1e-11)
    np.testing.assert_allclose(far[[1, 5, 6]], far2[[1, 1, 2]], rtol=1e-11)


@pytest.mark.parametrize("lam", LAMS)
def test_holding_the_displacement_holds_the_tension(lam):
    near, far = driven_tensions(np.repeat(random_motion(6), 2), lam, *SHEATH)
    np.testing.assert_array_equal(near[::2], near[1::2])
    np.testing.assert_array_equal(far[::2], far[1::2])


@pytest.mark.parametrize("lam", [0.47, 2.0])
def test_friction_takes_energy_in_every_cycle(lam):
    phase = np.linspace(0, 3 * np.pi, 3001)
    near_xi = 2e-3 - 2e-3 * np.cos(phase)
    near, far = driven_tensions(near_xi, lam, *SHEATH)
    far_xi = (far - PRETENSION) / SPRING
    cycle = phase >= np.pi
    work = np.trapezoid(near[cycle], near_xi[cycle]) - np.trapezoid(far[cycle], far_xi[cycle])
    assert work > 1e-3


@pytest.mark.parametrize("lam", LAMS)
def test_a_motion_of_a_few_rounding_steps_neither_jumps_nor_turns_back(lam):
    steps = np.random.default_rng(7).integers(-3, 4, 400).cumsum()
    xi = 3e-3 + steps * np.spacing(3e-3)
    near, far = driven_tensions(xi, lam, *SHEATH)
    assert np.all(np.diff(near) * np.sign(np.diff(xi)) >= 0)
    # a reversal answers with the square root of the motion
    np.testing.assert_allclose(near, near[0], rtol=1e-6)
    np.testing.assert_allclose(far, far[0], rtol=1e-13)


def test_arguments_broadcast_behind_time():
    xi = np.tile(random_motion(5, 6)[:, None], 2)
    lam, pretension = np.array([0.2, 0.4, 0.8])[:, None], np.array([20.0, 30.0])
    near, far = driven_tensions(xi, lam, pretension, EA, LENGTH, SPRING)
    assert near.shape == far.shape == (6, 3, 2)
    one, other = driven_tensions(xi[:, 1], 0.4, 30.0, EA, LENGTH, SPRING)
    np.testing.assert_array_equal(near[:, 1, 1], one)
    np.testing.assert_array_equal(far[:, 1, 1], other)
