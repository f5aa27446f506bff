"""Laws of the paper's Fig. 3 inside MuJoCo."""

import dataclasses

import mujoco
import numpy as np
import pytest

from experiments import references
from experiments.kaneko1991.chain import Chain, build_chain
from tendon_mj import theory
from tendon_mj.lab.replay import rollout_named_sensors

SLOW = Chain(elements=16, friction=0.1, mass=10.0, damping=100.0)


def follow(chain, duration, history, drive="tension"):
    """Run a history of time; return time and sensors."""
    time = np.arange(round(duration / chain.step)) * chain.step
    return time, rollout_named_sensors(build_chain(chain, drive).compile(), history(time))


def test_slow_chain_is_the_closed_form():
    time, result = follow(SLOW, 25.0, lambda t: 20.0 + 15.0 * np.sin(2 * np.pi * 0.08 * t))
    stride = len(time) // 500
    load = 20.0 + 15.0 * np.sin(2 * np.pi * 0.08 * time[::stride])
    exact = theory.output_tension(load, 0.1 * np.pi, 20.0)
    gap = np.abs(result["output_tension"][::stride] - exact).max()
    assert gap < 0.005 * np.ptp(exact)


def test_heavy_chain_is_that_of_the_reference():
    chain = dataclasses.replace(SLOW, mass=3.0, damping=50.0)
    time, result = follow(chain, 2.5, lambda t: 20.0 + 15.0 * np.sin(2 * np.pi * 2.0 * t))
    shared = ("length", "axial_stiffness", "pretension", "mass", "damping")
    given = {name: getattr(chain, name) for name in shared}
    other = references.uniform_chain(
        chain.elements, bend_angle=chain.bend, static_friction=chain.friction, **given
    )
    load = 20.0 + 15.0 * np.sin(2 * np.pi * 2.0 * time)
    exact = references.simulate_chain(other, time, input_tension=load).output_tension
    quiet = theory.output_tension(load, 0.1 * np.pi, 20.0)
    gap = np.abs(result["output_tension"] - exact).max()
    assert gap < 0.01 * np.ptp(exact)
    assert gap < 0.3 * np.abs(quiet - exact).max()  # it is inertia and damping that they share


def test_frictionless_chain_rings_at_its_lowest_mode():
    chain = dataclasses.replace(SLOW, elements=24, friction=0.0, mass=1.0, damping=0.0)
    period = 4.0 * np.sqrt(chain.mass * chain.length / chain.axial_stiffness)
    time, result = follow(chain, 10.0 * period, lambda t: np.full_like(t, 20.5))
    swing = result["input_displacement"] - result["input_displacement"].mean()
    rising = time[1:][(swing[:-1] < 0.0) & (swing[1:] >= 0.0)]
    assert (rising[-1] - rising[0]) / (len(rising) - 1) == pytest.approx(period, rel=0.01)


def test_beyond_the_front_nothing_moves():
    chain = dataclasses.replace(SLOW, friction=0.3, static_friction=0.3)
    model = build_chain(chain).compile()
    data = mujoco.MjData(model)
    for step in range(4000):
        data.ctrl[0] = 20.0 * np.exp(0.3 * np.pi / 2 * min(1.0, step / 3000))
        mujoco.mj_step(model, data)
    assert data.sensor("output_tension").data[0] == pytest.approx(20.0, abs=1e-9)
    assert abs(data.joint("bead_3").qpos[0]) > 1e-5
    assert abs(data.joint("bead_15").qpos[0]) < 1e-15
