"""Laws of a step's flow, whichever algorithm found it."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as some

from tests.sheath.sweep import sweep
from tests.sheath.tendons import (
    EVERY,
    drawn_tight_at_its_output,
    random_tendons,
    solve_flow,
    tendon,
    wound_over_touching_guides,
)

EXACT = 1e-9  # relative


def after(segments, guides):
    """Unstretched lengths once the flow has passed."""
    return segments["stored"] + np.diff(np.concatenate([[0.0], guides["flow"], [0.0]]))


def lies_slack(segments):
    return not segments["tension"].any()


@EVERY
@given(random_tendons(slack=False))
def test_a_taut_tendon_always_has_a_solution(tables):
    assert solve_flow(*tables)


@pytest.mark.parametrize("seed", range(10))
def test_slack_and_constant_friction_together_have_a_solution(seed):
    rng = np.random.default_rng(seed)
    for _ in range(300):
        n = int(rng.integers(1, 8))
        strains = 1e-2 * rng.uniform(-1.0, 1.0, n + 1)
        bends = rng.uniform(0.0, 1.5, n)
        segments, guides = tendon(
            10.0 ** rng.uniform(-3, 0, n + 1), strains, bends, 0.5, 0.5, 1e-3 / n
        )
        assert solve_flow(segments, guides)
        strain = np.maximum(segments["length"] / after(segments, guides) - 1.0, 0.0)
        np.testing.assert_allclose(segments["tension"], strain, rtol=0, atol=1e-10)


@EVERY
@given(some.integers(1, 10), some.integers(0, 2**32 - 1))
def test_a_tendon_is_wound_over_guides_with_next_to_nothing_between_them(n, seed):
    segments, guides = wound_over_touching_guides(n, np.random.default_rng(seed))
    assert solve_flow(segments, guides)
    held = segments["length"] / (1.0 + segments["tension"])
    rounding = 1e-15 * segments["stored"].sum()
    np.testing.assert_allclose(after(segments, guides), held, rtol=0, atol=rounding)


@EVERY
@given(
    some.integers(1, 300),
    some.floats(0.0, 6.0),
    some.floats(1e-7, 1e-4),
    some.integers(0, 2**32 - 1),
)
def test_slack_is_drawn_over_guides_whose_tensions_are_at_their_bounds(n, exponent, rubs, seed):
    rng = np.random.default_rng(seed)
    strains, bend, constant = [0.0], exponent / n, rubs / n
    for _ in range(n):
        strains.append(np.exp(bend) * strains[-1] + constant)
    lengths = rng.uniform(0.01, 0.05, n + 1)
    segments, guides = tendon(lengths, strains, np.full(n, bend), 1.0, 1.0, constant)
    drawn = rng.uniform(0.1, 1.0) * (segments["length"] - segments["stored"]).sum()
    segments["stored"][0] += 1.5 * drawn
    segments["stored"][-1] -= drawn
    assert solve_flow(segments, guides)
    rounding = 1e-16 * (10 + n) * np.exp(exponent)  # which the ratio of the whole tendon amplifies
    np.testing.assert_allclose(segments["tension"], strains, rtol=0, atol=rounding)
    np.testing.assert_allclose(guides["flow"], -drawn, rtol=0, atol=rounding)


@EVERY
@given(some.integers(1, 512), some.integers(0, 2**32 - 1))
def test_a_slack_tendon_is_drawn_tight_at_its_output_over_many_guides(n, seed):
    segments, guides = drawn_tight_at_its_output(n, np.random.default_rng(seed))
    assert solve_flow(segments, guides)
    lacking = segments["length"] / (1.0 + segments["tension"]) - after(segments, guides)
    assert (lacking <= 1e-15).all()
    assert (lacking[segments["tension"] > 0.0] >= -1e-15).all()


@EVERY
@given(
    some.integers(1, 10),
    some.sampled_from([1e-4, 0.01, 1.0]),
    some.sampled_from([0.0, 1e-3, 1.0]),
    some.integers(0, 2**32 - 1),
)
def test_a_tendon_that_is_taut_or_slack_by_rounding_has_a_solution(n, strain_slope, drag, seed):
    rng = np.random.default_rng(seed)
    strains = rng.integers(-2, 3, n + 1) * np.finfo(float).eps
    bends, constant = rng.uniform(0.0, 1.5, n), rng.choice([0.0, 1e-4])
    segments, guides = tendon(rng.uniform(0.01, 0.1, n + 1), strains, bends, 0.1, 0.1, constant)
    segments["strain_slope"], segments["tension"], guides["drag"] = strain_slope, 0.0, drag
    assert solve_flow(segments, guides, drag > 0.0)
    assert segments["tension"].max() < 1e-14 / strain_slope


@EVERY
@given(random_tendons())
def test_every_segment_obeys_hooke_and_no_tendon_is_lost(tables):
    segments, guides = tables
    assume(solve_flow(segments, guides))
    stored = after(segments, guides)
    assert abs(stored.sum() - segments["stored"].sum()) <= 1e-15 * segments["stored"].sum() * 10
    strain = np.maximum(segments["length"] / stored - 1.0, 0.0)
    scale = max(strain.max(), 1e-6)
    np.testing.assert_allclose(segments["tension"], strain, rtol=0, atol=EXACT * scale + 2e-12)
    assert np.all(segments["tension"] >= 0.0), "a tendon does not push"


@EVERY
@given(random_tendons())
def test_a_guide_at_rest_holds_no_more_than_it_can(tables):
    segments, guides = tables
    assume(solve_flow(segments, guides))
    left, right = segments["tension"][:-1], segments["tension"][1:]
    rests = guides["flow"] == 0.0
    up = np.where(guides["previous_slip"] > 0.0, guides["dynamic_ratio"], guides["static_ratio"])
    down = np.where(guides["previous_slip"] < 0.0, guides["dynamic_ratio"], guides["static_ratio"])
    tolerance = EXACT * segments["tension"].max() + 1e-14
    assert np.all((left <= up * right + guides["constant_friction"] + tolerance)[rests])
    assert np.all((right <= down * left + guides["constant_friction"] + tolerance)[rests])


@EVERY
@given(random_tendons())
def test_a_guide_slides_at_its_bound_towards_the_higher_tension(tables):
    segments, guides = tables
    assume(solve_flow(segments, guides))
    left, right = segments["tension"][:-1], segments["tension"][1:]
    flow, ratio, rubs = guides["flow"], guides["dynamic_ratio"], guides["constant_friction"]
    assume(not lies_slack(segments))
    tolerance = EXACT * segments["tension"].max() + 1e-14
    # where both sides are slack, tendon may pass without rubbing
    taut = (left > 0.0) | (right > 0.0)
    up, down = taut & (flow > 0.0), taut & (flow < 0.0)
    held_up, held_down = ratio * right + rubs, ratio * left + rubs
    assert np.all(left[up] >= held_up[up] * (1 - EXACT) - tolerance)
    assert np.all(right[down] >= held_down[down] * (1 - EXACT) - tolerance)
    both = (left > 0.0) & (right > 0.0)
    assert np.all(np.abs(left - held_up)[up & both] <= tolerance)
    assert np.all(np.abs(right - held_down)[down & both] <= tolerance)
    assert np.all(guides["slip"][flow != 0.0] == np.sign(flow)[flow != 0.0])


@EVERY
@given(random_tendons())
def test_friction_only_takes_energy(tables):
    segments, guides = tables
    assume(solve_flow(segments, guides))
    work = (segments["tension"][:-1] - segments["tension"][1:]) * guides["flow"]
    assert work.min() >= -1e-13 * segments["tension"].max()


@EVERY
@given(random_tendons())
def test_a_step_after_a_step_changes_nothing(tables):
    segments, guides = tables
    assume(solve_flow(segments, guides))
    first = segments["tension"].copy()
    segments["stored"] = after(segments, guides)
    guides["previous_slip"] = np.sign(guides["flow"])
    assert solve_flow(segments, guides)
    np.testing.assert_allclose(segments["tension"], first, rtol=1e-9, atol=1e-12)


@EVERY
@given(random_tendons())
def test_it_agrees_with_a_root_search_in_each_segment_and_solves_what_that_does(tables):
    segments, guides = tables
    solved = solve_flow(segments, guides)
    other, held = segments.copy(), guides.copy()
    assume(sweep(other, held))
    assert solved
    scale = max(segments["tension"].max(), 1e-6)
    np.testing.assert_allclose(other["tension"], segments["tension"], rtol=0, atol=1e-9 * scale)
    if segments["tension"].min() > 0.0:
        length = segments["length"].sum()
        np.testing.assert_allclose(held["flow"], guides["flow"], rtol=0, atol=1e-9 * scale * length)


@EVERY
@given(
    some.sampled_from([(1.0, 1e-9), (0.1, 1e-8), (0.1, 1e-9, 0.1), (0.1, 0.2, 1e-9, 0.3)]),
    some.booleans(),
    some.integers(0, 2**32 - 1),
)
def test_beside_a_segment_of_next_to_nothing_it_agrees_with_that_too(lengths, driven, seed):
    rng = np.random.default_rng(seed)
    n = len(lengths) - 1
    differs = rng.uniform(-0.3, 0.3, n + 1) * rng.choice([0.01, 0.1, 1.0])
    strains = 10.0 ** rng.uniform(-6, -3) * (1.0 + differs)
    was = rng.integers(-1, 2, n).astype(float)
    segments, guides = tendon(lengths, strains, rng.uniform(0.0, 1.5, n), 0.3, 0.3, was=was)
    other, held = segments.copy(), guides.copy()
    assert solve_flow(segments, guides, given=driven)
    held["input_ratio"], held["output_ratio"] = guides["input_ratio"], guides["output_ratio"]
    assert sweep(other, held, driven)
    rounding = 4.0 * np.finfo(float).eps * max(lengths) / min(lengths)  # of its strain
    np.testing.assert_allclose(other["tension"], segments["tension"], rtol=0, atol=rounding)


@EVERY
@given(random_tendons(), some.sampled_from([2.0**-10, 2.0**10]))
def test_a_tendon_in_another_unit_of_length_has_the_same_tensions(tables, unit):
    segments, guides = tables
    other, held = segments.copy(), guides.copy()
    other["length"] *= unit
    other["stored"] *= unit
    assert solve_flow(other, held) == solve_flow(segments, guides)
    np.testing.assert_array_equal(other["tension"], segments["tension"])
    np.testing.assert_array_equal(held["flow"], unit * guides["flow"])
