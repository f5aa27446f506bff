"""Each effect of a transmission alone, against its closed form."""

import numpy as np
import pytest

from tendon_mj import Parameters
from tests.rigs import (
    ALL,
    BEND,
    EA,
    EFFECTS,
    GUIDES,
    LENGTH,
    ON_DRUM,
    PRETENSION,
    Drives,
    arm,
    run,
    started,
)

NONE = dict.fromkeys(ALL, 0.0) | {"static_friction": 0.2}
SCALES = {"stribeck_velocity": 0.02, "creep_time": 0.05}
MU = 0.2
SPEEDS = np.array([1e-4, 5e-3, 2e-2, 0.5])  # [m/s]


def there_and_back(drives, reach=2e-3, steps=200):
    way = reach * np.sin(np.linspace(0.0, 4 * np.pi, steps))
    return drives.follow(way, -0.3 * way)


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "RK4"])
@pytest.mark.parametrize("scales", [{}, SCALES])
@pytest.mark.parametrize("damping", [{}, {"axial_damping": 1.0}])
def test_an_effect_of_zero_is_none_to_the_last_bit(integrator, scales, damping):
    law = {"spools": True, "integrator": integrator} | damping
    plain, zero = arm(**law), arm(**NONE | scales | law)
    one, other = (run(m, started(m, 2, 2.0), 300) for m in (plain, zero))
    np.testing.assert_array_equal(one.qpos, other.qpos)
    np.testing.assert_array_equal(one.qvel, other.qvel)
    np.testing.assert_array_equal(one.sensordata, other.sensordata)


@pytest.mark.parametrize("effect", EFFECTS)
def test_an_effect_acts_alike_live_and_made_and_leaves_nothing_when_it_ends(effect):
    made, live = Drives(**EFFECTS[effect]), Drives()
    parameters = Parameters(live.model, live.data)
    for name, value in EFFECTS[effect].items():
        parameters[f"sheath.{name}"] = value
    shown = there_and_back(live)
    np.testing.assert_array_equal(there_and_back(made), shown)
    assert np.abs(there_and_back(Drives()) - shown).max() > 1e-3
    for name in EFFECTS[effect]:
        parameters[f"sheath.{name}"] = 0.0
    live.draw(0.05, 400)  # but where the tendon lies, and what crept
    assert effect == "creep" or live.loss == pytest.approx(MU * BEND, rel=1e-9)


@pytest.mark.parametrize(
    ("law", "speed", "exponent"),
    [
        *(({"extra_bend": extra}, 0.05, MU * (BEND + extra)) for extra in (0.8, -0.5)),
        ({"extra_bend": -2.0 * BEND}, 0.05, 0.0),
        *(
            ({"direction_asymmetry": a, "static_friction": 0.3}, v, way * MU * (1 + way * a) * BEND)
            for a in (-0.4, 0.3)
            for v, way in ((0.05, 1.0), (-0.05, -1.0))
        ),
        *(
            ({"stribeck_friction": 0.1, "stribeck_velocity": 0.01}, v, (MU + 0.1 * e) * BEND)
            for v, e in zip(SPEEDS, np.exp(-ON_DRUM * SPEEDS / 0.01), strict=True)
        ),
    ],
)
def test_a_drawn_tendon_loses_the_exponent_of_its_effect(law, speed, exponent):
    drives = Drives(timestep=2e-3, **law)
    drives.draw(speed, 500)
    rel = 1e-6 if "stribeck_friction" in law else 1e-9
    assert drives.loss == pytest.approx(exponent, rel=rel, abs=1e-12)


@pytest.mark.parametrize("drift", [0.5, -0.3, -4.0])
def test_friction_drifts_with_time(drift):
    drives = Drives(friction_drift=drift)
    for _ in range(3):
        drives.draw(0.05, 300)
        time = drives.data.time - drives.timestep  # of the evaluation that is shown
        assert drives.loss == pytest.approx(
            MU * max(0.0, 1.0 + drift * time) * BEND, rel=1e-9, abs=1e-9
        )


