"""Effects together: no energy from nothing, any history; `test_state` has their state."""

import mujoco
import numpy as np
import pytest

from tests.rigs import (
    ALL,
    ALL_ON_ARM,
    EA,
    EFFECTS,
    PRETENSION,
    Drives,
    arm,
    started,
    tendon_total,
    unpacked,
)

INTEGRATORS = ["Euler", "implicitfast", "RK4"]


@pytest.mark.parametrize("seed", range(30))
def test_any_mixture_on_any_arm_is_solved_and_only_rubs(seed):
    rng = np.random.default_rng(seed)
    later = dict.fromkeys(("load_gradient", "output_compliance"), np.random.default_rng(seed + 100))
    law = {
        name: value
        for name, value in ALL_ON_ARM.items()
        if later.get(name, rng).random() < 0.7 or name == "stribeck_velocity"
    }
    if "creep" in law:
        law["creep_time"] = 0.02
    if rng.random() < 0.3:
        law["tendon_mass"] = float(10.0 ** rng.uniform(-5, 0))
        law["viscous_friction"] = float(10.0 ** rng.uniform(-3, 3))
    model = arm(
        timestep=float(rng.choice([1e-4, 5e-4, 2e-3])),
        integrator=str(rng.choice(INTEGRATORS)),
        spools=bool(rng.integers(2)),
        pretension=float(rng.choice([0.0, 2.0, 20.0])),
        damping=0.02,
        **law,
    )
    data = started(model, seed, float(rng.uniform(0.5, 5.0)))
    mujoco.mj_step(model, data)
    total, before = tendon_total(model, data), np.zeros(4)
    for _ in range(1500):
        mujoco.mj_step(model, data)
        work = data.sensor("friction_work").data
        assert np.all(work >= before)
        before = work.copy()
    assert tendon_total(model, data) == pytest.approx(total, rel=1e-12)
    assert np.isfinite(data.plugin_state).all()
    assert np.isfinite(data.qpos).all()
    assert data.sensor("unsolved").data[0] == 0.0


@pytest.mark.parametrize("seed", range(20))
def test_any_history_of_drives_is_solved(seed):
    rng = np.random.default_rng(seed)
    drives = Drives(timestep=float(rng.choice([1e-4, 1e-3, 1e-2])), **ALL)
    reel, drum = (np.cumsum(rng.normal(size=1500)) * 10.0 ** rng.uniform(-5.5, -4) for _ in "12")
    limit = 0.02
    shown = drives.follow(np.clip(reel, -limit, limit), np.clip(drum, -limit, limit))
    assert np.isfinite(shown).all()
    assert shown.min() >= 0.0
    assert drives.unsolved == 0.0


def cycles_of_two_drives(cycles=3, steps=2000, reach=2e-4, **law):
    """(cycles,) work of two drives as they go round an ellipse, and friction work [J]."""
    drives = Drives(timestep=1e-3, **law)
    phase = 2.0 * np.pi * np.arange(cycles * steps + 1) / steps
    way = reach * np.stack([np.sin(phase), 0.7 * np.sin(phase + 1.0) - 0.7 * np.sin(1.0)], axis=1)
    force, friction_work = np.empty_like(way), np.empty(len(way))
    for k, at in enumerate(way):
        drives.step(*at)
        force[k] = drives.forces()
        friction_work[k] = drives.data.sensor("friction_work").data.sum()
    assert drives.unsolved == 0.0
    work = np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(way, axis=0), axis=1)
    return work.reshape(cycles, steps).sum(axis=1), np.diff(friction_work[::steps])


SCALE = PRETENSION**2 / EA * 0.5  # energy of the tendon at rest [J]
PERIODIC = ("static_friction", "constant_friction", "stribeck_friction", "direction_asymmetry",
            "friction_gradient", "load_gradient", "viscous_friction", "extra_bend", "stiffening",
            "sheath_compliance", "output_compliance")  # fmt: skip


