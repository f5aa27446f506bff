"""Every effect of the elements against a law that it alone obeys; none makes energy."""

import dataclasses
import math

import numpy as np
import pytest

from experiments.references import (
    Carriage,
    Effects,
    quasi_static,
    simulate_chain,
    simulate_effects,
    uniform_chain,
)

BENCH = {
    "length": 0.5,
    "bend_angle": np.pi,
    "axial_stiffness": 2e4,
    "pretension": 20.0,
    "static_friction": 0.15,
    "environment_stiffness": 1e4,
    "sensor_stiffness": 4e4,
    "mass": 1e-3,
}
EXPONENT = 0.15 * np.pi
TIME = np.linspace(0.0, 4.0, 1001)
SWING = 1e-3 * np.sin(2.0 * np.pi * TIME)
CARRIAGES = (
    Carriage(mass=1.0, stiffness=4e4, damping=400.0),
    Carriage(mass=1.0, stiffness=1e4, damping=200.0),
)


def chain(n=24, **numbers):
    return uniform_chain(n, **{**BENCH, **numbers})


def stiff(**numbers):
    """A tendon that hardly stretches, so that every element moves as the input does."""
    return chain(
        axial_stiffness=2e7, environment_stiffness=8e3, sensor_stiffness=math.inf, **numbers
    )


def ramp(speed, seconds=1.0):
    time = np.linspace(0.0, seconds, 501)
    return time, speed * time


def log_ratio(run):
    return np.log(run.input_tension / run.output_tension)


EFFECTS = {
    "none": Effects(),
    "velocity_weakening": Effects(stribeck_friction=0.05, stribeck_velocity=3e-3),
    "viscous_friction": Effects(viscous_friction=50.0),
    "constant_friction": Effects(constant_friction=2.0),
    "direction_asymmetry": Effects(direction_asymmetry=0.3),
    "position_dependent_friction": Effects(friction_gradient=200.0),
    "friction_drift": Effects(friction_drift=0.1),
    "backlash": Effects(backlash=2e-4),
    "stiffening": Effects(stiffening=100.0, axial_stiffness=2e4),
    "creep": Effects(creep=0.3, creep_time=0.5),
    "sheath_compliance": Effects(sheath_compliance=1e-5),
    "tendon_inertia": Effects(tendon_mass=0.2, retardation_time=1e-4),
    "extra_bend": Effects(extra_bend=0.5),
    "finite strain": Effects(axial_stiffness=2e4),
    "all": Effects(
        stribeck_friction=0.05,
        stribeck_velocity=3e-3,
        viscous_friction=50.0,
        constant_friction=1.0,
        direction_asymmetry=0.3,
        friction_gradient=200.0,
        friction_drift=0.1,
        backlash=1e-4,
        stiffening=100.0,
        creep=0.3,
        creep_time=0.5,
        sheath_compliance=1e-5,
        tendon_mass=0.1,
        retardation_time=1e-4,
        extra_bend=0.5,
        axial_stiffness=2e4,
    ),
}


@pytest.mark.parametrize(
    ("friction", "names", "within"),
    [
        ({}, ("input_tension", "output_tension", "output_displacement"), 5e-4),
        ({"static_friction": 0.25, "dynamic_friction": 0.15}, ("output_tension",), 0.02),
    ],
)
def test_inert_effects_are_the_chain_without(friction, names, within):
    plain = quasi_static(chain(**friction), 1.0, slowness=100)
    expected = simulate_chain(plain, TIME, input_displacement=SWING)
    run = simulate_effects(chain(**friction), Effects(), TIME, SWING)
    for name in names:
        mine, theirs = getattr(run, name), getattr(expected, name)
        assert np.sqrt(np.mean((mine - theirs) ** 2)) < within * np.ptp(theirs), name


@pytest.mark.parametrize("name", EFFECTS)
@pytest.mark.parametrize("carriages", [(), CARRIAGES], ids=["springs", "carriages"])
def test_every_step_is_solved_and_halving_it_changes_little(name, carriages):
    runs = [
        simulate_effects(chain(), EFFECTS[name], TIME, SWING, carriages=carriages, time_step=h)
        for h in (1.25e-4, 6.25e-5)
    ]
    assert [run.unsolved_steps for run in runs] == [0, 0]
    for column in ("input_tension", "output_tension"):
        coarse, fine = (getattr(run, column) for run in runs)
        assert np.sqrt(np.mean((coarse - fine) ** 2)) < 5e-4 * np.ptp(fine)


@pytest.mark.parametrize("name", EFFECTS)
def test_no_effect_gives_energy_over_closed_cycles(name):
    run = simulate_effects(chain(), EFFECTS[name], TIME, SWING, carriages=CARRIAGES)
    cycles = run.input_work[250::250]  # after the first one
    assert np.diff(cycles).min() > 0.0


