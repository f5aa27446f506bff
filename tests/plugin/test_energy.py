"""Friction takes energy and nothing gives any; tendon is neither made nor lost."""

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction, largest_stiffness, view_sheath
from tests.rigs import (
    arm,
    elastic_energy,
    fixed_sheaths,
    rope,
    simulated,
    started,
    tendon_total,
    unpacked,
)

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
    """Total energy with what is lost over time; friction work, computed and by the sensor [J]."""
    total, work, damped = [], 0.0, 0.0
    for _ in range(round(duration / model.opt.timestep)):
        mujoco.mj_forward(model, data)
        work += friction_work(model, data)
        total.append(data.energy.sum() + elastic_energy(model, data, EA) + work + damped)
        damped += data.qvel[:3] ** 2 @ model.dof_damping[:3] * model.opt.timestep
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
@pytest.mark.parametrize("more", [{}, {"spools": True}, {"damping": 0.2}], ids=str)
def test_energy_and_what_is_lost_add_up_better_with_every_halving(integrator, more):
    coarse, fine = (drift(h, integrator=integrator, **more) for h in (2e-4, 1e-4))
    assert fine < 0.1
    assert fine < 0.6 * coarse


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


@pytest.mark.parametrize(
    ("reach", "rate", "steps", "slack"), [(4e-4, 5e-3, STEPS, 0.0), (0.01, 0.01, 2000, 0.05)]
)
def test_on_a_reel_that_goes_back_and_forth_taut_and_slack(reach, rate, steps, slack):
    model = fixed_sheaths([{"guides": 8, "bend": 3.0, "friction": 0.15, "pretension": 30.0}])
    data = simulated(model, 1)
    total, slackened = tendon_total(model, data, "sheath0"), 0
    for k in range(0, steps, 10):
        data.ctrl[0] = reach * np.sin(rate * k)
        mujoco.mj_step(model, data, 10)
        slackened += 10 * (data.sensordata[0] == 0.0)
        if k % 1000 == 0 or slack:
            assert tendon_total(model, data, "sheath0") == pytest.approx(total, rel=1e-12)
    assert slack * steps <= slackened <= (1.0 - slack) * steps


STEP = 2e-3
SPRING, DAMPER = 60.0, 1.0  # of the carriage [N/m, N s/m]
MASSES = [1.0, 0.2, 0.05, 0.01]
STIFFNESSES = [None, 2e3, 1e5, 1e7]


def carriage(mass, stiffness, step=STEP):
    """A carriage on a spring, pulled over two quarter turns."""
    text = rope(
        "a 0 0 .1; b 0 0 0; c .1 0 0; d .1 0 -.1",
        "e",
        body='pos=".1 0 -.3"',
        joint=f'type="slide" axis="0 0 1" stiffness="{SPRING}" damping="{DAMPER}"',
        geom=f'size=".01" mass="{mass}"',
        option=f'timestep="{step}" gravity="0 0 0"',
    )
    spec = mujoco.MjSpec.from_string(text)
    return add_friction(spec, "t", friction=0.3, axial_stiffness=stiffness, sensors=()).compile()


@pytest.mark.filterwarnings("ignore::tendon_mj.TendonWarning")
@pytest.mark.parametrize("mass", MASSES)
@pytest.mark.parametrize("stiffness", STIFFNESSES)
def test_no_energy_is_made_and_friction_holds(mass, stiffness):
    model = carriage(mass, stiffness)
    data = mujoco.MjData(model)
    data.ctrl[0] = -6.0
    mujoco.mj_forward(model, data)
    view, length, damped, held = view_sheath(model, data, "t"), data.ten_length[0], 0.0, []
    for _ in range(1500):
        mujoco.mj_step(model, data)
        damped += DAMPER * data.qvel[0] ** 2 * STEP
        held.append((float(view.output_tension), data.qpos[0]))
    mujoco.mj_fwdPosition(model, data)
    work = 6.0 * (length - data.ten_length[0])
    kept = 0.5 * mass * data.qvel[0] ** 2 + 0.5 * SPRING * data.qpos[0] ** 2
    assert kept + damped + view.friction_work.sum() == pytest.approx(work, rel=0.02)
    if mass < MASSES[0]:  # the heaviest still swings
        assert np.ptp(held[-20:], axis=0) == pytest.approx([0.0, 0.0], abs=0.01)


@pytest.mark.parametrize("mass", MASSES)
def test_it_comes_to_rest_where_a_finer_step_says(mass):
    assert largest_stiffness(carriage(mass, None), "t") < 1e5
    motions = []
    for parts in (1, 16):
        model = carriage(mass, None, STEP / parts)
        data, positions = mujoco.MjData(model), []
        data.ctrl[0] = -6.0
        for _ in range(500):
            mujoco.mj_step(model, data, parts)
            positions.append(data.qpos[0])
        motions.append((np.array(positions), view_sheath(model, data, "t").friction_work.sum()))
    (own, rubbed), (fine, finely) = motions
    assert np.abs(own - fine).max() < 0.15 * np.ptp(fine)  # of the integrator
    assert abs(own[-1] - fine[-1]) < 0.02 * np.ptp(fine)
    assert rubbed == pytest.approx(finely, rel=0.03)
