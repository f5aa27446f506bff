"""The continuum against Hooke's law, the capstan law and the chain of elements."""

import numpy as np
import pytest

from experiments.references import (
    continuum,
    quasi_static,
    simulate_chain,
    simulate_continuum,
    uniform_chain,
)

SHEATH = {"length": 0.5, "axial_stiffness": 2e4, "pretension": 20.0}
END = {"environment_stiffness": 1e4, "sensor_stiffness": 4e4}


def history(rng, samples=60):
    return 20.0 * np.exp(rng.uniform(-1.5, 1.5, samples))


def test_no_friction_is_hooke():
    model = continuum(np.pi, friction=0.0, **SHEATH, **END)
    run = simulate_continuum(model, input_displacement=np.linspace(-1e-3, 4e-3, 50))
    stiffness = 1.0 / (0.5 / 2e4 + 1.0 / 1e4 + 1.0 / 4e4)
    assert run.output_tension == pytest.approx(20.0 + stiffness * run.input_displacement, rel=1e-12)


def test_first_motion_has_the_exact_elongation():
    lam, load = 0.8, 70.0
    model = continuum(np.pi, friction=lam / np.pi, intervals=512, **SHEATH)
    run = simulate_continuum(model, input_tension=[20.0, load])
    exact = 0.5 / 2e4 * (load * -np.expm1(-lam) / lam - 20.0)
    assert run.output_tension[-1] == pytest.approx(load * np.exp(-lam), rel=1e-14)
    assert run.input_displacement[-1] == pytest.approx(exact, rel=1e-6)


@pytest.mark.parametrize("drive", ["input_tension", "input_displacement"])
def test_refinement_is_of_order_2(drive):
    values = 20.0 + 15.0 * np.sin(np.linspace(0.0, 12.0, 400))
    if drive == "input_displacement":
        values = (values - 20.0) * 1e-4
    shown = []
    for intervals in (8192, 64, 128, 256, 512):
        model = continuum(tightening, friction=0.2, intervals=intervals, **SHEATH, **END)
        run = simulate_continuum(model, **{drive: values})
        shown.append(np.concatenate((run.output_tension / 20.0, run.input_displacement / 1e-3)))
    errors = np.sqrt(np.mean((np.array(shown[1:]) - shown[0]) ** 2, axis=1))
    orders = np.log2(errors[:-1] / errors[1:])
    assert orders == pytest.approx(2.0, abs=0.2)


def test_displacement_drive_inverts_tension_drive():
    model = continuum(np.pi, friction=0.3, **SHEATH, **END)
    by_tension = simulate_continuum(model, input_tension=history(np.random.default_rng(1)))
    back = simulate_continuum(model, input_displacement=by_tension.input_displacement)
    assert back.input_tension == pytest.approx(by_tension.input_tension, rel=1e-10)
    assert back.output_tension == pytest.approx(by_tension.output_tension, rel=1e-10)
    assert back.tension == pytest.approx(by_tension.tension, rel=1e-10)


def test_a_closed_loop_returns_to_where_it_began_at_the_cost_of_work_and_slack_is_taken_up():
    model = continuum(np.pi, friction=0.3, **SHEATH, **END)
    loop = np.concatenate((np.linspace(20, 60, 40), np.linspace(60, 9, 40), np.linspace(9, 60, 40)))
    run = simulate_continuum(model, input_tension=np.concatenate((loop, loop[40:])))
    assert run.output_tension[-80:] == pytest.approx(run.output_tension[-160:-80], rel=1e-13)
    again = run.input_displacement[-160:-80]
    assert run.input_displacement[-80:] == pytest.approx(again, rel=1e-11)
    mean = 0.5 * (run.input_tension[1:] + run.input_tension[:-1])
    work = np.cumsum(mean * np.diff(run.input_displacement))
    assert work[-1] - work[-81] > 0.0  # over one closed cycle of tension
    slack = simulate_continuum(model, input_displacement=[0.0, -0.1, -0.2, 0.0, 1e-2])
    assert slack.input_tension[1] == slack.input_tension[2] == slack.output_tension[2] == 0.0
    assert slack.input_tension[4] > slack.output_tension[4] > 0.0


