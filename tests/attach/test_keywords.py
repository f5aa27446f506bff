"""Parameters as keyword arguments: each is shown, and a wrong one comes with the nearest."""

import dataclasses
import inspect

import pytest

import tendon_mj
from tendon_mj.engine import GAINS, OptionalGains
from tendon_mj.engine.servo_plugin.gains import Gains
from tendon_mj.errors import UnknownNameError
from tendon_mj.sheath.law import LAW, Law, OptionalParameters
from tests.attach.test_friction import finger

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


@pytest.mark.parametrize(("function", "known"), TAKERS)
def test_the_help_says_what_every_parameter_is_and_its_unit(function, known):
    for name, parameter in known.items():
        assert f"        {name}: {parameter.line()}\n" in function.__doc__
    assert "<parameters>" not in function.__doc__


def test_an_unknown_parameter_comes_with_the_nearest():
    spec = finger()
    with pytest.raises(UnknownNameError, match="'backlsh'; did you mean 'backlash'"):
        tendon_mj.add_friction(spec, "flexor", friction=0.1, backlsh=1e-3)
    assert not spec.plugins


def test_a_parameter_without_a_value_is_refused_where_it_has_to_have_one():
    with pytest.raises(ValueError, match="creep = None is not a number"):
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