@pytest.mark.parametrize("gradient", [8.0, -5.0])
def test_friction_depends_on_what_has_passed(gradient):
    drives = Drives(friction_gradient=gradient)
    for speed in (0.1, 0.1, -0.3):
        drives.draw(speed, 300)
        # all of the tendon but what it stretches has moved as the drives have, a step ago
        passed = drives.data.qpos[0] - speed * drives.timestep
        _, _, guides = drives.tables()
        before = guides["passed"] - guides["trial_flow"]
        np.testing.assert_allclose(before, passed, atol=LENGTH * 200.0 / EA)
        grown = np.mean(np.maximum(0.0, 1.0 + gradient * before))
        assert drives.loss == pytest.approx(np.sign(speed) * MU * grown * BEND, rel=1e-9)


@pytest.mark.parametrize("growth", [0.02, -0.01])
def test_friction_grows_with_the_tension_by_its_closed_form(growth):
    """dT/dφ = μ (1 + λ (T − T_0)) T, of the second order in the bend of a guide."""
    errors = []
    for guides in (8, 32):
        drives = Drives(load_gradient=growth, guides=guides)
        for speed in (0.1, -0.1):
            low, high = sorted(drives.draw(speed, 500))
            a, b = MU * (1.0 - growth * PRETENSION), MU * growth
            grown = np.exp(a * BEND)
            errors.append(abs(a * low * grown / (a + b * low * (1.0 - grown)) / high - 1.0))
    assert max(errors) < 2e-3
    assert max(errors[2:]) < 0.1 * max(errors[:2])


def test_friction_remembers_speed_for_twenty_milliseconds():
    drives = Drives(stribeck_friction=0.1, stribeck_velocity=0.01, timestep=1e-4)
    drives.draw(0.05, 3000)
    _, _, guides = drives.tables()
    np.testing.assert_allclose(guides["sliding_speed"], 0.05 * ON_DRUM, rtol=1e-3)
    for _ in range(200):
        drives.step(*drives.data.qpos)
    late = 0.05 * ON_DRUM * np.exp(-1.0)
    np.testing.assert_allclose(guides["sliding_speed"], late, rtol=6e-3)


@pytest.mark.parametrize("friction", [0.0, MU])
@pytest.mark.parametrize(("viscosity", "constant"), [(1.0, 0.0), (40.0, 0.0), (16.0, 0.8)])
def test_viscous_and_constant_friction_come_on_top_and_the_first_is_linear_in_speed(
    viscosity, constant, friction
):
    law = {"viscous_friction": viscosity, "constant_friction": constant, "friction": friction}
    drives = Drives(guides=1, **law)
    for speed in (0.02, 0.5, -0.1):
        low, high = sorted(drives.draw(speed, 400))
        more = constant + viscosity * ON_DRUM * abs(speed)
        assert high == pytest.approx(low * np.exp(friction * BEND) + more, rel=1e-6)
    assert drives.unsolved == 0.0


def test_viscous_friction_lets_the_tension_even_out_at_rest():
    drives = Drives(viscous_friction=2e4, friction=0.0)
    way = np.concatenate([np.linspace(0.0, 1e-3, 20), np.full(2000, 1e-3)])
    tensions = drives.follow(way)
    uneven = tensions[:, 0] - tensions[:, 1]
    assert uneven[19] > 5.0
    assert np.all(np.diff(uneven[20:]) < 1e-9)
    assert uneven[-1] == pytest.approx(0.0, abs=1e-6)


def test_the_drum_follows_across_the_backlash_and_the_drive_feels_it_only_there():
    drives = Drives(backlash=4e-4)
    way = 1e-3 * np.array([0.0, 0.1, 0.2, 0.5, 1.0, 0.9, 0.61, 0.6, 0.3, 0.31, 0.7, 0.71, 1.2])
    drum = 1e-3 * np.array([0.0, 0.0, 0.0, 0.3, 0.8, 0.8, 0.8, 0.8, 0.5, 0.5, 0.5, 0.51, 1.0])
    for k, (at, wound) in enumerate(zip(way, drum, strict=True)):
        before = drives.ends
        drives.step(at)
        shown = drives.data.sensor("reel_displacement").data[0]
        assert shown == pytest.approx(wound, abs=1e-9)
        if k in (5, 6, 9):  # within the gap
            np.testing.assert_allclose(drives.ends, before, rtol=1e-9)
        if k in (1, 3, 4, 5, 6, 9, 12):  # else at an edge
            assert (drives.forces()[0] != 0.0) == (k in (3, 4, 12))
            assert drives.forces()[1] != 0.0


