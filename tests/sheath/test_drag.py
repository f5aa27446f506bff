"""The flow problem where sliding itself takes tension."""

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as some

from tests.sheath.tendons import EVERY, random_tendons, solve_flow, tendon

# D ℓ: from hardly felt to a wave that crosses a segment in many steps
drags = some.sampled_from([1e-6, 1e-3, 1.0, 1e3])


def dragged(tables, drag, momentum, seed=0):
    segments, guides = tables
    rng = np.random.default_rng(seed)
    guides["drag"] = drag / segments["length"].mean()
    scale = np.abs(segments["tension"]).max()
    guides["momentum"] = momentum * scale * rng.normal(size=len(guides))
    return segments, guides


def kept(segments, guides):
    return segments["stored"] + np.diff(np.concatenate([[0.0], guides["flow"], [0.0]]))


def check(segments, guides):
    """The law at every guide, Hooke's in every segment, to what rounding of the flows leaves."""
    stored = kept(segments, guides)
    flows = np.abs(np.concatenate([[0.0], guides["flow"], [0.0]]))
    rounded = np.finfo(float).eps * (stored + flows[:-1] + flows[1:]) / segments["length"]
    assert stored.min() > 0.0
    strain = np.maximum(segments["length"] / stored - 1.0, 0.0)
    scale = max(strain.max(), np.abs(guides["momentum"]).max(), 1e-6)
    assert np.all(np.abs(segments["tension"] - strain) <= 1e-9 * scale + rounded)
    left, right = segments["tension"][:-1], segments["tension"][1:]
    flow, takes = guides["flow"], guides["drag"] * guides["flow"] + guides["momentum"]
    up = left - guides["input_ratio"] * right - guides["constant_friction"] - takes
    down = right - guides["output_ratio"] * left - guides["constant_friction"] + takes
    tolerance = 1e-8 * scale
    np.testing.assert_allclose(up[flow > 0.0], 0.0, atol=tolerance)
    np.testing.assert_allclose(down[flow < 0.0], 0.0, atol=tolerance)
    assert np.all(up[flow == 0.0] <= tolerance)
    assert np.all(down[flow == 0.0] <= tolerance)


@EVERY
@given(random_tendons(), drags, some.sampled_from([0.0, 0.1, 1.0]), some.integers(0, 99))
def test_every_tendon_has_a_solution_that_obeys_the_law(tables, drag, momentum, seed):
    segments, guides = dragged(tables, drag, momentum, seed)
    assert solve_flow(segments, guides, True)
    check(segments, guides)


@EVERY
@given(random_tendons(most=60), drags, some.sampled_from([0.0, 0.1, 1.0]), some.integers(0, 99))
def test_a_tendon_over_many_guides_has_a_solution(tables, drag, momentum, seed):
    segments, guides = dragged(tables, drag, momentum, seed)
    assert solve_flow(segments, guides, True)
    check(segments, guides)


@settings(max_examples=20, derandomize=True)
@given(random_tendons(most=512), drags)
def test_a_tendon_over_very_many_guides_has_a_solution(tables, drag):
    segments, guides = dragged(tables, drag, 0.1)
    assert solve_flow(segments, guides, True)
    check(segments, guides)


@settings(max_examples=60, derandomize=True)
@given(random_tendons(most=20), drags, some.integers(-1, 1), some.integers(0, 99))
def test_the_solution_does_not_depend_on_the_slip_before(tables, drag, was, seed):
    segments, guides = dragged(tables, drag, 0.3, seed)
    guides["static_ratio"] = guides["dynamic_ratio"]
    guides["static_ratio_back"] = guides["dynamic_ratio_back"]
    other, held = segments.copy(), guides.copy()
    held["previous_slip"] = was
    assert solve_flow(segments, guides, True)
    assert solve_flow(other, held, True)
    scale = max(segments["tension"].max(), 1e-6)
    np.testing.assert_allclose(other["tension"], segments["tension"], rtol=0, atol=1e-9 * scale)


