"""Parameters as keyword arguments: each is shown, and a wrong one comes with the nearest."""

import dataclasses
import inspect
from fractions import Fraction

import numpy as np
import pytest

import tendon_mj
from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.plugin import GAINS, OptionalGains
from tendon_mj.plugin.force_servo_plugin.state import Gains
from tendon_mj.sheath import LAW, Law, OptionalParameters
from tests.attach.test_friction import finger
from tests.refusals import refusing

TAKERS = [(tendon_mj.add_friction, LAW), (tendon_mj.add_servo, GAINS)]


@pytest.mark.parametrize(("function", "known"), TAKERS)
def test_the_signature_has_every_parameter_with_its_default(function, known):
    shown = inspect.signature(function).parameters
    assert "parameters" not in shown
    assert not any(p.kind == p.VAR_KEYWORD for p in shown.values())
    for name, parameter in known.items():
        assert shown[name].kind == inspect.Parameter.KEYWORD_ONLY
        assert (shown[name].default is inspect.Parameter.empty) == (
            parameter.required and name != "axial_stiffness"
        )


def test_an_unknown_parameter_comes_with_the_nearest():
    spec = finger()
    with refusing(UnknownNameError, "'backlsh'; did you mean 'backlash'"):
        tendon_mj.add_friction(spec, "flexor", friction=0.1, backlsh=1e-3)
    assert not spec.plugins


def test_a_parameter_without_a_value_is_refused_where_it_has_to_have_one():
    with refusing(ValueError, "creep = None"):
        tendon_mj.add_friction(finger(), "flexor", friction=0.1, creep=None)
    tendon_mj.add_friction(finger(), "flexor", friction=0.1, static_friction=None)


@pytest.mark.parametrize(
    ("typed", "dataclass", "explicit"),
    [
        (OptionalParameters, Law, {"friction", "axial_stiffness", "pretension"}),
        (OptionalGains, Gains, {"tension_gain", "velocity_gain"}),
    ],
)
def test_a_type_checker_knows_every_parameter(typed, dataclass, explicit):
    names = {field.name for field in dataclasses.fields(dataclass)}
    assert set(typed.__annotations__) | explicit == names
    assert not set(typed.__annotations__) & explicit


def with_servo(spec, value):
    tendon_mj.add_friction(spec, "flexor", friction=0.1, reel_joint="mcp", reel_radius=0.01)
    tendon_mj.add_servo(spec, "flexor", tension_gain=value, velocity_gain=1.0)


SETTERS = {
    "friction": lambda spec, value: tendon_mj.add_friction(spec, "flexor", friction=value),
    "reel_radius": lambda spec, value: tendon_mj.add_friction(
        spec, "flexor", friction=0.1, reel_joint="mcp", reel_radius=value
    ),
    "tension_gain": with_servo,
}


NOT_NUMBERS = [True, np.True_, "0.15", np.str_("0.15"), [0.1], np.array([0.1, 0.2]), 10**400]


@pytest.mark.parametrize("name", SETTERS)
@pytest.mark.parametrize("value", NOT_NUMBERS)
def test_what_is_not_a_number_is_refused_by_one_rule(name, value):
    with refusing(InvalidValueError, name, repr(value)):
        SETTERS[name](finger(), value)


@pytest.mark.parametrize("name", SETTERS)
@pytest.mark.parametrize("value", [1, np.float32(0.5), np.int64(1), np.array(0.5), Fraction(1, 2)])
def test_what_is_a_number_is_taken_whatever_its_type(name, value):
    spec = finger()
    SETTERS[name](spec, value)
    written = [plugin.config[name] for plugin in spec.plugins if name in plugin.config]
    assert [float(text) for text in written] == [float(value)]
