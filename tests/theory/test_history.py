"""Laws of any history: the play operator, a drive by displacement, the memory of both."""

import numpy as np
import pytest

from tendon_mj.theory import (
    displacement,
    driven_tensions,
    output_tension,
    reversal_backlash,
    transmission_stiffness,
)
from tendon_mj.theory.history import TensionMemory

EA, LENGTH, PRETENSION = 20e3, 0.5, 20.0
SPRING = 8e3  # 10e3 and 40e3 in a row
SHEATH = (PRETENSION, EA, LENGTH, SPRING)
LAMS = [0.0, 1e-9, 0.1, 0.47, 1.0, 3.0]


def random_walk(seed, size=120):
    steps = np.random.default_rng(seed).normal(0.0, 0.2, size)
    return PRETENSION * np.exp(np.cumsum(steps))


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


def remember(history, pretension=PRETENSION):
    memory = TensionMemory(pretension)
    for tension in history:
        memory = memory.after(tension)
    return memory


@pytest.mark.parametrize("seed", range(8))
def test_memory_gives_the_play_at_every_depth(seed):
    walk = random_walk(seed)
    depths = np.linspace(0.0, 6.0, 301)
    memory = TensionMemory(PRETENSION)
    for tension, row in zip(walk, output_tension(walk, depths, PRETENSION), strict=True):
        memory = memory.after(tension)
        np.testing.assert_allclose(memory.tension(depths), row, rtol=1e-13)


@pytest.mark.parametrize("seed", range(8))
def test_mean_excess_is_the_mean_of_the_profile(seed):
    memory = remember(random_walk(seed))
    ends = np.array([0.01, 0.3, 1.0, 4.0])
    nodes, weights = np.polynomial.legendre.leggauss(10)
    for end in ends:
        knots = np.unique([0.0, end, *memory._depths[memory._depths < end]])
        half = np.diff(knots)[:, None] / 2
        inner = knots[:-1, None] + half * (nodes + 1)
        mean = np.sum((memory.tension(inner) - PRETENSION) * weights * half) / end
        assert memory.mean_excess(end) == pytest.approx(mean, rel=1e-12)
    np.testing.assert_array_equal(
        memory.mean_excess(ends), [float(memory.mean_excess(end)) for end in ends]
    )
    limit = memory.mean_excess(0.0)
    assert limit == memory.turning_points[-1] - PRETENSION
    assert memory.mean_excess(1e-13) == pytest.approx(limit, rel=1e-11)


@pytest.mark.parametrize("seed", range(8))
def test_turning_points_are_nested(seed):
    depths = remember(random_walk(seed))._depths
    assert np.all(np.diff(depths) > 0)


def test_a_monotone_motion_remembers_only_its_end():
    assert remember([21.0, 25.0, 25.0, 30.0]).turning_points == (30.0,)
    assert remember([19.0, 12.0]).turning_points == (12.0,)


def test_a_closed_loop_leaves_no_trace():
    before = remember([60.0, 30.0, 50.0])
    assert remember([60.0, 30.0, 50.0, 42.0, 47.0, 44.0, 50.0]) == before
    assert remember([60.0, 30.0, 50.0, 30.0]) == remember([60.0, 30.0])
    assert remember([60.0, 30.0, 50.0, 60.0]) == remember([60.0])
    assert remember([60.0, 30.0, 50.0, 20.0, 70.0]) == remember([70.0])


def test_the_first_motion_is_wiped_out_at_its_mirror_image():
    mirror = PRETENSION**2 / 60.0
    assert remember([60.0, mirror * 1.001]).turning_points == (60.0, mirror * 1.001)
    assert remember([60.0, mirror * 0.999]) == remember([mirror * 0.999])


def test_before_any_motion_the_tension_is_uniform():
    memory = TensionMemory(PRETENSION)
    np.testing.assert_array_equal(memory.tension([0.0, 1.0]), PRETENSION)
    np.testing.assert_array_equal(memory.mean_excess([0.0, 1.0]), 0.0)
    assert memory.sliding_depth == 0
    np.testing.assert_array_equal(memory.after(PRETENSION).tension([0.0, 1.0]), PRETENSION)


def test_sliding_depth_is_half_the_log_of_the_reversal():
    assert remember([40.0]).sliding_depth == pytest.approx(np.log(2.0))
    assert remember([40.0, 30.0]).sliding_depth == pytest.approx(np.log(4 / 3) / 2)
