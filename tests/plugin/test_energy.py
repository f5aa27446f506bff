"""Friction takes energy and nothing gives any; tendon is neither made nor lost."""

import mujoco
import numpy as np
import pytest

from tests.plugin.rigs import arm, elastic_energy, fixed_sheaths, started, tendon_total, unpacked

EA = 500.0


def friction_work(model, data):
    """Friction work of the flow of the step on trial: the loss of elastic energy by it [J].

    Length that leaves tension T takes T + T²/2EA along for each metre that it has unstretched.
    """
    tension = data.sensor("tension").data
    convected = tension + tension**2 / (2.0 * EA)
    _, _, guides = unpacked(model, data)
    at_guides = (convected[:-1] - convected[1:]) * guides["trial_flow"]
    assert at_guides.min() >= -1e-15, "tendon flows from the lower tension to the higher"
    return float(at_guides.sum())


def balance(model, data, duration):
    """Total energy with friction work over time; friction work, computed and by the sensor [J]."""
    total, work = [], 0.0
    for _ in range(round(duration / model.opt.timestep)):
        mujoco.mj_forward(model, data)
        work += friction_work(model, data)
        total.append(data.energy.sum() + elastic_energy(model, data, EA) + work)
        mujoco.mj_step(model, data)
    return np.array(total), work, data.sensor("friction_work").data.sum()


def drift(timestep, **values):
    """Largest departure from the energy at the start, over the friction work [-]."""
    model = arm(timestep=timestep, axial_stiffness=EA, **values)
    total, work, shown = balance(model, started(model, 3, 2.0), 0.3)
    assert work > 1e-2, "friction does work"
    assert shown == pytest.approx(work, rel=1e-9), "the sensor shows the friction work"
    return np.abs(total - total[0]).max() / work


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "RK4"])
@pytest.mark.parametrize("spools", [False, True])
def test_energy_and_friction_work_add_up_better_with_every_halving(integrator, spools):
    coarse, fine = (drift(h, integrator=integrator, spools=spools) for h in (2e-4, 1e-4))
    assert fine < 0.1
    assert fine < 0.6 * coarse


@pytest.mark.parametrize("seed", range(24))
def test_friction_work_never_decreases_at_any_guide(seed):
    rng = np.random.default_rng(seed)
    model = arm(
        timestep=float(rng.choice([1e-4, 5e-4, 2e-3])),
        integrator=str(rng.choice(["Euler", "implicitfast", "RK4"])),
        spools=bool(rng.integers(2)),
        friction=float(rng.choice([0.0, 0.1, 0.5])),
        static_friction=float(rng.choice([0.5, 0.8])),
        constant_friction=float(rng.choice([0.0, 0.5])),
        pretension=float(rng.choice([0.0, 2.0, 20.0])),
        axial_damping=float(rng.choice([0.0, 0.0, 1.0])),
        axial_stiffness=EA,
    )
    data = started(model, seed, float(rng.uniform(0.5, 5.0)))
    before = np.zeros(4)
    for _ in range(600):
        mujoco.mj_step(model, data)
        work = data.sensor("friction_work").data
        assert np.all(work >= before)
        before = work.copy()
    assert np.isfinite(data.qpos).all()


def test_what_the_arm_loses_is_damping_and_friction():
    model = arm(damping=0.2)
    data = started(model, 1, 3.0)
    mujoco.mj_forward(model, data)
    start = data.energy.sum() + elastic_energy(model, data, EA)
    damped = 0.0
    for _ in range(8000):
        mujoco.mj_step(model, data)
        damped += 0.2 * (data.qvel @ data.qvel) * model.opt.timestep
    mujoco.mj_forward(model, data)
    end = data.energy.sum() + elastic_energy(model, data, EA)
    lost = damped + data.sensor("friction_work").data.sum()
    assert start - end == pytest.approx(lost, rel=2e-2)


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