@EVERY
@given(random_tendons(most=30), drags, some.floats(0.05, 0.3), some.integers(0, 99))
def test_a_segment_that_was_emptied_is_filled_by_its_neighbours(tables, drag, part, seed):
    segments, guides = dragged(tables, drag, 0.0)
    rng = np.random.default_rng(seed)
    empty = rng.random(len(segments)) < part
    segments["stored"][empty] = -0.1 * segments["length"][empty]
    assume(segments["stored"].sum() > 0.5 * segments["length"].sum())
    assert solve_flow(segments, guides, True)
    check(segments, guides)


@EVERY
@given(random_tendons(slack=False))
def test_less_and_less_drag_is_none(tables):
    segments, guides = tables
    other, held = dragged((segments.copy(), guides.copy()), 1e-12, 0.0)
    assert solve_flow(segments, guides)
    assert solve_flow(other, held, True)
    scale = segments["tension"].max()
    np.testing.assert_allclose(other["tension"], segments["tension"], rtol=0, atol=1e-7 * scale)


def lacks_at_most(rounding, segments, guides):
    """Whether a solution is found in which the law of no sliding guide lacks more."""
    solved = solve_flow(segments, guides, True)
    flow, left, right = guides["flow"], segments["tension"][:-1], segments["tension"][1:]
    up, down = left - guides["input_ratio"] * right, guides["output_ratio"] * left - right
    lacks = np.where(flow > 0.0, up, down) - guides["drag"] * flow - guides["momentum"]
    return solved and np.abs(lacks[flow != 0.0]).max(initial=0.0) <= rounding


@EVERY
@given(some.sampled_from([1.0, 0.6, 0.05]), some.floats(0.05, 5.0), some.integers(0, 2**32 - 1))
def test_between_slack_segments_a_law_lacks_no_more_than_rounding(strain_slope, drag, seed):
    rng = np.random.default_rng(seed)
    strains = rng.uniform([-0.7, -1e-3, -0.7], [0.0, 1e-3, 0.0])
    segments, guides = tendon(rng.uniform(0.01, 0.1, 3), strains, [0.5, 0.5], 0.1, 0.1)
    segments["strain_slope"] = strain_slope
    guides["drag"], guides["momentum"] = drag, rng.uniform(3e-4, 5e-4, 2)
    assert lacks_at_most(3e-15 / strain_slope, segments, guides)


def test_a_step_of_rounding_draws_no_slack_segment_tight():
    lengths = [0.021288792178678018, 0.07104279282671339, 0.06524385918504266]
    segments, guides = tendon(lengths, [0.0, 0.0, 0.0], [0.5, 0.5], 0.1, 0.1)
    segments["stored"] = 0.04090915750453488, 0.07102176386922186, 0.04786876312667433
    segments["strain_slope"], guides["drag"] = 0.5073181630929654, 0.00050058545874262
    guides["momentum"] = 8.06584085779387e-06, 9.373051489160408e-06
    assert lacks_at_most(6e-15, segments, guides)


def test_more_drag_lets_less_pass():
    passed = []
    for drag in (1e-3, 1.0, 10.0, 1e3):
        strains = [2e-3, 1e-3, 1e-3]
        tables = tendon([0.1, 0.1, 0.1], strains, [0.2, 0.2], 0.3, 0.3)
        segments, guides = dragged(tables, drag, 0.0)
        assert solve_flow(segments, guides, True)
        passed.append(guides["flow"][0])
    assert np.all(np.diff(passed) < 0.0)
    assert passed[-1] > 0.0


def test_a_tendon_that_is_all_wound_up_has_no_solution():
    segments, guides = dragged(tendon([0.1, 0.1], [1e-3, 1e-3], [0.2], 0.3, 0.3), 1.0, 0.0)
    segments["stored"] = -0.1, 0.05
    assert not solve_flow(segments, guides, True)
    assert not guides["flow"].any()
    # what is emptied has no bound; what holds half the tendon of its length is twice as long
    np.testing.assert_allclose(segments["tension"], [np.inf, 1.0], rtol=1e-12)