@pytest.mark.parametrize("name", EFFECTS)
def test_a_tendon_with_effects_does_not_push(name):
    run = simulate_effects(chain(), EFFECTS[name], TIME, -6.0 * SWING)
    assert run.unsolved_steps == 0
    assert run.input_tension.min() == 0.0
    assert run.output_tension.min() >= 0.0


STRIBECK = {"stribeck_friction": 0.1, "stribeck_velocity": 2e-3}
LINE = np.linspace(0.0, 1.0, 501)  # [s]


@pytest.mark.parametrize(
    ("make", "effects", "speed", "exponent", "within"),
    [
        *(
            (chain, {"direction_asymmetry": a}, way * 2e-3, way * EXPONENT * (1.0 + way * a), 1e-3)
            for a in (-0.4, 0.3)
            for way in (1.0, -1.0)
        ),
        (chain, {"extra_bend": 0.5}, 2e-3, 0.15 * (np.pi + 0.5), 1e-3),
        (chain, {"extra_bend": -4.0}, 2e-3, 0.0, 1e-3),  # a bend below zero is none
        (stiff, {"friction_drift": 0.2}, 2e-3, EXPONENT * (1.0 + 0.2 * LINE), 1e-3),
        (stiff, {"friction_gradient": 150.0}, 2e-3, EXPONENT * (1.0 + 0.3 * LINE), 2e-3),
        *(
            (stiff, STRIBECK, v, (0.15 + 0.1 * math.exp(-v / 2e-3)) * np.pi, 2e-3)
            for v in (1e-3, 3e-3)
        ),
    ],
)
def test_a_tendon_that_is_drawn_has_the_exponent_of_its_effect(
    make, effects, speed, exponent, within
):
    time, xi = ramp(speed)
    run = simulate_effects(make(), Effects(**effects), time, xi)
    late = time > (0.5 if np.ndim(exponent) else 0.999)
    expected = np.broadcast_to(exponent, time.shape)[late]
    assert log_ratio(run)[late] == pytest.approx(expected, abs=within)


def test_velocity_weakening_starts_with_the_friction_at_rest_and_forgets_it_in_20_ms():
    time, xi = ramp(10e-3, seconds=0.2)
    effects = Effects(stribeck_friction=0.1, stribeck_velocity=1e-3)
    run = simulate_effects(stiff(), effects, time, xi)
    assert log_ratio(run).max() == pytest.approx(0.25 * np.pi, rel=0.15)
    assert log_ratio(run)[-1] == pytest.approx(0.15 * np.pi, abs=2e-3)


@pytest.mark.parametrize(
    ("effects", "speed", "difference"),
    [
        ({"constant_friction": 3.0}, 2e-3, 3.0),
        *(({"viscous_friction": 80.0}, speed, 80.0 * speed) for speed in (1e-3, 2e-3)),
    ],
)
def test_constant_and_viscous_friction_are_a_difference_of_tensions(effects, speed, difference):
    time, xi = ramp(speed)
    run = simulate_effects(stiff(static_friction=0.0), Effects(**effects), time, xi)
    left = run.input_tension[-1] - run.output_tension[-1]
    assert left == pytest.approx(difference, rel=3e-4 if "constant_friction" in effects else 2e-3)


def test_friction_along_the_turn_is_met_to_second_order():
    time, xi = ramp(2e-3)
    drop = 4.0 / EXPONENT * math.expm1(EXPONENT)  # dT = (μT + F_c/φ) dθ from T_out on
    errors = []
    for n in (8, 16):
        run = simulate_effects(chain(n), Effects(constant_friction=4.0), time, xi)
        expected = run.output_tension[-1] * math.exp(EXPONENT) + drop
        errors.append(run.input_tension[-1] - expected)
    assert errors[1] / errors[0] == pytest.approx(0.25, abs=0.02)


def test_backlash_is_the_play_operator_before_the_drum():
    width, drum, wound = 3e-4, 0.0, []
    for xi in SWING:
        drum = min(max(drum, xi - 0.5 * width), xi + 0.5 * width)
        wound.append(drum)
    loose = simulate_effects(chain(), Effects(backlash=width), TIME, SWING)
    tight = simulate_effects(chain(), Effects(), TIME, wound)
    error = np.sqrt(np.mean((loose.output_tension - tight.output_tension) ** 2))
    assert error < 1e-3 * np.ptp(tight.output_tension)
    within = simulate_effects(chain(), Effects(backlash=2.1e-3), TIME, SWING)
    assert np.ptp(within.input_tension) == pytest.approx(0.0, abs=1e-9)


