"""The chain as a value: the arguments it accepts, the quantities it derives."""

import ast
from pathlib import Path

import numpy as np
import pytest

import experiments.references
from experiments import references
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
    ],
)
def test_a_value_out_of_range_is_named(change, message):
    with refusing(InvalidValueError, message):
        ElementChain(**{**GOOD, **change})


def test_an_unknown_name_lists_the_valid_ones():
    with refusing(UnknownNameError, "did you mean 'linear' | 'exponential'"):
        ElementChain(**{**GOOD, "law": "liner"})
    with refusing(UnknownNameError, "'half', 'paper'"):
        uniform_chain(4, static_friction=0.1, ends="quarter", **SHEATH)


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


def test_the_reference_shares_no_code_with_the_packages_it_checks():
    allowed = {"tendon_mj.errors", "tendon_mj.typing"}
    for path in Path(experiments.references.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            for name in names:
                assert not name.startswith("tendon_mj") or name in allowed, (path, name)


BARE_SHEATH = {"length": 0.5, "axial_stiffness": 20e3, "pretension": 20.0}


def chain(n=4, **changes):
    given = {"bend_angle": np.pi, "static_friction": 0.1, **BARE_SHEATH, **changes}
    return references.uniform_chain(n, **given)


def test_an_exponent_beyond_every_number_is_refused():
    with refusing(InvalidValueError, "700"):
        chain(static_friction=300.0)


@pytest.mark.parametrize("n", [np.nan, np.inf, 2.5, 0, [4]])
def test_a_number_of_elements_is_whole(n):
    with refusing(InvalidValueError, "n is"):
        chain(n)


@pytest.mark.parametrize("name", ["mass", "damping", "static_friction", "friction_force", "length"])
def test_one_number_is_not_a_list(name):
    with pytest.raises(InvalidValueError, match=f"{name} is .* one number"):
        chain(**{name: [1.0, 2.0]})


def test_a_step_that_would_never_end_is_refused():
    with refusing(InvalidValueError, "time_step"):
        references.simulate_chain(chain(), [0.0, 1.0], input_tension=[20.0, 21.0], time_step=1e-300)


def test_a_list_serves_as_a_history():
    run = references.simulate_chain(chain(), [0.0, 0.1], input_tension=[20.0, 20.0])
    assert run.output_tension == pytest.approx(20.0)


def test_a_bend_that_does_not_start_at_zero_is_refused():
    with refusing(InvalidValueError, "start at 0"):
        references.continuum(lambda x: 2.0, friction=0.1, **BARE_SHEATH)


def test_a_straight_sheath_may_be_a_constant_function():
    straight = references.continuum(lambda x: 0.0, friction=0.1, **BARE_SHEATH)
    run = references.simulate_continuum(straight, input_tension=[20.0, 30.0])
    assert run.output_tension[-1] == pytest.approx(30.0)