def test_rate_does_not_matter():
    model = continuum(np.pi, friction=0.3, **SHEATH, **END)
    turns = history(np.random.default_rng(2), 20)
    dense = np.interp(np.linspace(0, 19, 1901), np.arange(20), turns)
    coarse, fine = (simulate_continuum(model, input_tension=t) for t in (turns, dense))
    assert fine.output_tension[::100] == pytest.approx(coarse.output_tension, rel=1e-13)
    assert fine.input_displacement[::100] == pytest.approx(coarse.input_displacement, abs=1e-15)


def test_array_function_and_total_give_the_same_sheath():
    for bend in (1.0, np.linspace(0.0, 1.0, 11), lambda x: 2.0 * x):
        model = continuum(bend, friction=0.1, intervals=10, **SHEATH)
        assert model.bend_angle == pytest.approx(np.linspace(0.0, 1.0, 11))
    straight = continuum(lambda x: 0.0, friction=0.1, **SHEATH)
    run = simulate_continuum(straight, input_tension=[20.0, 30.0])
    assert run.output_tension[-1] == pytest.approx(30.0)


SPRUNG = SHEATH | END
HISTORIES = {
    "first motion": ([0.0, 1.0], [0.0, 1.0]),
    "first motion, loosening": ([0.0, 1.0], [0.0, -1.0]),
    "outer loop": ([0.0, 1.0, 3.0, 5.0], [0.0, 1.0, -1.0, 1.0]),
    "minor loops": ([0.0, 1.0, 2.0, 2.8, 3.3, 5.0], [0.0, 1.0, -0.2, 0.5, -0.1, 1.0]),
}


def tightening(x):
    """A bend that tightens along the sheath [rad]."""
    return 2.0 * x + 8.0 * x**2


def even(x):
    return 2.0 * np.pi * np.asarray(x)


def largest_difference(lam, history, drive, n=64, slowness=300.0, turn=even):
    """Largest difference of T_out over its range between elements and continuum."""
    instants, turns = history
    time = np.linspace(0.0, instants[-1], 1001)
    swing = np.interp(time, instants, turns)
    # reaches well beyond the backlash either way without slack
    values = 1.2e-3 * swing if drive == "input_displacement" else 20.0 * np.exp(1.6 * swing)
    bends, friction = np.diff(turn(np.linspace(0.0, 0.5, n + 1))), lam / turn(0.5)
    chain = uniform_chain(n, bend_angle=bends, static_friction=friction, **SPRUNG)
    chain = quasi_static(chain, 4.0, slowness=slowness)
    elements = simulate_chain(chain, time, **{drive: values}, time_step=4.0 * chain.time_step)
    model = continuum(turn, friction=friction, intervals=2048, **SPRUNG)
    exact = simulate_continuum(model, **{drive: values})
    span = np.ptp(exact.output_tension)
    assert span > 2.0
    assert elements.energy.error < 1e-6
    return np.abs(elements.output_tension - exact.output_tension).max() / span


@pytest.mark.parametrize("history", HISTORIES)
@pytest.mark.parametrize(
    ("lam", "drive", "slowness"),
    [*((lam, "input_displacement", 300.0) for lam in (0.2, 1.0)), (0.5, "input_tension", 1000.0)],
)
def test_elements_and_continuum_agree(history, lam, drive, slowness):
    assert largest_difference(lam, HISTORIES[history], drive, slowness=slowness) < 0.005


def test_they_agree_where_the_bend_tightens():
    history = HISTORIES["outer loop"]
    assert largest_difference(0.6, history, "input_displacement", turn=tightening) < 0.005


def test_difference_shrinks_with_refinement():
    coarse, fine = (
        largest_difference(1.0, HISTORIES["outer loop"], "input_displacement", n, 1000.0)
        for n in (4, 16)
    )
    assert fine < coarse / 4.0
