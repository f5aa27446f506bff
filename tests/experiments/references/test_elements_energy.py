"""Energy laws of the lumped elements: nothing is lost unseen, friction only takes."""

import numpy as np
import pytest

from experiments.references import simulate_chain, uniform_chain

SHEATH = {"length": 0.5, "bend_angle": np.pi, "axial_stiffness": 2e4, "pretension": 20.0}
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


@pytest.fixture(scope="module", params=RUNS, ids=str)
def run(request):
    settings, history = RUNS[request.param]
    settings = {"static_friction": 0.2, "mass": 0.05, "damping": 2.0, **SHEATH, **settings}
    return simulate_chain(uniform_chain(16, **settings), TIME, **history)


def test_input_work_is_stored_plus_dissipated(run):
    assert run.unsolved_steps == 0
    assert run.energy.error < 1e-9


def test_friction_work_never_falls(run):
    assert np.diff(run.energy.friction_work).min() >= 0.0
    assert run.element_friction_work.min() >= 0.0
    assert run.element_friction_work.sum() == pytest.approx(run.energy.friction_work[-1])


def test_damping_work_never_falls(run):
    assert np.diff(run.energy.damping_work).min() >= 0.0


def test_tendon_does_not_push(run):
    assert min(run.input_tension.min(), run.output_tension.min()) >= 0.0


def test_slack_was_reached_by_the_slack_run():
    settings, history = RUNS["slack"]
    chain = uniform_chain(16, static_friction=0.2, mass=0.05, damping=2.0, **SHEATH, **settings)
    run = simulate_chain(chain, TIME, **history)
    assert run.input_tension.min() == 0.0
    assert run.output_tension.min() < 0.1


def test_no_friction_dissipates_by_damping_alone():
    chain = uniform_chain(16, static_friction=0.0, mass=0.05, damping=2.0, **SHEATH)
    run = simulate_chain(chain, TIME, input_tension=20.0 + 15.0 * SWING)
    assert run.energy.friction_work[-1] == 0.0
    assert run.energy.damping_work[-1] > 0.0


def test_undamped_chain_without_friction_keeps_its_energy():
    chain = uniform_chain(16, static_friction=0.0, mass=0.05, **SHEATH)
    run = simulate_chain(chain, TIME, input_tension=30.0)  # a step load: it rings for ever
    assert run.energy.kinetic.max() > 1e-4
    assert run.energy.error < 1e-9
    assert run.energy.dissipated.max() == 0.0