@pytest.mark.parametrize("stiffening", [0.0, 3.0, 50.0])
@pytest.mark.parametrize("tension", [0.0, PRETENSION])
def test_a_tendon_that_stiffens_has_its_curve(stiffening, tension):
    drives = Drives(friction=0.0, stiffening=stiffening, pretension=tension, axial_stiffness=2e3)
    tau = tension / 2e3
    strain = 2 * tau / (1 + np.sqrt(1 + 4 * stiffening * tau))
    length = drives.model.tendon_length0[0]
    for way in (0.0, 1e-3, 0.03, 0.01, -1e-4):
        drives.step(way)
        strain_there = max(0.0, length / (length - way) * (1.0 + strain) - 1.0)
        expected = 2e3 * strain_there * (1.0 + stiffening * strain_there)
        np.testing.assert_allclose(drives.tension, expected, rtol=1e-11, atol=1e-9)


def test_what_a_drive_of_a_stiffening_tendon_feels_is_its_energy():
    drives = Drives(friction=0.0, stiffening=20.0, axial_stiffness=2e3)
    way = np.linspace(0.0, 0.05, 4001)
    felt = np.empty_like(way)
    for k, at in enumerate(way):
        drives.step(at)
        felt[k] = drives.forces()[0]
    work = np.sum(0.5 * (felt[1:] + felt[:-1]) * np.diff(way))

    def energy(tension, length):
        tau = tension / 2e3
        e = 2 * tau / (1 + np.sqrt(1 + 80.0 * tau))
        return 2e3 * (e**2 / 2 + 20.0 * e**3 / 3) * length / (1 + e)

    length = drives.model.tendon_length0[0]
    gained = energy(drives.ends[0], length) - energy(PRETENSION, length)
    assert work == pytest.approx(gained, rel=1e-5)


@pytest.mark.parametrize("damping", [0.0, 2.0])
def test_creep_relaxes_the_tension(damping):
    creep, time = 0.4, 0.1
    drives = Drives(friction=0.0, creep=creep, creep_time=time, axial_damping=damping)
    drives.step(0.0)
    np.testing.assert_allclose(drives.tension, PRETENSION, rtol=1e-9)
    strain = PRETENSION / EA
    length = drives.model.tendon_length0[0]
    shown = drives.follow(np.full(1500, 1e-3))[:, 0]
    total = length / (length - 1e-3) * (1.0 + strain * (1.0 + creep)) - 1.0
    last = total / (1.0 + creep)
    assert shown[-1] == pytest.approx(EA * last, rel=1e-5)
    at = drives.timestep * np.arange(1, 1501)
    first = total - creep * strain
    exact = last + (first - last) * np.exp(-at * (1.0 + creep) / time)
    late = at > 0.02  # what damping adds has gone by then
    np.testing.assert_allclose(shown[late], EA * exact[late], rtol=2e-3)
    after = drives.follow(np.zeros(1500))[:, 0]  # creep goes back when the load does
    assert after[0] < 0.9 * PRETENSION
    assert after[-1] == pytest.approx(PRETENSION, rel=1e-5)


@pytest.mark.parametrize("compliance", [1e-6, 1e-4])
@pytest.mark.parametrize("mounts", [("sheath",), ("output",), ("sheath", "output")])
def test_the_mounts_compliances_are_in_series(compliance, mounts):
    drives = Drives(friction=0.0, **{f"{end}_compliance": compliance for end in mounts})
    length = drives.model.tendon_length0[0]
    for way in (0.0, 5e-4, 2e-3, -2e-4):
        drives.step(way)
        path = length - len(mounts) * compliance * (drives.ends[0] - PRETENSION)
        strain = path / (length - way) / ON_DRUM - 1.0
        np.testing.assert_allclose(drives.tension, max(0.0, EA * strain), rtol=1e-9, atol=1e-7)


