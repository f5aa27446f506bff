"""Order of the integrator: 2 where nothing stops or starts, against an independent solver."""

import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from experiments.references import ChainState, simulate_chain, uniform_chain

N = 4
SHEATH = {"length": 0.5, "bend_angle": np.pi, "axial_stiffness": 2e3, "pretension": 20.0}


def order(chain, state, duration, load, velocity_bound, *, prescribe="input_tension"):
    """Errors of ξ, ξ̇ at the end for three steps, and the orders between them."""

    def motion(t, y):
        x, v = y[:N], y[N:]
        springs = chain.spring_stiffness
        ahead = np.append(x[1:], 0.0)
        tension = np.empty(N + 1)
        tension[1:] = 20.0 + springs[1:] * (x - ahead)
        tension[0] = (
            load(t) if prescribe == "input_tension" else 20.0 + springs[0] * (load(t) - x[0])
        )
        friction = np.exp(-chain.dynamic_friction * chain.bend_angle)
        force = friction * tension[:-1] - tension[1:] - chain.friction_force
        return np.concatenate((v, (force - chain.damping * v) / chain.mass))

    begin = np.concatenate((state.displacement, state.velocity))
    exact = solve_ivp(motion, (0.0, duration), begin, method="DOP853", rtol=1e-12, atol=1e-14)
    assert exact.y[N:].min() > velocity_bound  # no element stops
    errors = []
    for samples in (201, 401, 801):
        time = np.linspace(0.0, duration, samples)
        run = simulate_chain(
            chain, time, **{prescribe: load(time)}, time_step=duration, state=state
        )
        assert run.steps == samples - 1
        got = np.concatenate((run.state.displacement, run.state.velocity))
        errors.append(np.abs(got - exact.y[:, -1]).max() / np.abs(exact.y[:, -1]).max())
    return np.array(errors), np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


def test_sliding_chain_is_of_order_2():
    chain = uniform_chain(
        N,
        static_friction=0.1,
        friction_force=0.5,
        mass=5.0,
        damping=20.0,
        environment_stiffness=500.0,
        **SHEATH,
    )
    state = ChainState(np.zeros(N), np.full(N, 0.2))
    errors, orders = order(chain, state, 0.04, lambda t: 60.0 + 4000.0 * t, 0.0)
    assert errors[-1] < 1e-4
    assert orders == pytest.approx(2.0, abs=0.05)


@pytest.mark.parametrize("prescribe", ["input_tension", "input_displacement"])
def test_chain_without_friction_is_of_order_2(prescribe):
    chain = uniform_chain(N, static_friction=0.0, mass=5.0, damping=20.0, **SHEATH)
    scale, offset = (15.0, 20.0) if prescribe == "input_tension" else (3e-4, 0.0)
    _errors, orders = order(
        chain,
        ChainState(np.zeros(N), np.zeros(N)),
        0.1,
        lambda t: offset + scale * np.sin(40.0 * t),
        -np.inf,
        prescribe=prescribe,
    )
    assert orders == pytest.approx(2.0, abs=0.05)


def test_stops_of_an_element_keep_order_2_when_static_is_dynamic_friction():
    chain = uniform_chain(
        1, static_friction=0.1, mass=0.05, damping=0.5, environment_stiffness=1e4, **SHEATH
    )
    time = np.linspace(0.0, 4.0, 101)
    load = 20.0 + 15.0 * np.sin(np.pi * time)
    runs = [
        simulate_chain(chain, time, input_tension=load, time_step=0.04 / 2**k).output_tension
        for k in range(7, 11)
    ]
    gaps = [np.abs(a - b).max() for a, b in itertools.pairwise(runs)]
    assert np.log2(gaps[0] / gaps[-1]) / 2 > 1.7
