"""The friction law as a value, and the law of a segment: inverses, derivatives, work and energy."""

import math
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from tendon_mj.errors import InvalidValueError, TendonError
from tendon_mj.sheath import LAW as PARAMETERS
from tendon_mj.sheath import Law, check_range, convected, friction_work, held, strain_at
from tendon_mj.sheath.records import new_segments
from tendon_mj.sheath.segment_law import tension_of
from tendon_mj.sheath.tension_with_drag import tension_at
from tests.refusals import refusing

LAW = Law(axial_stiffness=20e3, friction=0.15)


@pytest.mark.parametrize("name", list(PARAMETERS))
@pytest.mark.parametrize("value", [-1.0, math.nan, math.inf, -math.inf])
def test_a_value_out_of_range_is_named_with_its_range_and_unit(name, value):
    if PARAMETERS[name].range.admits(value):
        assert math.isinf(PARAMETERS[name].range.low)
        return
    with refusing(InvalidValueError, f"{name} = {value:g} [", "finite"):
        replace(LAW, **{name: value})


@pytest.mark.parametrize(
    ("name", "value", "sizes"),
    [
        ("extra_bend", -1e31, r"-1e\+30 to 1e\+30"),
        ("friction", 1e31, r"0 to 1e\+30"),
        ("axial_stiffness", 1e-31, r"1e-30 to 1e\+30"),
    ],
)
def test_a_size_that_nothing_can_be_computed_with_is_refused_with_the_range(name, value, sizes):
    with pytest.raises(InvalidValueError, match=f"^{name} = .* {sizes}$"):
        replace(LAW, **{name: value})


def test_only_the_stiffness_may_not_be_zero():
    zero = dict.fromkeys(PARAMETERS, 0.0)
    Law(**zero | {"axial_stiffness": 1.0})
    with refusing(InvalidValueError, "axial_stiffness = 0 [N]", "> 0"):
        Law(**zero)


def test_friction_at_rest_is_not_below_friction_while_sliding():
    with refusing(InvalidValueError, "static_friction = 0.1", "friction = 0.15"):
        replace(LAW, static_friction=0.1)
    assert replace(LAW, static_friction=0.15).mu_s == LAW.mu_s == 0.15
    assert replace(LAW, static_friction=0.3).mu_s == 0.3


def test_a_place_comes_first_in_the_message():
    with pytest.raises(InvalidValueError, match=r"^finger: friction = -1 "):
        check_range("friction", -1.0, "finger")


def test_a_law_does_not_change():
    with pytest.raises(FrozenInstanceError):
        LAW.friction = 0.2


def test_every_refusal_is_a_value_error_of_this_package():
    assert issubclass(InvalidValueError, TendonError)
    assert issubclass(InvalidValueError, ValueError)


def test_friction_by_direction_is_positive_either_way():
    for value in (-1.0, 1.0, 1.5):
        with refusing(InvalidValueError, f"direction_asymmetry = {value:g} [-]", "> -1", "< 1"):
            replace(LAW, direction_asymmetry=value)
    replace(LAW, direction_asymmetry=-0.99)


@pytest.mark.parametrize(
    ("effect", "scale"), [("stribeck_friction", "stribeck_velocity"), ("creep", "creep_time")]
)
def test_an_effect_needs_its_scale(effect, scale):
    with refusing(InvalidValueError, f"{effect} = 0.1", f"{scale} > 0 ["):
        replace(LAW, **{effect: 0.1})
    replace(LAW, **{effect: 0.1, scale: 0.01})
    replace(LAW, **{scale: 0.01})


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