@pytest.mark.parametrize("effect", EFFECTS)
@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_no_cycle_of_two_drives_gives_energy(effect, friction):
    work, _ = cycles_of_two_drives(friction=friction, **EFFECTS[effect])
    # the last cycle, since the first one sets out from another state than it comes back to
    assert work[-1] > -1e-6 * SCALE
    if not friction and effect in ("stiffening", "sheath_compliance", "output_compliance"):
        np.testing.assert_allclose(work, 0.0, atol=1e-6 * SCALE)  # what is stored comes back


@pytest.mark.parametrize("effect", PERIODIC)
def test_work_of_the_drives_is_friction_work_in_the_end(effect):
    work, friction_work = cycles_of_two_drives(steps=4000, **EFFECTS[effect])
    assert friction_work[-1] > 0.05 * SCALE
    assert work[-1] == pytest.approx(friction_work[-1], rel=2e-3)


def test_all_at_once_take_energy():
    work, friction_work = cycles_of_two_drives(**ALL)
    assert work.min() > friction_work.min() > 0.0


@pytest.mark.parametrize("timestep", [1e-3, 1e-4])
@pytest.mark.parametrize("inertia", [1.0, 10.0])
def test_a_motor_with_backlash_stores_no_more_than_it_has_put_in(timestep, inertia):
    drives = Drives(timestep=timestep, backlash=2e-4)
    model, data = drives.model, drives.data
    model.body_mass[model.body("reel").id] = inertia
    mujoco.mj_setConst(model, data)
    paid, start = 0.0, None
    for k in range(round(1.0 / timestep)):
        data.qfrc_applied[0] = PRETENSION + 20.0 * np.sin(2.0 * np.pi * k * timestep)
        before = data.qpos[0]
        mujoco.mj_step(model, data)
        data.qpos[1] = data.qvel[1] = 0.0
        paid += data.qfrc_applied[0] * (data.qpos[0] - before)
        stored = energy(model, data, {"axial_stiffness": EA})
        start = stored if start is None else start
        moving = 0.5 * inertia * data.qvel[0] ** 2
        assert stored - start + moving <= paid + 1e-4
    assert paid > 5e-3


def energy(model, data, law):
    """Of the arm, of the tendon's strain and creep, and of its speed [J]."""
    _, segments, guides = unpacked(model, data)
    ea, kappa, creep = law["axial_stiffness"], law.get("stiffening", 0.0), law.get("creep", 0.0)
    tau = segments["tension"]
    strain = 2.0 * tau / (1.0 + np.sqrt(1.0 + 4.0 * kappa * tau))
    crept = segments["creep_strain"]
    stored = segments["length"] / (1.0 + strain + crept)
    density = strain**2 / 2.0 + kappa * strain**3 / 3.0 + (crept**2 / 2.0 / creep if creep else 0)
    moving = law.get("tendon_mass", 0.0) / 2.0 * np.mean(guides["previous_velocity"] ** 2)
    return data.energy.sum() + ea * np.sum(stored * density) + moving


@pytest.mark.parametrize("effect", ["stiffening", "creep", "tendon_mass", "viscous_friction"])
def test_an_arm_on_a_frictionless_tendon_gains_less_with_every_halving(effect):
    law = {"friction": 0.0, "axial_stiffness": 500.0, "pretension": 8.0}
    law |= {k: ALL_ON_ARM[k] for k in EFFECTS[effect]}
    gains = []
    for timestep in (2e-4, 1e-4, 5e-5):
        model = arm(timestep=timestep, spools=True, **law)
        data = started(model, 3, 2.0)
        mujoco.mj_forward(model, data)
        total = []
        for _ in range(round(0.3 / timestep)):
            mujoco.mj_step(model, data)
            mujoco.mj_forward(model, data)
            total.append(energy(model, data, law))
        gains.append(max(total) - total[0])
    assert gains[2] <= 0.7 * gains[1] + 1e-9
    assert gains[2] < 0.05 * abs(total[0])
