"""The models whose steps are timed are the ones that they stand for."""

import dataclasses
import time

import mujoco
import numpy as np
import pytest

from tendon_mj.lab.finger import prepare_finger, tap
from tendon_mj.lab.replay import full_state, rollout_sensors
from tendon_mj.lab.verification import Spread, StepCost, bench_step_cost, finger_step_cost
from tendon_mj.lab.verification.mujoco_tendon import (
    mujoco_tendon_bench,
    mujoco_tendon_finger,
    without_tension_sensors,
)
from tendon_mj.lab.verification.timing import times_in_turns
from tendon_mj.models import JOINTS, Bench, Finger, build_bench, build_finger


def tapping_angles(spec, finger):
    """(steps, 3) joint angles of three taps [rad]."""
    prepared, controls = prepare_finger(tap(), spec.compile(), finger)
    model, data = prepared.model, prepared.data
    readings = rollout_sensors(model, [data], full_state(model, data)[None], controls[None])[0]
    return readings[:, [int(model.sensor(f"{joint}_angle").adr[0]) for joint in JOINTS]]


def test_without_friction_the_finger_moves_as_with_mujocos_own_tendons():
    finger = Finger(friction=0.0)
    ours = tapping_angles(build_finger(finger), finger)
    reference = tapping_angles(mujoco_tendon_finger(finger), finger)
    # what is wound in stretches no more: a tenth of the tendon, which MuJoCo's spring neglects
    np.testing.assert_allclose(ours, reference, atol=np.radians(1.0))


def test_the_finger_moves_alike_without_its_tension_sensors():
    finger = Finger()
    bare = without_tension_sensors(build_finger(finger))
    np.testing.assert_array_equal(
        tapping_angles(bare, finger), tapping_angles(build_finger(finger), finger)
    )


def test_without_friction_the_bench_is_as_stiff_as_with_mujocos_own_tendon():
    bench = Bench(friction=0.0)
    pulled = []
    for spec in (build_bench(bench), mujoco_tendon_bench(bench)):
        model = spec.compile()
        data = mujoco.MjData(model)
        data.joint("environment").qpos = -1e-4
        mujoco.mj_forward(model, data)
        pulled.append(data.qfrc_passive.copy())
    # the plugin's spring is EA/L at the pretension, MuJoCo's EA/S: T_0/EA apart
    rel = 2.0 * bench.pretension / bench.axial_stiffness
    np.testing.assert_allclose(pulled[0], pulled[1], rtol=rel, atol=1e-6)


def test_a_model_with_mujocos_own_tendons_has_no_plugin():
    for spec in (mujoco_tendon_bench(Bench()), mujoco_tendon_finger(Finger())):
        model = spec.compile()
        assert model.nplugin == 0
        assert (model.tendon_stiffness > 0.0).any()


def test_a_step_cost_is_positive_and_its_ratio_that_of_the_times():
    cost = bench_step_cost(Bench(guides=4), rounds=1)
    assert cost.step > 0.0
    assert cost.reference_step > 0.0
    cost = StepCost(np.array([3e-6, 5e-6, 4e-6]), np.array([2e-6, 2e-6, 1e-6]))
    assert cost.ratio == pytest.approx(2.5)
    assert cost.added.median == pytest.approx(3e-6)
    short = dataclasses.replace(tap(), time=tap().time / 10.0)
    assert finger_step_cost(short, friction=0.3, rounds=1).ratio > 0.0


def test_tasks_are_timed_in_turns():
    order = []
    spent = times_in_turns(
        [lambda: order.append("slow") or time.sleep(0.02), lambda: order.append("fast")], rounds=3
    )
    assert order == ["slow", "fast"] * 3
    assert spent.shape == (3, 2)
    assert (spent[:, 0] >= 0.02).all()


def test_a_spread_is_the_median_between_its_quartiles():
    assert Spread.of(np.array([4.0, 0.0, 3.0, 1.0, 2.0])) == Spread(2.0, 1.0, 3.0)
