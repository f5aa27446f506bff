"""Laws of a step's flow where the input tension is given, as it is where MuJoCo pulls."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tests.sheath.sweep import sweep
from tests.sheath.tendons import EVERY, random_tendons, solve_flow, tendon

EXACT = 1e-9  # relative
PULLS = st.just(0.0) | st.floats(1e-5, 2e-2) | st.floats(1e-14, 1e-5)


def solved_for(tables, pull):
    """The tables with the tension ``pull`` at the input, where that has a solution."""
    segments, guides = tables
    segments["tension"][0] = pull
    assume(solve_flow(segments, guides, False, True))
    return segments, guides


def after(segments, guides):
    """Unstretched lengths of all segments but the first once the flow has passed."""
    return segments["stored"][1:] + np.diff(np.concatenate([guides["flow"], [0.0]]))


@EVERY
@given(random_tendons(slack=False), st.floats(1e-4, 2e-2))
def test_a_tendon_that_is_pulled_always_has_a_solution(tables, pull):
    segments, guides = tables
    guides["constant_friction"] = 0.0
    segments["tension"][0] = pull
    assert solve_flow(segments, guides, False, True)


@EVERY
@given(random_tendons(), PULLS)
def test_the_input_tension_stays_and_the_others_obey_hooke(tables, pull):
    segments, guides = solved_for(tables, pull)
    assert segments["tension"][0] == pull
    strain = np.maximum(segments["length"][1:] / after(segments, guides) - 1.0, 0.0)
    scale = max(strain.max(initial=0.0), 1e-6)
    np.testing.assert_allclose(segments["tension"][1:], strain, rtol=0, atol=EXACT * scale + 2e-12)


@EVERY
@given(random_tendons(), PULLS)
def test_no_tension_leaves_what_all_guides_together_hold(tables, pull):
    segments, guides = solved_for(tables, pull)
    assume(not guides["constant_friction"].any())
    reach = np.concatenate([[1.0], np.cumprod(guides["static_ratio"])])
    tension = segments["tension"]
    assert (tension <= pull * reach * (1 + EXACT) + 1e-14).all()
    assert (tension >= pull / reach * (1 - EXACT) - 1e-14).all()


@EVERY
@given(random_tendons(), PULLS)
def test_friction_only_takes_energy(tables, pull):
    segments, guides = solved_for(tables, pull)
    work = (segments["tension"][:-1] - segments["tension"][1:]) * guides["flow"]
    assert work.min(initial=0.0) >= -1e-13 * max(segments["tension"].max(), 1e-6)


@EVERY
@given(random_tendons(), PULLS)
def test_a_guide_that_slides_is_at_its_bound(tables, pull):
    segments, guides = solved_for(tables, pull)
    left, right, flow = segments["tension"][:-1], segments["tension"][1:], guides["flow"]
    tolerance = EXACT * segments["tension"].max() + 1e-13
    up, down = (flow > 0.0) & (right > 0.0), (flow < 0.0) & (left > 0.0) & (right > 0.0)
    ratio, rubs = guides["dynamic_ratio"], guides["constant_friction"]
    assert (np.abs(left - ratio * right - rubs)[up] <= tolerance).all()
    assert (np.abs(right - ratio * left - rubs)[down] <= tolerance).all()


@EVERY
@given(random_tendons(slack=False), st.floats(1e-4, 2e-2))
def test_it_agrees_with_a_root_search_in_each_segment_and_solves_what_that_does(tables, pull):
    segments, guides = tables
    segments["tension"][0] = pull
    solved = solve_flow(segments, guides, False, True)
    other, held = segments.copy(), guides.copy()
    other["tension"][0] = pull
    assume(sweep(other, held, True))
    assert solved
    np.testing.assert_allclose(other["tension"], segments["tension"], rtol=1e-7, atol=1e-12)


@EVERY
@given(random_tendons(), PULLS)
def test_without_friction_every_tension_is_the_given_one(tables, pull):
    segments, guides = tables
    guides["static_ratio"] = guides["dynamic_ratio"] = 1.0
    guides["static_ratio_back"] = guides["dynamic_ratio_back"] = 1.0
    guides["constant_friction"] = 0.0
    segments["tension"][0] = pull
    assert solve_flow(segments, guides, False, True)
    assert (segments["tension"] == pull).all()


@pytest.mark.parametrize("stiffer", [1.0, 1e4])
@pytest.mark.parametrize(("most", "bend"), [(10, 1.5), (120, 0.1)])
def test_a_pulled_tendon_at_the_most_that_its_guides_allow_is_solved(most, bend, stiffer):
    """The tensions of its first stretches are then that bound, to the last bit or beyond it."""
    rng = np.random.default_rng(1)
    for _ in range(1500):
        n = int(rng.integers(2, most))
        lengths, strains = (
            10.0 ** rng.uniform(-3, 0, n + 1),
            rng.uniform(0.005, 0.1, n + 1) / stiffer,
        )
        bends, mu_s = rng.uniform(0.0, bend, n), rng.choice([0.05, 0.2, 0.5])
        segments, guides = tendon(lengths, strains, bends, mu_s, 0.05)
        segments["tension"][0] = rng.uniform(0.002, 0.15) / stiffer
        assert solve_flow(segments, guides, False, True)