def test_stiffening_is_the_quadratic_law_at_finite_strain():
    time, xi = ramp(2e-3)
    fixed = chain(static_friction=0.0, environment_stiffness=math.inf, sensor_stiffness=math.inf)
    kappa, ea = 200.0, 2e4
    run = simulate_effects(fixed, Effects(stiffening=kappa, axial_stiffness=ea), time, xi)
    strain = (math.sqrt(1.0 + 4.0 * kappa * 20.0 / ea) - 1.0) / (2.0 * kappa)
    now = 0.5 / (0.5 - xi) * (1.0 + strain) - 1.0
    assert run.output_tension == pytest.approx(ea * now * (1.0 + kappa * now), rel=1e-4)


def test_creep_relaxes_a_held_tendon_by_its_share_in_its_time():
    chi, seconds = 0.5, 0.4
    fixed = chain(static_friction=0.0, environment_stiffness=math.inf, sensor_stiffness=math.inf)
    time = np.linspace(0.0, 2.0, 2001)
    xi = 1e-3 * np.minimum(time / 0.002, 1.0)
    run = simulate_effects(fixed, Effects(creep=chi, creep_time=seconds), time, xi)
    rise = 4e4 * 1e-3
    slow = rise / (1.0 + chi)
    expected = 20.0 + slow + (rise - slow) * np.exp(-(1.0 + chi) * (time - 0.001) / seconds)
    later = time > 0.01
    assert run.output_tension[later] == pytest.approx(expected[later], abs=2e-3 * rise)


def test_sheath_compliance_is_a_softer_spring_at_the_input():
    base = chain()
    soft = dataclasses.replace(base, input_stiffness=1.0 / (1.0 / base.input_stiffness + 2e-5))
    mine = simulate_effects(base, Effects(sheath_compliance=2e-5), TIME, SWING)
    other = simulate_effects(soft, Effects(), TIME, SWING)
    assert mine.input_tension == pytest.approx(other.input_tension, abs=1e-6)
    assert mine.output_tension == pytest.approx(other.output_tension, abs=1e-6)


def test_tendon_mass_takes_mass_times_acceleration():
    time = np.linspace(0.0, 0.1, 10001)  # a corner a step: piecewise lines would hammer
    smooth = stiff(static_friction=0.0)
    effects = Effects(tendon_mass=0.5, retardation_time=1e-3)
    run = simulate_effects(smooth, effects, time, 0.5 * time**2, time_step=1e-5)
    difference = (run.input_tension - run.output_tension)[5000:]
    assert difference.mean() == pytest.approx(0.501, rel=0.01)


def test_massless_carriages_are_springs_in_series():
    free = (
        Carriage(mass=0.0, stiffness=4e4, damping=0.0),
        Carriage(mass=0.0, stiffness=1e4, damping=0.0),
    )
    springs = simulate_effects(chain(), Effects(axial_stiffness=2e4), TIME, SWING)
    carried = simulate_effects(chain(), Effects(axial_stiffness=2e4), TIME, SWING, carriages=free)
    assert carried.output_tension == pytest.approx(springs.output_tension, abs=1e-6)
    assert carried.output_displacement == pytest.approx(springs.output_displacement, abs=1e-9)


def test_a_tendon_mounted_too_tight_settles_between_its_pretension_and_the_preload():
    time = np.linspace(0.0, 1.0, 501)
    smooth = chain(static_friction=0.0)
    run = simulate_effects(smooth, Effects(), time, 0.0, carriages=CARRIAGES, preload=14.0)
    tendon, output = 4e4, 8e3  # stiffness of each [N/m]
    expected = 20.0 - 6.0 * tendon / (tendon + output)
    assert run.output_tension[-1] == pytest.approx(expected, rel=1e-4)


def test_carriages_answer_with_their_mechanical_impedance():
    omega = 2.0 * np.pi * 8.0
    time = np.linspace(0.0, 2.0, 4001)
    smooth = chain(static_friction=0.0)
    run = simulate_effects(
        smooth, Effects(), time, 1e-4 * np.sin(omega * time), carriages=CARRIAGES
    )
    inner, outer = (c.stiffness + 1j * omega * c.damping for c in CARRIAGES)
    behind = outer - omega**2
    output = inner * behind / (inner + behind) - omega**2
    whole = 1.0 / (1.0 / output + 0.5 / 2e4)
    expected = 20.0 + np.imag(1e-4 * whole * np.exp(1j * omega * time))
    steady = time > 1.0
    assert run.output_tension[steady] == pytest.approx(
        expected[steady], abs=0.01 * abs(whole) * 1e-4
    )
