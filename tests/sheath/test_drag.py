"""The flow problem where sliding itself takes tension."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as some

from tendon_mj.sheath import tables as t
from tendon_mj.sheath.drag import _relax
from tendon_mj.sheath.flow import settle
from tests.sheath.tendons import random_tendons, tendon

EVERY = settings(max_examples=400, deadline=None, derandomize=True)
# D ℓ: from hardly felt to a wave that crosses a segment in many steps
drags = some.sampled_from([1e-6, 1e-3, 1.0, 1e3])


def dragged(tables, drag, momentum, seed=0):
    segments, guides = tables
    rng = np.random.default_rng(seed)
    guides[t.DRAG] = drag / segments[t.LENGTH].mean()
    scale = np.abs(segments[t.TENSION]).max()
    guides[t.PUSH] = momentum * scale * rng.normal(size=guides.shape[1])
    return segments, guides


def kept(segments, guides):
    return segments[t.STORED] + np.diff(np.concatenate([[0.0], guides[t.FLOW], [0.0]]))


def check(segments, guides):
    """The law at every guide, Hooke's in every segment."""
    stored = kept(segments, guides)
    assert stored.min() > 0.0
    strain = np.maximum(segments[t.LENGTH] / stored - 1.0, 0.0)
    scale = max(strain.max(), np.abs(guides[t.PUSH]).max(), 1e-6)
    np.testing.assert_allclose(segments[t.TENSION], strain, rtol=0, atol=1e-9 * scale)
    left, right = segments[t.TENSION, :-1], segments[t.TENSION, 1:]
    flow, takes = guides[t.FLOW], guides[t.DRAG] * guides[t.FLOW] + guides[t.PUSH]
    up = left - guides[t.UP] * right - guides[t.CONSTANT] - takes
    down = right - guides[t.DOWN] * left - guides[t.CONSTANT] + takes
    room = 1e-8 * scale
    np.testing.assert_allclose(up[flow > 0.0], 0.0, atol=room)
    np.testing.assert_allclose(down[flow < 0.0], 0.0, atol=room)
    assert np.all(up[flow == 0.0] <= room)
    assert np.all(down[flow == 0.0] <= room)


@EVERY
@given(random_tendons(), drags, some.sampled_from([0.0, 0.1, 1.0]), some.integers(0, 99))
def test_every_tendon_has_a_solution_that_obeys_the_law(tables, drag, momentum, seed):
    segments, guides = dragged(tables, drag, momentum, seed)
    assert settle(segments, guides, True)
    check(segments, guides)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(random_tendons(most=5), some.sampled_from([1.0, 1e3]), some.integers(0, 99))
def test_guide_after_guide_comes_to_the_same(tables, drag, seed):
    segments, guides = dragged(tables, drag, 0.3, seed)
    assert settle(segments, guides, True)
    other, held = segments.copy(), guides.copy()
    held[t.SLIP] = 0.0
    assert _relax(other, held)
    scale = max(segments[t.TENSION].max(), 1e-6)
    np.testing.assert_allclose(other[t.TENSION], segments[t.TENSION], rtol=0, atol=1e-9 * scale)


@EVERY
@given(random_tendons(slack=False))
def test_less_and_less_drag_is_none(tables):
    segments, guides = tables
    other, held = dragged((segments.copy(), guides.copy()), 1e-12, 0.0)
    assert settle(segments, guides)
    assert settle(other, held, True)
    scale = segments[t.TENSION].max()
    np.testing.assert_allclose(other[t.TENSION], segments[t.TENSION], rtol=0, atol=1e-7 * scale)


def test_more_drag_lets_less_pass():
    passed = []
    for drag in (1e-3, 1.0, 10.0, 1e3):
        strains = [2e-3, 1e-3, 1e-3]
        tables = tendon([0.1, 0.1, 0.1], strains, [0.2, 0.2], 0.3, 0.3)
        segments, guides = dragged(tables, drag, 0.0)
        assert settle(segments, guides, True)
        passed.append(guides[t.FLOW, 0])
    assert np.all(np.diff(passed) < 0.0)
    assert passed[-1] > 0.0


def test_a_tendon_that_is_all_wound_up_has_no_solution():
    segments, guides = dragged(tendon([0.1, 0.1], [1e-3, 1e-3], [0.2], 0.3, 0.3), 1.0, 0.0)
    segments[t.STORED] = -0.1, 0.05
    assert not settle(segments, guides, True)
    assert not guides[t.FLOW].any()
