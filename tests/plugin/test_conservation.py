"""Tendon is neither made nor lost: what is stored and what is wound is constant."""

import mujoco
import numpy as np
import pytest

from tests.plugin.rigs import arm, fixed_sheaths, started, tendon_total

STEPS = 100_000


def test_on_moving_bodies_and_spools_over_a_hundred_thousand_steps():
    model = arm(spools=True, damping=0.002, timestep=0.0005, static_friction=0.3)
    data = started(model, 1, 3.0)
    mujoco.mj_step(model, data)
    total = tendon_total(model, data)
    for burst in range(100):
        mujoco.mj_step(model, data, STEPS // 100)
        data.qvel[:] += 0.5 * np.sin(burst + np.arange(model.nv))
        assert tendon_total(model, data) == pytest.approx(total, rel=1e-12)
    assert data.sensor("friction_work").data.min() > 0.0


def test_on_a_reel_that_goes_back_and_forth_over_a_hundred_thousand_steps():
    model = fixed_sheaths([{"guides": 8, "bend": 3.0, "friction": 0.15, "pretension": 30.0}])
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    total = tendon_total(model, data, "sheath0")
    for k in range(STEPS // 10):
        data.ctrl[0] = 4e-4 * np.sin(0.05 * k)
        mujoco.mj_step(model, data, 10)
        if k % 100 == 0:
            assert tendon_total(model, data, "sheath0") == pytest.approx(total, rel=1e-12)
    assert tendon_total(model, data, "sheath0") == pytest.approx(total, rel=1e-12)


def test_through_slack_and_back():
    model = fixed_sheaths([{"guides": 8, "bend": 3.0, "friction": 0.15, "pretension": 30.0}])
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    total = tendon_total(model, data, "sheath0")
    slack = 0
    for k in range(2000):
        data.ctrl[0] = 0.01 * np.sin(0.01 * k)
        mujoco.mj_step(model, data)
        slack += data.sensordata[0] == 0.0
        assert tendon_total(model, data, "sheath0") == pytest.approx(total, rel=1e-12)
    assert 100 < slack < 1900
