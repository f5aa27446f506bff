"""The flow solver on Warp agrees with the plugin's, on random tendons."""

import numpy as np
import pytest

from tests.warp.models import tw  # noqa: F401

wp = pytest.importorskip("warp")

from tendon_mj.sheath import GUIDE as GUIDE_TYPE  # noqa: E402
from tendon_mj.sheath import SEGMENT as SEGMENT_TYPE  # noqa: E402
from tendon_mj.warp.tendons import ELASTIC, WOUND, Tendons  # noqa: E402
from tests.sheath.tendons import (  # noqa: E402
    drawn_tight_at_its_output,
    solve_flow,
    wound_over_touching_guides,
)
from tests.warp.solver_kernel import solve_all  # noqa: E402

CASES = 300
GUIDES = (1, 2, 5, 12)
SEGMENT = {"length": "length", "give": "support_compliance", "kept": "stored"}


def tendon(n, given, rng):
    """A random tendon: taut, slack in places or all over, with much friction or none."""
    segments, guides = np.zeros(n + 1, SEGMENT_TYPE), np.zeros(n, GUIDE_TYPE)
    strain = rng.choice([1e-16, 1e-5, 1e-3, 1e-2])
    taut = rng.choice([0.0, 1.0, 1.0, 1.0])
    segments["length"] = rng.uniform(0.01, 0.1, n + 1)
    segments["stored"] = segments["length"] / (1.0 + strain * (rng.normal(size=n + 1) + taut))
    segments["support_compliance"] = rng.choice([0.0, 0.3]) * rng.random(n + 1)
    segments["tension"] = strain * rng.random(n + 1) * rng.choice([0.0, 1.0], n + 1)
    segments["strain_slope"] = 1.0
    dynamic = np.exp(rng.choice([0.0, 0.1, 1.0]) * rng.random(n))
    static = dynamic * np.exp(rng.choice([0.0, 0.2]) * rng.random(n))
    for back in ("", "_back"):
        guides[f"dynamic_ratio{back}"], guides[f"static_ratio{back}"] = dynamic, static
    guides["constant_friction"] = strain * rng.choice([0.0, 0.1]) * rng.random()
    guides["previous_slip"] = rng.integers(-1, 2, n)
    if given:
        segments["tension"][0] = strain * rng.choice([0.0, 1.0, 2.0])
    return segments, guides


def on_device(cases, given):
    """(worlds,) cases of one number of guides as Warp has them, and their ratios."""
    t, count = Tendons(), len(cases)
    n = len(cases[0][1])

    def columns(values, kind):
        return wp.array(np.ascontiguousarray(np.stack(values, axis=1)), dtype=kind)

    for name, field in (SEGMENT | {"tension": "tension"}).items():
        setattr(t, name, columns([s[field] for s, _ in cases], wp.float64))
    t.constant = columns([g["constant_friction"] for _, g in cases], wp.float64)
    t.previous_slip = columns([g["previous_slip"].astype(np.int32) for _, g in cases], wp.int32)
    ratios = [f"{side}_{kind}" for side in ("input", "output") for kind in ("ratio", "inverse")]
    for name in (*ratios, "dynamic_ratio", "flow"):
        setattr(t, name, wp.zeros((n, count), dtype=wp.float64))
    for name in ("alone", "prefix"):
        setattr(t, name, wp.zeros((n + 1, count), dtype=wp.float64))
    for name in ("breakpoint", "bend", "jump"):
        setattr(t, name, wp.zeros((2 * n, count), dtype=wp.float64))
    t.slip = wp.zeros((n, count), dtype=wp.int32)
    t.first_segment = t.first_guide = wp.zeros(1, dtype=wp.int32)
    t.guides = wp.array([n], dtype=wp.int32)
    t.kind = wp.array([ELASTIC if given else WOUND], dtype=wp.int32)
    given_ratios = [
        columns([g[field] for _, g in cases], wp.float64)
        for field in ("dynamic_ratio", "static_ratio")
    ]
    return t, given_ratios


@pytest.mark.parametrize("given", [False, True], ids=["length", "tension"])
@pytest.mark.parametrize("n", GUIDES)
def test_tensions_and_flows_are_those_of_the_plugin(n, given):
    rng = np.random.default_rng(n)
    cases = [tendon(n, given, rng) for _ in range(CASES)]
    if not given:
        cases += [wound_over_touching_guides(n, rng) for _ in range(CASES)]
    check(cases, given)


def test_a_slack_tendon_is_drawn_tight_over_many_guides_as_with_the_plugin():
    rng = np.random.default_rng(0)
    check([drawn_tight_at_its_output(200, rng) for _ in range(CASES)], False)


def check(cases, given):
    """All are solved, and as the plugin does it."""
    t, ratios = on_device(cases, given)
    solved = wp.zeros((1, len(cases)), dtype=wp.bool)
    wp.launch(solve_all, dim=solved.shape, inputs=[t, *ratios, solved])
    assert all(solve_flow(s, g, False, given) for s, g in cases)
    assert solved.numpy().all()
    tension, flow = t.tension.numpy().T, t.flow.numpy().T
    for k, (segments, guides) in enumerate(cases):
        np.testing.assert_allclose(tension[k], segments["tension"], rtol=1e-9, atol=1e-14)
        np.testing.assert_allclose(flow[k], guides["flow"], rtol=1e-7, atol=1e-14)


@pytest.mark.parametrize("stored", [0.0, -0.01])
def test_a_tendon_wound_up_altogether_has_no_solution(stored):
    segments, guides = tendon(5, False, np.random.default_rng(0))
    segments["stored"] = stored
    t, ratios = on_device([(segments, guides)], False)
    solved = wp.zeros((1, 1), dtype=wp.bool)
    wp.launch(solve_all, dim=(1, 1), inputs=[t, *ratios, solved])
    assert not solved.numpy().any()
    assert np.isinf(t.tension.numpy()).all()
    assert not t.flow.numpy().any()
