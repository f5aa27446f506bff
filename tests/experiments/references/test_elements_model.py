"""The chain as a value: the arguments it accepts, the quantities it derives."""

import numpy as np
import pytest

from experiments.references import ElementChain, uniform_chain

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
