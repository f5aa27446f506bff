"""Where there is little or no tendon, or far too much of it; what is solved is what holds."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as some

from tendon_mj.sheath import held
from tendon_mj.sheath.segment_law import tension_of
from tests.sheath.tendons import solve_flow, tendon, uniform

ANY = some.floats(allow_nan=True, allow_infinity=True)


@pytest.mark.parametrize("n", [1, 2, 16])
@pytest.mark.parametrize("left", [-1e-12, -0.1])
def test_without_tendon_it_says_so_and_nothing_flows(n, left):
    segments, guides = uniform(n, 0.5)
    segments["stored"][0] -= segments["stored"].sum() - left
    assert not solve_flow(segments, guides)
    assert not guides["flow"].any()


@pytest.mark.parametrize("left", [0.4, 0.1, 0.02])
def test_a_little_tendon_is_still_solved(left):
    segments, guides = uniform(8, 0.5, length=0.5)
    segments["stored"][0] -= segments["stored"].sum() - left
    assert solve_flow(segments, guides)
    ratios = segments["tension"][:-1] / segments["tension"][1:]
    np.testing.assert_allclose(ratios, np.exp(0.5 / 8), rtol=1e-9)
    stored = segments["length"] / (1.0 + segments["tension"])
    assert stored.sum() == pytest.approx(left, rel=1e-9)


@pytest.mark.parametrize("n", [1, 5, 16])
def test_a_tendon_longer_than_its_path_carries_nothing(n):
    segments, guides = uniform(n, 0.5)
    segments["stored"][0] += 0.1
    assert solve_flow(segments, guides)
    assert not segments["tension"].any()


def test_slack_at_the_input_leaves_the_far_tension_held_by_friction():
    segments, guides = uniform(4, 3.0)
    segments["stored"][0] += 2e-4
    assert solve_flow(segments, guides)
    assert segments["tension"][0] < 0.2 * segments["tension"][-1]


def test_friction_cannot_hold_against_no_tension_at_all():
    # e^λ times nothing is nothing: what is slack at one end is slack at the other
    segments, guides = tendon([0.1, 0.1], [-0.5, 1e-3], [1.0], 1.0, 1.0)
    assert solve_flow(segments, guides)
    assert not segments["tension"].any()


def test_a_jump_of_the_input_by_the_whole_backlash_is_solved_in_one_step():
    many, once = uniform(16, 1.0), uniform(16, 1.0)
    for tables, steps in ((many, 400), (once, 1)):
        for _ in range(steps):
            tables[0]["stored"][0] -= 5e-3 / steps
            assert solve_flow(*tables)
            flow = np.concatenate([[0.0], tables[1]["flow"], [0.0]])
            tables[0]["stored"] += np.diff(flow)
    np.testing.assert_allclose(once[0]["tension"], many[0]["tension"], rtol=1e-9)


@settings(max_examples=300, derandomize=True)
@given(some.integers(1, 6), some.booleans(), some.data())
def test_it_ends_whatever_it_is_given_and_a_tension_is_a_number_or_inf(n, pulled, data):
    segments, guides = uniform(n, 0.5)
    for row in ("length", "stored", "tension"):
        segments[row] = data.draw(some.lists(ANY, min_size=n + 1, max_size=n + 1))
    for row in ("static_ratio", "dynamic_ratio", "constant_friction", "previous_slip"):
        guides[row] = data.draw(some.lists(ANY, min_size=n, max_size=n))
    solved = solve_flow(segments, guides, False, pulled)
    assert not np.isnan(segments["tension"]).any()
    if not np.isfinite(segments["tension"]).all():
        assert not solved
        assert not guides["flow"].any()


@settings(max_examples=100, derandomize=True)
@given(some.floats(1e-3, 1.0), some.floats(1e-9, 0.5), some.floats(0.0, 10.0))
def test_a_segment_holds_what_its_tension_says(length, tau, give):
    segments, _ = uniform(1, 0.0)
    segments["length"], segments["support_compliance"] = length, give * length
    holds, falls, bends = held(segments, 0, tau)
    if holds > 1e-3 * length:
        segments["stored"] = holds
        assert tension_of(segments, 0) == pytest.approx(tau, rel=1e-9, abs=1e-13)
        step = 1e-6 * (1.0 + tau)
        after, before = held(segments, 0, tau + step), held(segments, 0, tau - step)
        assert falls == pytest.approx((after[0] - before[0]) / (2 * step), rel=1e-5)
        assert bends == pytest.approx((after[1] - before[1]) / (2 * step), rel=1e-5)
