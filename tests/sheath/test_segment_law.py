"""A segment's law: tension and length are inverses, slopes are derivatives, work is energy."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from tendon_mj.sheath import convected, friction_work, held, strain_at
from tendon_mj.sheath.records import new_segments
from tendon_mj.sheath.segment_law import tension_of
from tendon_mj.sheath.tension_with_drag import tension_at

tensions = st.floats(1e-6, 0.1)
stiffenings = st.one_of(st.just(0.0), st.floats(0.1, 500.0))


@st.composite
def random_segments(draw):
    """One taut segment, whose support yields and whose strain is damped."""
    segments = new_segments(1)
    segments["length"] = draw(st.floats(0.01, 1.0))
    segments["strain_slope"] = draw(st.floats(0.2, 1.0))
    segments["strain_offset"] = draw(st.floats(-1e-5, 1e-2))
    stretch = 1.0 + segments["strain_offset"] + draw(st.floats(1e-4, 0.1))
    segments["stored"] = segments["length"] / stretch
    segments["support_compliance"] = draw(st.floats(0.0, 1.0))
    return segments


@given(tensions, stiffenings)
def test_the_strain_at_a_tension_causes_that_tension(tau, stiffening):
    strain = strain_at(tau, stiffening)
    assert strain * (1.0 + stiffening * strain) == pytest.approx(tau, rel=1e-12)
    assert strain_at(0.0, stiffening) == 0.0


@given(tensions, stiffenings)
def test_a_leaving_length_convects_its_pull_less_its_elastic_energy(tau, stiffening):
    strain = strain_at(tau, stiffening)
    elastic, _ = quad(lambda e: e * (1.0 + stiffening * e), 0.0, strain, epsabs=0.0, epsrel=1e-12)
    assert convected(tau, stiffening) == pytest.approx(tau * (1.0 + strain) - elastic, rel=1e-10)


@given(tensions, tensions, st.floats(-1e-3, 1e-3))
def test_friction_work_is_the_difference_of_what_is_convected(left, right, flow):
    work = friction_work(left, right, flow)
    expected = flow * (convected(left, 0.0) - convected(right, 0.0))
    assert work == pytest.approx(expected, rel=1e-9, abs=1e-18)
    assert work * flow * (left - right) >= 0.0


@given(random_segments(), tensions)
def test_the_slope_of_newtons_rows_is_that_of_the_length_held(segments, tau):
    length, slope, _ = held(segments, 0, tau)
    again, inverse = tension_at(segments, 0, length, 0.0)
    assert again == pytest.approx(tau, rel=1e-9, abs=1e-12)
    assert inverse == pytest.approx(1.0 / slope, rel=1e-9)


@given(random_segments(), tensions)
def test_slope_and_curvature_are_derivatives_of_the_length_held(segments, tau):
    step = 1e-4 * tau
    before, here, after = (held(segments, 0, tau + k * step) for k in (-1.0, 0.0, 1.0))
    assert here[1] == pytest.approx((after[0] - before[0]) / (2.0 * step), rel=1e-5)
    assert here[2] == pytest.approx((after[1] - before[1]) / (2.0 * step), rel=1e-5)
    assert here[1] < 0.0 < here[2]


@given(random_segments())
def test_at_the_tension_of_a_taut_segment_it_holds_what_it_has_stored(segments):
    tau = tension_of(segments, 0)
    assert tau > 0.0
    assert held(segments, 0, tau)[0] == pytest.approx(segments["stored"][0], rel=1e-12)


@given(random_segments(), st.floats(0.0, 1.0))
def test_a_slack_segment_has_no_tension(segments, more):
    segments["stored"] = segments["length"] * (1.0 + more) / (1.0 + segments["strain_offset"])
    assert tension_of(segments, 0) == pytest.approx(0.0, abs=1e-15)


def test_where_nothing_can_yield_the_tension_has_no_bound():
    segments = new_segments(1)
    segments["length"], segments["strain_slope"] = 0.1, 1.0
    assert math.isinf(tension_of(segments, 0))
    segments["support_compliance"] = 0.5
    assert tension_of(segments, 0) == pytest.approx(0.2)
    segments["stored"] = np.nextafter(0.0, 1.0)
    assert tension_of(segments, 0) == pytest.approx(0.2)