def test_a_mount_yields_to_the_tension_of_its_end():
    """Beside a stiff tendon it takes all motion, by the tension before the friction or behind."""
    way, compliance = 2e-3, 1e-3
    for end, k in (("sheath", 0), ("output", 1)):
        drives = Drives(axial_stiffness=1e6, **{f"{end}_compliance": compliance})
        drives.follow(np.linspace(0.0, way, 200))
        assert compliance * (drives.ends[k] - PRETENSION) == pytest.approx(way, rel=0.01)


def test_a_tendon_s_momentum_changes_by_what_pulls_it():
    mass = 0.05
    drives = Drives(friction=0.0, tendon_mass=mass)
    before, at = np.zeros(GUIDES), 0.0
    for k in range(400):
        at += 1e-6 * k
        ahead, behind = drives.step(at, -at)
        now = drives.tables()[2]["previous_velocity"].copy()
        gained = mass / GUIDES * (now - before).sum() / drives.timestep
        assert ahead - behind == pytest.approx(gained, rel=1e-6, abs=1e-9)
        before = now
    # all of it at the drives' acceleration by then
    assert ahead - behind == pytest.approx(mass * 1e-6 / drives.timestep**2, rel=1e-2)
    assert drives.unsolved == 0.0


def test_a_tendon_with_mass_rings_as_a_string_does():
    mass, stiffness, timestep = 0.05, 2e3, 1e-5
    law = {"friction": 0.0, "tendon_mass": mass, "axial_stiffness": stiffness, "pretension": 3.0}
    drives = Drives(timestep=timestep, guides=32, **law)
    drives.step(0.0)
    period = 2.0 * np.sqrt(LENGTH * mass / stiffness)
    plucked = 1e-4 * np.minimum(1.0, timestep * np.arange(5000) / period)
    shown = np.diff(drives.follow(plucked - plucked**2 * 5e3, 0.0), axis=1)[:, 0]
    shown = shown[round(period / timestep) :]
    rises = np.flatnonzero((shown[1:] > 0.0) & (shown[:-1] <= 0.0))
    assert timestep * np.diff(rises).mean() == pytest.approx(period, rel=1e-2)
    assert drives.unsolved == 0.0


@pytest.mark.parametrize(
    ("law", "within"),
    [
        ({"tendon_mass": 1e-9, "viscous_friction": 1e-9}, 1e-6),
        ({"extra_bend": BEND, "friction": 0.5 * MU}, 1e-9),
    ],
)
def test_a_light_tendon_is_as_one_without_mass_and_extra_bend_rubs_as_drawn_bend(law, within):
    plain, other = there_and_back(Drives()), there_and_back(Drives(**law))
    np.testing.assert_allclose(plain, other, rtol=within, atol=within if within > 1e-8 else 0.0)


def test_a_heavy_tendon_runs_on_when_the_drives_stop():
    drives = Drives(tendon_mass=1.0, friction=0.02, timestep=1e-4, axial_stiffness=2e3)
    way = 1e-4 * np.arange(200) * 0.5
    drives.follow(way, -way)
    drives.step(way[-1], -way[-1])
    ahead, behind = drives.ends
    assert ahead < behind, "its momentum pulls at the output"
    assert np.all(drives.tables()[2]["trial_flow"] > 0.0)


@pytest.mark.parametrize("creep", [0.0, 0.4])
def test_every_segment_lies_on_the_curve_of_its_strain_in_every_step(creep):
    """T = EA ε (1 + κ ε) of the elastic strain, which is the whole one less what has crept."""
    kappa, law = 80.0, {"creep": creep, "creep_time": 0.02 if creep else 0.0}
    drives = Drives(stiffening=kappa, **law)
    for way in 1.5e-3 * (1.0 - np.cos(np.linspace(0.0, 4.0 * np.pi, 150))):
        drives.step(way, -0.3 * way)
        _, segments, _ = drives.tables()
        strain, tension = segments["trial_strain"], segments["tension"]
        taut = tension > 0.0
        assert taut.any()
        np.testing.assert_allclose(
            tension[taut], (strain * (1.0 + kappa * strain))[taut], rtol=1e-9, atol=1e-12
        )
    assert np.ptp(drives.tension) > 1.0  # friction has spread them over the curve
    assert drives.unsolved == 0.0
