"""The chain of elements: statics, order of the integrator, energy, stiction."""

import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from experiments.references import ChainState, quasi_static, simulate_chain, uniform_chain

SHEATH = {"length": 0.5, "bend_angle": np.pi, "axial_stiffness": 2e4, "pretension": 20.0}
N = 4
SOFT_SHEATH = SHEATH | {"axial_stiffness": 2e3}
TIME = np.linspace(0.0, 2.0, 401)
SWING = np.sin(2.0 * np.pi * TIME)
RUNS = {
    "tension, fixed end": ({}, {"input_tension": 20.0 + 15.0 * SWING}),
    "displacement, springs at the end": (
        {"environment_stiffness": 1e4, "sensor_stiffness": 4e4},
        {"input_displacement": 1e-3 * SWING},
    ),
    "stick-slip": (
        {"static_friction": 0.3, "dynamic_friction": 0.1},
        {"input_tension": 20.0 + 15.0 * SWING},
    ),
    "tension-independent friction": (
        {"friction_force": 3.0, "environment_stiffness": 1e4},
        {"input_displacement": 1e-3 * SWING},
    ),
    "linear law, paper's ends": (
        {"law": "linear", "ends": "paper"},
        {"input_tension": 20.0 + 15.0 * SWING},
    ),
    "slack": ({"environment_stiffness": 1e4}, {"input_displacement": -3e-3 * SWING}),
    "no friction": ({"static_friction": 0.0}, {"input_tension": 20.0 + 15.0 * SWING}),
}
HEAVY_SHEATH = SHEATH | {"mass": 0.05, "damping": 2.0}


@pytest.mark.parametrize("ends", ["half", "paper"])
def test_chain_without_friction_is_springs_in_series(ends):
    given = SHEATH | {"environment_stiffness": 1e4, "sensor_stiffness": 4e4}
    chain = uniform_chain(32, static_friction=0.0, ends=ends, mass=1e-6, damping=2e-3, **given)
    time = np.linspace(0.0, 25.0, 501)  # 0.04 Hz, Fig. 4 (a)
    swing = 15.0 * np.sin(2.0 * np.pi * 0.04 * time)
    run = simulate_chain(chain, time, input_tension=20.0 + swing, time_step=1e-3)
    stiffness = 1.0 / (0.5 / 2e4 + 1.0 / 1e4 + 1.0 / 4e4)
    line = 20.0 + stiffness * run.input_displacement
    assert np.abs(run.output_tension - line).max() < 1e-6 * 30.0
    settled = time > 5.0  # the sine begins with a kink, which rings for a while
    assert np.abs(run.output_tension - run.input_tension)[settled].max() < 1e-6 * 30.0


MU = 0.2


def slid(n, turns, **given):
    """Input tension [N] from turn to turn, a second each, and the run of a slow chain."""
    chain = uniform_chain(n, static_friction=MU, **given, **SHEATH)
    chain = quasi_static(chain, 1.0, slowness=2000.0)
    last = len(turns) - 1
    time = np.linspace(0.0, last, 100 * last + 1)
    load = np.interp(time, np.arange(last + 1), turns)
    return load, simulate_chain(chain, time, input_tension=load, time_step=5.0 * chain.time_step)


@pytest.mark.parametrize("ends", ["half", "paper"])
@pytest.mark.parametrize("n", [1, 7])
def test_ratio_is_exact_while_all_elements_slide_slowly(n, ends):
    load, run = slid(n, [20.0, 80.0, 8.0], ends=ends)
    ratio = run.output_tension / load
    assert ratio[81:101] == pytest.approx(np.exp(-MU * np.pi), rel=2e-3)
    assert ratio[196:] == pytest.approx(np.exp(MU * np.pi), rel=2e-3)


@pytest.mark.parametrize("n", [4, 16])
def test_linear_law_has_the_ratio_of_equation_22(n):
    load, run = slid(n, [20.0, 80.0], law="linear", ends="paper")
    expected = (1.0 - MU * np.pi / n) ** n
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


@pytest.mark.parametrize("prescribe", ["input_tension", "input_displacement", "sliding"])
def test_a_chain_that_slides_or_has_no_friction_is_of_order_2(prescribe):
    law, still = {"mass": 5.0, "damping": 20.0, **SOFT_SHEATH}, np.zeros(N)
    if prescribe == "sliding":
        law |= {"friction_force": 0.5, "environment_stiffness": 500.0}
        chain = uniform_chain(N, static_friction=0.1, **law)
        state = ChainState(still, np.full(N, 0.2))
        errors, orders = order(chain, state, 0.04, lambda t: 60.0 + 4000.0 * t, 0.0)
        assert errors[-1] < 1e-4
    else:
        scale, offset = (15.0, 20.0) if prescribe == "input_tension" else (3e-4, 0.0)

        def load(t):
            return offset + scale * np.sin(40.0 * t)

        chain, state = uniform_chain(N, static_friction=0.0, **law), ChainState(still, still)
        _, orders = order(chain, state, 0.1, load, -np.inf, prescribe=prescribe)
    assert orders == pytest.approx(2.0, abs=0.05)


