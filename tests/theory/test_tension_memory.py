"""Laws of the memory of turning points."""

import numpy as np
import pytest

from tendon_mj.theory import TensionMemory, output_tension

PRETENSION = 20.0


def remember(history, pretension=PRETENSION):
    memory = TensionMemory(pretension)
    for tension in history:
        memory = memory.after(tension)
    return memory


def random_walk(seed, size=200):
    steps = np.random.default_rng(seed).normal(0.0, 0.4, size)
    return PRETENSION * np.exp(np.cumsum(steps) * 0.7)


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
