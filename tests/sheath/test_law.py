"""The friction law as a value: its parameters, the values it refuses, and its messages."""

import math
from dataclasses import FrozenInstanceError, replace

import pytest

from tendon_mj.errors import InvalidValueError, TendonError
from tendon_mj.sheath import LAW as PARAMETERS
from tendon_mj.sheath import Law, check_range
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
