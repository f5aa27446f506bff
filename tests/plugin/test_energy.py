"""Friction takes energy and nothing gives any."""

import mujoco
import numpy as np
import pytest

from tests.plugin.rigs import arm, elastic_energy, started, unpacked

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