def test_stops_of_an_element_keep_order_2_when_static_is_dynamic_friction():
    chain = uniform_chain(
        1, static_friction=0.1, mass=0.05, damping=0.5, environment_stiffness=1e4, **SOFT_SHEATH
    )
    time = np.linspace(0.0, 4.0, 101)
    load = 20.0 + 15.0 * np.sin(np.pi * time)
    runs = [
        simulate_chain(chain, time, input_tension=load, time_step=0.04 / 2**k).output_tension
        for k in range(7, 11)
    ]
    gaps = [np.abs(a - b).max() for a, b in itertools.pairwise(runs)]
    assert np.log2(gaps[0] / gaps[-1]) / 2 > 1.7


@pytest.mark.parametrize("name", RUNS)
def test_input_work_is_stored_plus_dissipated_and_the_tendon_does_not_push(name):
    settings, history = RUNS[name]
    chain = uniform_chain(16, **{"static_friction": 0.2} | HEAVY_SHEATH | settings)
    run = simulate_chain(chain, TIME, **history)
    assert run.unsolved_steps == 0
    assert run.energy.error < 1e-9
    assert np.diff(run.energy.friction_work).min() >= 0.0
    assert run.element_friction_work.min() >= 0.0
    assert run.element_friction_work.sum() == pytest.approx(run.energy.friction_work[-1])
    assert np.diff(run.energy.damping_work).min() >= 0.0
    assert run.energy.damping_work[-1] > 0.0
    lowest = min(run.input_tension.min(), run.output_tension.min())
    assert lowest == 0.0 if name == "slack" else lowest >= 0.0
    assert run.output_tension.min() < 0.1 or name != "slack"
    assert run.energy.friction_work[-1] > 0.0 or name == "no friction"


def test_undamped_chain_without_friction_keeps_its_energy():
    chain = uniform_chain(16, static_friction=0.0, mass=0.05, **SHEATH)
    run = simulate_chain(chain, TIME, input_tension=30.0)  # a step load: it rings for ever
    assert run.energy.kinetic.max() > 1e-4
    assert run.energy.error < 1e-9
    assert run.energy.dissipated.max() == 0.0


@pytest.mark.parametrize("law", ["exponential", "linear"])
@pytest.mark.parametrize("share", [0.999, -0.999])
def test_resting_element_does_not_creep_in_100_s(law, share):
    chain = uniform_chain(8, static_friction=0.3, dynamic_friction=0.1, law=law, **HEAVY_SHEATH)
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
    beyond = 20.0 + np.sign(share) * 1.002 * limit
    run = simulate_chain(chain, [0.0, 1.0], input_tension=beyond, record_elements=True)
    assert run.element_displacement[-1, 0] * share > 0.0, "it breaks away"


def test_element_pulled_and_let_go_stays_where_friction_holds_it():
    chain = uniform_chain(1, static_friction=0.3, ends="paper", **HEAVY_SHEATH)
    time = np.linspace(0.0, 102.0, 1021)
    load = np.interp(time, [0.0, 1.0, 2.0], [20.0, 80.0, 60.0])
    run = simulate_chain(chain, time, input_tension=load, time_step=1e-3, record_elements=True)
    held = run.element_displacement[time > 2.0, 0]
    assert held[0] > 0.0
    assert np.all(held == held[0])  # bit for bit, under 60 N against 31 N


def test_tension_independent_friction_holds_a_straight_tendon():
    settings = {**HEAVY_SHEATH, "bend_angle": 0.0}
    chain = uniform_chain(4, static_friction=0.0, friction_force=2.0, **settings)
    still = simulate_chain(chain, [0.0, 10.0], input_tension=20.499, time_step=1e-3)
    assert np.all(still.state.displacement == 0.0)
    moved = simulate_chain(chain, [0.0, 10.0], input_tension=20.501, time_step=1e-3)
    assert moved.state.displacement[0] > 0.0
    assert np.all(moved.state.displacement[1:] == 0.0)


def test_dynamic_friction_rules_in_motion():
    # overdamped, so that it does not snap past the balance of sliding
    settings = {**HEAVY_SHEATH, "damping": 200.0}
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
    chain = uniform_chain(8, static_friction=0.2, **HEAVY_SHEATH)
    time = np.linspace(0.0, 1.0, 65)
    load = 20.0 + 15.0 * np.sin(2.0 * np.pi * time)
    whole = simulate_chain(chain, time, input_tension=load)
    first = simulate_chain(chain, time[:33], input_tension=load[:33])
    second = simulate_chain(chain, time[32:], input_tension=load[32:], state=first.state)
    assert np.array_equal(whole.state.displacement, second.state.displacement)
    assert np.array_equal(whole.output_tension[32:], second.output_tension)
