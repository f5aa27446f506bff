"""The chain as a value: the arguments it accepts, the quantities it derives."""

import numpy as np
import pytest

from experiments.references import ElementChain, quasi_static, simulate_chain, uniform_chain
from tendon_mj.errors import InvalidValueError, UnknownNameError
from tests.refusals import refusing

GOOD = {
    "bend_angle": [0.1, 0.2],
    "mass": 0.1,
    "damping": 0.0,
    "stiffness": 1e4,
    "static_friction": 0.3,
    "dynamic_friction": 0.1,
    "pretension": 20.0,
}
SHEATH = {"length": 0.5, "bend_angle": np.pi, "axial_stiffness": 2e4, "pretension": 20.0}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"bend_angle": [0.1, -0.2]}, "bend_angle[1] is -0.2; | >= 0"),
        ({"bend_angle": []}, "at least one element"),
        ({"mass": 0.0}, "mass[0] is 0; | > 0"),
        ({"mass": [1.0, 2.0, 3.0]}, "mass has shape (3,); | (2,)"),
        ({"damping": -1.0}, "damping[0] is -1"),
        ({"stiffness": np.inf}, "stiffness[0] is inf"),
        ({"dynamic_friction": [0.1, 0.4]}, "static_friction[1] is 0.3; | >= | 0.4"),
        ({"friction_force": np.nan}, "friction_force[0] is nan"),
        ({"pretension": 0.0}, "pretension is 0; | > 0"),
        ({"sensor_stiffness": -1.0}, "sensor_stiffness is -1; | inf allowed"),
        ({"bend_angle": [1.0, 4.0], "law": "linear"}, "linear law needs < 1"),
        ({"law": "liner"}, "did you mean 'linear' | 'exponential'"),
    ],
)
def test_a_value_out_of_range_is_named(change, message):
    with refusing((InvalidValueError, UnknownNameError), message):
        ElementChain(**{**GOOD, **change})


NUMBERS = ("mass", "damping", "static_friction", "friction_force", "length")


@pytest.mark.parametrize(
    ("change", "facts"),
    [
        ({"ends": "quarter"}, "'half', 'paper'"),
        ({"static_friction": 300.0}, "700"),
        *(({"elements": n}, "n is") for n in (np.nan, np.inf, 2.5, 0, [4])),
        *(({name: [1.0, 2.0]}, f"{name} is | one number") for name in NUMBERS),
    ],
    ids=str,
)
def test_a_uniform_chain_that_cannot_be_is_named(change, facts):
    given = {"elements": 4, "static_friction": 0.1, **SHEATH, **change}
    with refusing((InvalidValueError, UnknownNameError), facts):
        uniform_chain(given.pop("elements"), **given)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"time": [0.0, 1.0]}, "neither given"),
        ({"time": [0.0, 1.0], "input_tension": 1.0, "input_displacement": 0.0}, "both given"),
        ({"time": [0.0], "input_tension": 20.0}, "time has 1 instants"),
        ({"time": [0.0, 1.0, 1.0], "input_tension": 20.0}, "smallest interval of 0 s"),
        ({"time": [0.0, 1.0], "input_tension": [20.0, -1.0]}, "input_tension[1] is -1"),
        ({"time": [0.0, 1.0], "input_tension": [20.0]}, "input_tension has shape (1,)"),
        ({"time": [0.0, 1.0], "input_displacement": 0.0}, "input_stiffness is inf"),
        ({"time": [0.0, 1.0], "input_tension": 20.0, "time_step": 0.0}, "time_step is 0"),
        ({"time": [0.0, 1.0], "input_tension": 20.0, "time_step": 1e-300}, "time_step"),
    ],
)
def test_a_history_that_does_not_fit_is_named(settings, message):
    with refusing(InvalidValueError, message):
        simulate_chain(ElementChain(**GOOD), **settings)


def test_half_ends_and_paper_ends_have_the_stiffness_of_the_tendon_where_it_counts():
    half = uniform_chain(5, static_friction=0.1, **SHEATH)
    paper = uniform_chain(5, static_friction=0.1, ends="paper", **SHEATH)
    assert 1.0 / (1.0 / half.spring_stiffness).sum() == pytest.approx(2e4 / 0.5)
    assert 1.0 / (1.0 / paper.spring_stiffness).sum() == pytest.approx(2e4 / 0.5)
    assert half.exponent == pytest.approx(0.1 * np.pi)


def test_last_spring_is_in_series_with_environment_and_sensor():
    chain = ElementChain(**GOOD, environment_stiffness=1e4, sensor_stiffness=4e4)
    assert chain.spring_stiffness[-1] == pytest.approx(1.0 / (1e-4 + 1e-4 + 0.25e-4))
    assert chain.output_stiffness == pytest.approx(8e3)


def test_weights_of_both_laws_agree_for_a_small_bend():
    thin = {**GOOD, "bend_angle": [1e-6]}
    exponential = ElementChain(**thin).friction_weights(0.3)
    linear = ElementChain(**thin, law="linear").friction_weights(0.3)
    assert exponential == pytest.approx(linear, rel=1e-6)


def test_values_are_out_of_reach():
    chain = quasi_static(ElementChain(**GOOD), 1.0)
    with refusing(ValueError, "read-only"):
        chain.mass[0] = 1.0
    with pytest.raises(AttributeError):
        chain.pretension = 1.0
