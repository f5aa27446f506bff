"""Stiction: an element at rest is at rest."""

import numpy as np
import pytest

from experiments.references import simulate_chain, uniform_chain

SHEATH = {
    "length": 0.5,
    "bend_angle": np.pi,
    "axial_stiffness": 2e4,
    "pretension": 20.0,
    "mass": 0.05,
    "damping": 2.0,
}


@pytest.mark.parametrize("law", ["exponential", "linear"])
@pytest.mark.parametrize("share", [0.999, -0.999])
def test_resting_element_does_not_creep_in_100_s(law, share):
    chain = uniform_chain(8, static_friction=0.3, dynamic_friction=0.1, law=law, **SHEATH)
    pull, loosen = chain.friction_weights(0.3)[:, 0]
    # element 1 is at its limit when T_in (1 − pull) = T_0 or T_in (1 + loosen) = T_0
    limit = 20.0 / (1.0 - pull) - 20.0 if share > 0 else 20.0 - 20.0 / (1.0 + loosen)
    time = np.linspace(0.0, 100.0, 1001)
    run = simulate_chain(
        chain, time, input_tension=20.0 + share * limit, time_step=1e-3, record_elements=True
    )
    assert run.steps >= 100_000
    assert np.all(run.element_displacement == 0.0)
    assert np.all(run.state.velocity == 0.0)
    assert run.energy.friction_work[-1] == 0.0


@pytest.mark.parametrize("share", [1.001, -1.001])
def test_beyond_the_static_limit_it_breaks_away_in_the_direction_of_the_force(share):
    chain = uniform_chain(8, static_friction=0.3, dynamic_friction=0.1, **SHEATH)
    load = 20.0 * np.exp(share * 0.3 * np.pi / 8)
    run = simulate_chain(chain, [0.0, 1.0], input_tension=load, record_elements=True)
    assert run.element_displacement[-1, 0] * share > 0.0


def test_element_pulled_and_let_go_stays_where_friction_holds_it():
    chain = uniform_chain(1, static_friction=0.3, ends="paper", **SHEATH)
    time = np.linspace(0.0, 102.0, 1021)
    load = np.interp(time, [0.0, 1.0, 2.0], [20.0, 80.0, 60.0])
    run = simulate_chain(chain, time, input_tension=load, time_step=1e-3, record_elements=True)
    held = run.element_displacement[time > 2.0, 0]
    assert held[0] > 0.0
    assert np.all(held == held[0])  # bit for bit, under 60 N against 31 N


def test_tension_independent_friction_holds_a_straight_tendon():
    settings = {**SHEATH, "bend_angle": 0.0}
    chain = uniform_chain(4, static_friction=0.0, friction_force=2.0, **settings)
    still = simulate_chain(chain, [0.0, 10.0], input_tension=20.499, time_step=1e-3)
    assert np.all(still.state.displacement == 0.0)
    moved = simulate_chain(chain, [0.0, 10.0], input_tension=20.501, time_step=1e-3)
    assert moved.state.displacement[0] > 0.0
    assert np.all(moved.state.displacement[1:] == 0.0)


def test_dynamic_friction_rules_in_motion():
    # overdamped, so that it does not snap past the balance of sliding
    settings = {**SHEATH, "damping": 200.0}
    chain = uniform_chain(1, static_friction=0.3, dynamic_friction=0.1, ends="paper", **settings)
    time = np.linspace(0.0, 5.0, 501)
    load = np.interp(time, [0.0, 5.0], [20.0, 120.0])
    run = simulate_chain(chain, time, input_tension=load)
    stuck = load * np.exp(-0.3 * np.pi) < 20.0
    assert np.all(run.output_tension[stuck] == 20.0)
    sliding = time > 2.5
    lag = 200.0 * 20.0 / 4e4  # damping of a steady motion, as tension
    expected = load[sliding] * np.exp(-0.1 * np.pi)
    assert run.output_tension[sliding] == pytest.approx(expected, abs=lag)


def test_state_continues_a_run_bit_for_bit():
    chain = uniform_chain(8, static_friction=0.2, **SHEATH)
    time = np.linspace(0.0, 1.0, 65)
    load = 20.0 + 15.0 * np.sin(2.0 * np.pi * time)
    whole = simulate_chain(chain, time, input_tension=load)
    first = simulate_chain(chain, time[:33], input_tension=load[:33])
    second = simulate_chain(chain, time[32:], input_tension=load[32:], state=first.state)
    assert np.array_equal(whole.state.displacement, second.state.displacement)
    assert np.array_equal(whole.output_tension[32:], second.output_tension)
