"""Slow motion of the elements: Hooke without friction, the capstan ratio with it."""

import numpy as np
import pytest

from experiments.references import quasi_static, simulate_chain, uniform_chain

SHEATH = {"length": 0.5, "bend_angle": np.pi, "axial_stiffness": 2e4, "pretension": 20.0}


@pytest.mark.parametrize("ends", ["half", "paper"])
def test_chain_without_friction_is_springs_in_series(ends):
    chain = uniform_chain(
        32,
        static_friction=0.0,
        ends=ends,
        environment_stiffness=1e4,
        sensor_stiffness=4e4,
        mass=1e-6,
        damping=2e-3,
        **SHEATH,
    )
    time = np.linspace(0.0, 25.0, 501)  # 0.04 Hz, Fig. 4 (a)
    swing = 15.0 * np.sin(2.0 * np.pi * 0.04 * time)
    run = simulate_chain(chain, time, input_tension=20.0 + swing, time_step=1e-3)
    stiffness = 1.0 / (0.5 / 2e4 + 1.0 / 1e4 + 1.0 / 4e4)
    line = 20.0 + stiffness * run.input_displacement
    assert np.abs(run.output_tension - line).max() < 1e-6 * 30.0
    settled = time > 5.0  # the sine begins with a kink, which rings for a while
    assert np.abs(run.output_tension - run.input_tension)[settled].max() < 1e-6 * 30.0


@pytest.mark.parametrize("ends", ["half", "paper"])
@pytest.mark.parametrize("n", [1, 7])
def test_ratio_is_exact_while_all_elements_slide_slowly(n, ends):
    mu = 0.2
    chain = uniform_chain(n, static_friction=mu, ends=ends, **SHEATH)
    chain = quasi_static(chain, 1.0, slowness=2000.0)
    time = np.linspace(0.0, 2.0, 201)
    load = np.interp(time, [0.0, 1.0, 2.0], [20.0, 80.0, 8.0])
    run = simulate_chain(chain, time, input_tension=load, time_step=5.0 * chain.time_step)
    ratio = run.output_tension / load
    assert ratio[(time > 0.8) & (time <= 1.0)] == pytest.approx(np.exp(-mu * np.pi), rel=2e-3)
    assert ratio[time > 1.95] == pytest.approx(np.exp(mu * np.pi), rel=2e-3)


@pytest.mark.parametrize("n", [4, 16])
def test_linear_law_has_the_ratio_of_equation_22(n):
    mu = 0.2
    chain = uniform_chain(n, static_friction=mu, law="linear", ends="paper", **SHEATH)
    chain = quasi_static(chain, 1.0, slowness=2000.0)
    time = np.linspace(0.0, 1.0, 101)
    load = np.interp(time, [0.0, 1.0], [20.0, 80.0])
    run = simulate_chain(chain, time, input_tension=load, time_step=5.0 * chain.time_step)
    expected = (1.0 - mu * np.pi / n) ** n
    assert run.output_tension[-1] / load[-1] == pytest.approx(expected, rel=2e-3)


def test_output_holds_still_in_the_backlash():
    chain = quasi_static(uniform_chain(32, static_friction=0.3, **SHEATH), 1.0, slowness=100.0)
    time = np.linspace(0.0, 1.0, 101)
    load = np.interp(time, [0.0, 1.0], [20.0, 20.0 * np.exp(0.25 * np.pi)])
    run = simulate_chain(chain, time, input_tension=load)
    assert np.all(run.output_tension == 20.0)
    assert run.input_displacement[-1] > 0.0


def test_lowest_frequency_is_as_asked():
    chain = quasi_static(uniform_chain(8, static_friction=0.0, **SHEATH), 2.0, slowness=50.0)
    springs = chain.spring_stiffness[1:]
    matrix = np.diag(springs + np.append(0.0, springs[:-1]))
    matrix -= np.diag(springs[:-1], 1) + np.diag(springs[:-1], -1)
    omega = np.sqrt(np.linalg.eigvalsh(matrix / chain.mass[0])[0])
    assert omega == pytest.approx(2.0 * np.pi * 50.0 / 2.0)
    assert chain.damping[0] == pytest.approx(2.0 * 0.1 * chain.mass[0] * omega)
