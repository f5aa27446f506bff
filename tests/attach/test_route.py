"""A sheath laid out as points: exact in length and in bend for any number of guides."""

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as some

from tendon_mj import add_sites, add_tendon, arc_points, bent_points
from tendon_mj.errors import InvalidValueError, UnknownNameError
from tests.refusals import refusing

vectors = some.tuples(*[some.floats(-1.0, 1.0)] * 3)


def turns(points):
    legs = np.diff(points, axis=0)
    legs /= np.linalg.norm(legs, axis=1)[:, None]
    crossed = np.linalg.norm(np.cross(legs[:-1], legs[1:]), axis=1)
    return np.arctan2(crossed, np.sum(legs[:-1] * legs[1:], axis=1))


@settings(max_examples=200, derandomize=True)
@given(some.floats(1e-3, 10.0), some.floats(-6.0, 6.0), some.integers(1, 64), vectors, vectors)
def test_length_bend_plane_and_start_are_exact(length, bend, guides, start, normal):
    normal = np.add(normal, (0.0, 0.0, 3.0))
    bend = np.clip(bend, -3.0 * guides, 3.0 * guides)  # a guide cannot turn by more than π
    points = arc_points(length, bend, guides, start, (1.0, 0.2, 0.1), normal)
    legs = np.diff(points, axis=0)
    sizes = np.linalg.norm(legs, axis=1)
    assert points.shape == (guides + 2, 3)
    np.testing.assert_array_equal(points[0], start)
    assert sizes.sum() == pytest.approx(length, rel=1e-12)
    np.testing.assert_allclose(sizes[[0, -1]], length / guides / 2, rtol=1e-9)
    np.testing.assert_allclose(sizes[1:-1], length / guides, rtol=1e-9)
    np.testing.assert_allclose(turns(points), abs(bend) / guides, rtol=0, atol=1e-8)
    assert np.abs(legs @ normal).max() <= 1e-12 * length * np.linalg.norm(normal)


def test_it_leaves_in_its_direction_and_turns_to_the_left():
    points = arc_points(1.0, np.pi / 2, 8, direction=(1, 0, 0), normal=(0, 0, 1))
    first, last = np.diff(points, axis=0)[[0, -1]]
    np.testing.assert_allclose(first / np.linalg.norm(first), [1, 0, 0], atol=1e-15)
    np.testing.assert_allclose(last / np.linalg.norm(last), [0, 1, 0], atol=1e-12)
    right = arc_points(1.0, -np.pi / 2, 8)
    np.testing.assert_allclose(right * [1, -1, 1], points, atol=1e-15)


def hand():
    spec = mujoco.MjSpec()
    spec.worldbody.add_body(name="palm", pos=[1, 2, 3]).add_geom(size=[0.1, 0, 0])
    return spec


def test_sites_lie_on_their_body_and_the_tendon_runs_through_them_in_order():
    spec = hand()
    points = arc_points(0.3, 2.0, 5)
    sites = add_sites(spec, "guide", points, "palm")
    assert sites == [f"guide_{k}" for k in range(7)]
    add_tendon(spec, "flexor", sites)
    model = spec.compile()
    np.testing.assert_array_equal(model.site_pos, points)
    assert set(model.site_bodyid) == {model.body("palm").id}
    assert [model.site(i).name for i in model.wrap_objid] == sites
    assert model.tendon_length0[0] == pytest.approx(0.3, rel=1e-12)


@pytest.mark.parametrize(
    ("call", "fact"),
    [
        (lambda s: arc_points(0.0, 1.0, 4), "length = 0.0 [m]"),
        (lambda s: arc_points(np.nan, 1.0, 4), "length = nan [m]"),
        (lambda s: arc_points(1.0, np.inf, 4), "bend = inf [rad]"),
        (lambda s: arc_points(1.0, 1.0, 0), "guides = 0"),
        (lambda s: arc_points(1.0, 4.0, 1), "guides = 1"),
        (lambda s: arc_points(1.0, 1.0, 4, direction=(0, 0, 2)), "direction"),
        (lambda s: bent_points(0.8, [(0.0, 0.8, 4.0)], guides=1), "guides = 1"),
        (lambda s: add_sites(s, "g", [[0, 0, 0]], "plam"), "did you mean 'palm'"),
        (lambda s: add_sites(s, "g", [0, 0, 0]), "(3,)"),
        (lambda s: add_sites(s, "g", [[0, 0, np.inf]]), "finite"),
        (lambda s: add_tendon(s, "t", [*add_sites(s, "g", np.eye(3)), "g_9"]), "g_9"),
        (lambda s: add_tendon(s, "t", ["g"]), "'t'"),
    ],
)
def test_a_route_that_cannot_be_is_refused_by_name(call, fact):
    spec = hand()
    with refusing((UnknownNameError, InvalidValueError), fact):
        call(spec)
    assert not spec.tendons


BENDS = [(0.10, 0.28, np.pi / 2), (0.42, 0.52, -0.7), (0.65, 0.72, 0.35)]


def test_a_sheath_bent_in_places_has_its_length_its_bends_and_its_straight_stretches():
    points = bent_points(0.8, BENDS, guides=18)
    legs = np.diff(points, axis=0)
    lengths = np.linalg.norm(legs, axis=1)
    assert lengths.sum() == pytest.approx(0.8, rel=1e-12)
    headings = np.unwrap(np.arctan2(legs[:, 1], legs[:, 0]))
    along = np.cumsum(lengths)[:-1]  # where each guide lies
    for begin, end, angle in BENDS:
        inside = (along > begin) & (along < end)
        assert np.diff(headings)[inside].sum() == pytest.approx(angle, abs=1e-12)
    assert all(any(begin < at < end for begin, end, _ in BENDS) for at in along)


def test_one_bend_all_along_is_an_arc():
    one = bent_points(0.6, [(0.0, 0.6, 2.0)], guides=7, start=(1, 2, 3), direction=(0, 1, 1))
    arc = arc_points(0.6, 2.0, 7, start=(1, 2, 3), direction=(0, 1, 1))
    np.testing.assert_allclose(one, arc, atol=1e-15)


@pytest.mark.parametrize(
    "bends",
    [[(0.1, 0.3, 0.0)], [(0.3, 0.1, 1.0)], [(0.1, 0.9, 1.0)], [*BENDS, (0.7, 0.75, 1.0)]],
    ids=["turns by nothing", "ends before it begins", "beyond the end", "overlaps"],
)
def test_a_bend_that_cannot_be_is_refused(bends):
    with refusing(InvalidValueError, f"{bends[-1][0]:g} m"):
        bent_points(0.8, bends, guides=18)
