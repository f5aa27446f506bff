"""A tendon pulled or paid out until all of it slides: T_out/T_in = e^{∓λ}."""

import numpy as np
import pytest

from tests.sheath.sweep import sweep
from tests.sheath.tendons import commit, solve_flow, tendon, uniform

GUIDES = [*range(1, 17), 24, 32, 48, 64]


def drive(segments, guides, amount, solve=solve_flow, steps=20):
    """Wind tendon in (or pay it out) at the input, step by step."""
    for _ in range(steps):
        segments["stored"][0] -= amount / steps
        assert solve(segments, guides)
        commit(segments, guides)


@pytest.mark.parametrize("n", GUIDES)
@pytest.mark.parametrize("exponent", [0.05, 0.47, 1.5, 3.0])
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_sliding_tendon_loses_e_to_the_minus_lambda(n, exponent, direction):
    segments, guides = uniform(n, exponent)
    drive(segments, guides, 0.02 if direction > 0 else -0.5 * 0.98e-3)
    assert np.all(guides["slip"] == direction)
    ratio = segments["tension"][-1] / segments["tension"][0]
    assert ratio == pytest.approx(np.exp(-exponent * direction), rel=1e-9)


@pytest.mark.parametrize("n", [1, 2, 16])
def test_constant_friction_adds_to_the_capstan(n):
    lengths, strains = np.full(n + 1, 0.5 / (n + 1)), np.full(n + 1, 1e-3)
    rubs = 2e-4
    segments, guides = tendon(lengths, strains, np.full(n, 0.8 / n), 1.0, 1.0, rubs / n)
    drive(segments, guides, 0.02)
    expected = segments["tension"][-1]
    for _ in range(n):
        expected = expected * np.exp(0.8 / n) + rubs / n
    assert segments["tension"][0] == pytest.approx(expected, rel=1e-9)
    straight, free = tendon(lengths, strains, np.zeros(n), 1.0, 1.0, rubs / n)
    drive(straight, free, 0.02)
    assert straight["tension"][0] - straight["tension"][-1] == pytest.approx(rubs, rel=1e-9)


def test_static_friction_holds_until_it_breaks_and_then_slides_at_the_dynamic():
    segments, guides = tendon([0.1, 0.1], [1e-3, 1e-3], [1.0], 0.4, 0.2)
    ratios, slid = [], []
    for _ in range(60):
        segments["stored"][0] -= 2e-6
        assert solve_flow(segments, guides)
        ratios.append(segments["tension"][0] / segments["tension"][1])
        slid.append(guides["flow"][0] != 0.0)
        commit(segments, guides)
    first = slid.index(True)
    assert np.exp(0.38) < ratios[first - 1] <= np.exp(0.4) * (1 + 1e-12)
    np.testing.assert_allclose(ratios[first:], np.exp(0.2), rtol=1e-9)
    assert all(slid[first:]), "it does not stick again while it is pulled"


def test_a_break_at_one_guide_takes_its_neighbours_along():
    segments, guides = tendon([0.1] * 4, [1e-3] * 4, [1.0] * 3, 0.4, 0.1)
    while not guides["flow"].any():
        segments["stored"][0] -= 2e-6
        assert solve_flow(segments, guides)
        commit(segments, guides)
    # the first guide lets go at e^0.4 and passes on more than its neighbours would have held
    ratios = segments["tension"][:-1] / segments["tension"][1:]
    np.testing.assert_allclose(ratios[guides["flow"] > 0.0], np.exp(0.1), rtol=1e-9)
    assert np.all(ratios <= np.exp(0.4) * (1 + 1e-12))


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_both_routes_follow_the_same_path(direction):
    fast, sure = uniform(12, 1.0), uniform(12, 1.0)
    sure[1]["input_ratio"] = sure[1]["output_ratio"] = sure[1]["dynamic_ratio"]
    for _ in range(30):
        for tables, solve in ((fast, solve_flow), (sure, sweep)):
            drive(*tables, direction * 1e-5, solve, 1)
        np.testing.assert_allclose(fast[0]["tension"], sure[0]["tension"], rtol=1e-9)


def test_the_two_ends_may_be_swapped():
    segments, guides = uniform(7, 0.9)
    mirrored, mirror = segments[::-1].copy(), guides[::-1].copy()
    for _ in range(25):
        segments["stored"][0] -= 2e-5
        mirrored["stored"][-1] -= 2e-5
        assert solve_flow(segments, guides)
        assert solve_flow(mirrored, mirror)
        commit(segments, guides)
        commit(mirrored, mirror)
        np.testing.assert_allclose(mirrored["tension"][::-1], segments["tension"], rtol=1e-9)
        np.testing.assert_array_equal(mirror["slip"][::-1], -guides["slip"])


def test_without_friction_one_tension_runs_through():
    segments, guides = tendon([0.1, 0.3, 0.2], [2e-3, 1e-3, 5e-4], [1.0, 0.5], 0.0, 0.0)
    total = segments["stored"].sum()
    assert solve_flow(segments, guides)
    np.testing.assert_allclose(segments["tension"], 0.6 / total - 1.0, rtol=1e-12)
