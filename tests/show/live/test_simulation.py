"""A live simulation goes on as `mj_step` does, remembers tensions, and takes new parameters."""

import contextlib
import signal
import threading

import mujoco
import numpy as np
import pytest

import tendon_mj
from tendon_mj.errors import InvalidValueError, TendonError, UnknownKeyError
from tendon_mj.show.live import LiveSimulation
from tendon_mj.show.live.real_time import run_in_real_time
from tests.show.live.models import TENSION, pulled


def test_it_advances_as_mujoco_does():
    simulation = pulled(lambda time: np.array([TENSION * np.sin(time) ** 2])).simulation
    other = mujoco.MjData(simulation.model)
    assert simulation.advance(0.5) == pytest.approx(0.5)
    for _ in range(250):
        other.ctrl[0] = TENSION * np.sin(other.time) ** 2
        mujoco.mj_step(simulation.model, other)
    assert simulation.data.time == other.time
    assert np.array_equal(simulation.data.qpos, other.qpos)


def test_less_than_half_a_step_advances_nothing():
    simulation = pulled().simulation
    assert simulation.advance(0.4 * simulation.model.opt.timestep) == 0.0
    assert simulation.data.time == 0.0


def test_it_remembers_the_tensions_of_the_last_seconds():
    prepared = pulled()
    simulation = LiveSimulation(prepared.simulation.model, lambda t: np.array([TENSION]), 1.0)
    for _ in range(30):
        simulation.advance(0.1)
    times, tensions = simulation.curves()
    assert times[-1] == pytest.approx(simulation.data.time)
    assert 0.85 <= times[-1] - times[0] <= 1.0 + 1e-9
    assert tensions.shape == (len(times), 1, 2)
    view = tendon_mj.view_sheath(simulation.model, simulation.data, "t")
    np.testing.assert_array_equal(tensions[-1, 0], view.tension[[0, -1]])
    np.testing.assert_array_equal(simulation.tensions(), tensions[-1])


def test_a_parameter_acts_while_it_runs():
    simulation = pulled().simulation
    simulation.advance(1.0)
    assert simulation.tensions()[0, 1] < 0.9 * TENSION
    simulation.set("sheath.friction", 0.0)
    simulation.advance(1.0)
    assert simulation.tensions()[0, 1] == pytest.approx(TENSION, rel=1e-6)


def test_a_parameter_that_is_none_or_out_of_range_is_refused():
    simulation = pulled().simulation
    with pytest.raises(UnknownKeyError, match="frictoin"):
        simulation.set("sheath.frictoin", 0.1)
    with pytest.raises(InvalidValueError, match="friction"):
        simulation.set("sheath.friction", -0.1)


def test_a_reset_begins_anew_and_keeps_the_parameters():
    simulation = pulled().simulation
    simulation.set("sheath.friction", 0.07)
    simulation.advance(0.3)
    simulation.reset()
    assert simulation.data.time == 0.0
    assert simulation.parameters["sheath.friction"] == 0.07
    assert len(simulation.curves()[0]) == 1


def test_another_pretension_lays_a_wound_tendon_anew():
    model = tendon_mj.load_model("bench")
    simulation = LiveSimulation(model, lambda time: np.zeros(model.nu))
    simulation.advance(0.1)
    sheath = simulation.sheaths[0]
    before = simulation.tensions()[0]
    simulation.set(f"{sheath}.pretension", 2.0 * simulation.parameters[f"{sheath}.pretension"])
    simulation.advance(0.1)
    assert (simulation.tensions()[0] > 1.1 * before).all()  # the load has yielded meanwhile


def test_an_unstable_simulation_is_said_to_be_one():
    simulation = pulled(lambda time: np.array([1e12])).simulation
    with pytest.raises(TendonError, match="became unstable before"):
        simulation.advance(5.0)


def test_it_keeps_the_pace_of_the_clock_until_nobody_watches():
    simulation, left = pulled().simulation, iter([True] * 30 + [False])
    done = run_in_real_time(simulation, lambda: next(left))
    assert done.frames == 30
    assert done.simulated <= done.elapsed + simulation.model.opt.timestep
    assert done.simulated == pytest.approx(simulation.data.time)
    assert "× real time" in done.sentence()


def test_ctrl_c_ends_it_quietly_and_a_pause_stands_still():
    simulation, before = pulled().simulation, signal.getsignal(signal.SIGINT)
    simulation.paused, left = True, iter([True] * 3)

    def show():
        if next(left, None) is None:
            with contextlib.suppress(KeyboardInterrupt):  # as a viewer's callback may
                signal.raise_signal(signal.SIGINT)
        return True

    done = run_in_real_time(simulation, show)
    assert (done.simulated, done.elapsed, done.frames) == (0.0, 0.0, 3)
    assert simulation.data.time == 0.0
    assert signal.getsignal(signal.SIGINT) is before


def test_a_second_ctrl_c_ends_it_at_once():
    def show():
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
        raise AssertionError("not reached")

    with pytest.raises(KeyboardInterrupt):
        run_in_real_time(pulled().simulation, show)


def test_in_a_thread_of_its_own_it_leaves_signals_alone():
    simulation, done = pulled().simulation, []
    run = threading.Thread(
        target=lambda: done.append(run_in_real_time(simulation, lambda: True, seconds=0.05))
    )
    run.start()
    run.join()
    assert done[0].frames > 0


def test_it_ends_when_the_time_is_up():
    done = run_in_real_time(pulled().simulation, lambda: True, seconds=0.1)
    assert done.elapsed >= 0.1
