"""Laws of the servo: J_m θ̈ + G_v θ̇ = G_t r (T_r − T_out), and its documented additions."""

import mujoco
import numpy as np
import pytest

from tendon_mj import Parameters, theory
from tendon_mj.plugin import servos
from tendon_mj.plugin.force_servo_plugin.law import backlash_ahead, stiffness_ahead
from tendon_mj.plugin.force_servo_plugin.state import view
from tests.rigs import (
    INERTIA,
    RADIUS,
    SERVO_PRETENSION,
    SPRING,
    hand,
    respond,
    servo_model,
    servo_stiffness,
)


def damping_gain(zeta, gain=7.0):
    return zeta * 2.0 * RADIUS * np.sqrt(INERTIA * servo_stiffness() * gain)


@pytest.mark.parametrize("zeta", [0.2, 0.5, 0.9])
@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "RK4"])
def test_without_friction_it_is_the_second_order_system_of_the_paper(zeta, integrator):
    m = servo_model(
        velocity_gain=damping_gain(zeta), timestep=1e-4, integrator=integrator, mass=0.002
    )
    seen = respond(m, np.full(12000, 30.0))
    omega = RADIUS * np.sqrt(servo_stiffness() * 7.0 / INERTIA)
    t, turn = seen[:, 0], omega * np.sqrt(1.0 - zeta**2)
    decay = np.exp(-zeta * omega * t)
    ideal = 30.0 - 10.0 * decay * (np.cos(turn * t) + zeta * omega / turn * np.sin(turn * t))
    # the load's mass, the tendon's travel and finite strain are what is left
    assert np.abs(seen[:, 1] - ideal).max() < 0.15


@pytest.mark.parametrize("radius", [RADIUS, -RADIUS])
def test_a_negative_radius_turns_the_motor_the_other_way_and_the_control_has_its_range(radius):
    model = servo_model(friction=0.3, radius=radius)
    model.actuator_ctrllimited[0], model.actuator_ctrlrange[0] = 1, (0.0, 40.0)
    seen = respond(model, np.full(4000, 80.0))
    assert seen[-1, 1] == pytest.approx(40.0, abs=0.1)
    assert np.sign(seen[-1, 3]) == np.sign(radius)


def on_spool(tension):
    """Torque of the tendon on its spool [N m]."""
    return RADIUS * tension * (1.0 + tension / 20e3) / (1.0 + SERVO_PRETENSION / 10e3)


def test_without_clampctrl_the_control_has_no_range():
    model, references = servo_model(friction=0.3), np.full(400, 80.0)
    wanted = respond(model, references)
    model.actuator_ctrllimited[0], model.actuator_ctrlrange[0] = 1, (0.0, 40.0)
    assert respond(model, references)[-1, 1] < wanted[-1, 1]
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CLAMPCTRL.value
    np.testing.assert_array_equal(respond(model, references), wanted)


def test_the_gear_holds_what_the_tendon_pulls():
    seen = respond(servo_model(friction=0.2), np.full(100, SERVO_PRETENSION))
    assert np.abs(seen[:, 4]).max() < 1e-12
    slipping = respond(servo_model(friction=0.2, backdrive=True), np.full(100, SERVO_PRETENSION))
    assert slipping[-1, 3] < 0.0  # the tendon turns a motor that it can turn back


def test_a_backdriven_motor_rests_where_the_tendon_holds_it():
    seen = respond(servo_model(backdrive=True), np.full(20000, 40.0))
    # G_t r (T_r − T) = r T (1 + T/2EA)/(1 + ε_0)
    tension = seen[-1, 1]
    assert 7.0 * RADIUS * (40.0 - tension) == pytest.approx(on_spool(tension), rel=1e-3)


def test_the_torque_stays_within_its_limit():
    m = servo_model(torque_limit=0.05, velocity_gain=0.2)
    seen = respond(m, np.full(2000, 60.0))
    spool = on_spool(seen[:, 2])
    torque = seen[:, 5] - spool
    assert np.abs(torque).max() == pytest.approx(0.05, rel=1e-9)


def test_a_delay_is_felt_after_itself_and_not_before():
    plain = respond(servo_model(delay=0.0, period=0.0005), np.full(400, 40.0))
    late = respond(servo_model(delay=0.02), np.full(440, 40.0))
    assert not late[:39, 4].any()
    spool = on_spool(late[0, 2])
    np.testing.assert_allclose(late[:40, 5], spool, rtol=1e-12)
    assert late[40, 4] == pytest.approx(plain[0, 4], rel=1e-9)
    gain = damping_gain(0.5)  # of which a delay takes away
    peaks = [
        respond(servo_model(velocity_gain=gain, delay=d), np.full(4000, 40.0))[:, 1].max()
        for d in (0.0, 0.01, 0.02)
    ]
    assert peaks[0] < peaks[1] < peaks[2]


def test_a_sampled_torque_holds_for_its_period():
    seen = respond(servo_model(period=0.004), np.full(400, 40.0))
    spool = on_spool(seen[:, 2])
    torque = (seen[:, 5] - spool).reshape(-1, 8)
    np.testing.assert_allclose(torque, torque[:, :1].repeat(8, 1), rtol=0, atol=1e-12)
    assert np.abs(np.diff(torque[:, 0])).min() > 0.0


def test_loosening_has_gains_of_its_own():
    up = np.full(2000, 40.0)
    plain, changed = (
        respond(servo_model(**values), np.r_[up, np.full(1000, 25.0)])
        for values in ({}, {"loosening_tension_gain": 14.0, "loosening_velocity_gain": 0.7})
    )
    assert np.abs(plain[:, 1] - changed[:, 1])[:1500].max() < 1e-3
    assert changed[2050, 1] < plain[2050, 1] - 1.0


def test_the_observer_sees_what_the_sensor_sees_or_is_off_by_the_wrong_friction():
    wrong = servo_model(friction=0.4, feedback="observer", observer_friction=0.5)
    off = respond(wrong, np.full(8000, 40.0))[-1, 1] / 40.0
    assert off == pytest.approx(np.exp((0.5 - 0.4) * 2.0), rel=1e-3)
    m = servo_model(friction=0.4)
    data = mujoco.MjData(m)
    worst = 0.0
    for k in range(8000):
        data.ctrl[0] = 35.0 + 12.0 * np.sin(2e-3 * k)
        mujoco.mj_step(m, data)
        seen = data.sensor("output_tension").data[0]
        estimate = view(data.plugin_state, servos(m)["servo"]).trial.estimate
        worst = max(worst, abs(estimate / seen - 1.0))
    assert worst < 1e-4  # the load has a mass, which drives the output end a little, too


def test_feedforward_changes_nothing_before_the_reference_moves():
    calls = [
        respond(
            servo_model(friction=0.4, backlash_feedforward=g, rate_feedforward=g),
            np.full(500, 30.0),
        )
        for g in (0.0, 1.0)
    ]
    np.testing.assert_array_equal(*calls)


def test_feedforward_crosses_the_backlash_sooner_and_without_overshoot():
    reference = np.r_[np.linspace(20.0, 50.0, 4000), np.full(2000, 50.0), np.full(3000, 40.0)]
    gain = damping_gain(1.6)
    plain, crossed = (
        respond(
            servo_model(
                friction=0.5, velocity_gain=gain, backlash_feedforward=g, output_stiffness=SPRING
            ),
            reference,
        )[6000:, 1]
        for g in (0.0, 1.0)
    )
    assert np.argmax(crossed < 49.0) < 0.7 * np.argmax(plain < 49.0)
    assert crossed.min() > 40.0 - 0.05


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_backlash_ahead_shrinks_from_the_whole_reversal_to_nothing(sense):
    exponent, tendon, out = 1.2, 4e4, 30.0
    gap = float(theory.reversal_backlash(exponent, out, 20e3, 0.5))
    ratios = np.exp(sense * np.linspace(-exponent, exponent, 41))
    left = [sense * backlash_ahead(exponent, sense, tendon, out * r, out) for r in ratios]
    assert left[0] == pytest.approx(gap, rel=1e-12)
    assert left[-1] == pytest.approx(0.0, abs=1e-18)
    assert np.all(np.diff(left) < 0.0)


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("exponent", [0.0, 1e-9, 0.5, 2.0])
def test_stiffness_ahead_is_that_of_the_closed_form(sense, exponent):
    expected = theory.transmission_stiffness(sense * exponent, 20e3, 0.5, 8e3)
    assert stiffness_ahead(exponent, sense, 4e4, 8e3) == pytest.approx(expected, rel=1e-8)
    held = theory.apparent_stiffness(sense * exponent, 20e3, 0.5)
    assert stiffness_ahead(exponent, sense, 4e4, 0.0) == pytest.approx(held, rel=1e-8)


def test_gains_are_live():
    m, other = (
        servo_model(tension_gain=7.0),
        servo_model(tension_gain=9.0, loosening_tension_gain=7.0),
    )
    data = mujoco.MjData(m)
    Parameters(m, data)["servo.tension_gain"] = 9.0
    reference = np.full(500, 40.0)
    np.testing.assert_array_equal(respond(m, reference, data), respond(other, reference))
    assert "servo.delay" not in Parameters(m, data)


GAIN, DAMPING, REFERENCE, EXTRA = 140.0, 20.0, 40.0, 0.5
TIMESTEP = 0.002  # h G_v/J = 2


def applied(spec):
    return lambda data: data.qfrc_applied.__setitem__(-1, EXTRA)


def spring(spec):
    """Far from where it rests, so as good as constant."""
    joint = spec.joint("motor")
    joint.stiffness[0], joint.springref = 1e-3, np.degrees(EXTRA / 1e-3)


def gravity(spec):
    spec.option.gravity = [0.0, -9.81, 0.0]
    arm = spec.body("motor")
    arm.explicitinertial, arm.mass, arm.inertia = True, 1.0, [1e-6, 1e-6, 1e-6]
    arm.ipos = [-EXTRA / 9.81, 0.0, 0.0]
    spec.joint("motor").armature = INERTIA - (EXTRA / 9.81) ** 2  # all in all still J


def second_motor(spec):
    motor = spec.add_actuator(
        name="second", trntype=mujoco.mjtTrn.mjTRN_JOINT, target="motor", gear=[2.0] + 5 * [0.0]
    )
    motor.set_to_motor()
    motor.forcelimited, motor.forcerange = True, [-0.5 * EXTRA, 0.5 * EXTRA]
    return lambda data: data.ctrl.__setitem__(-1, 9.0)  # beyond its range of forces


SOURCES = [applied, spring, gravity, second_motor]


def run(source, timestep, duration, **servo):
    spec = hand(timestep=timestep, tension_gain=GAIN, velocity_gain=DAMPING, **servo)
    act = source(spec) if source else None
    model = spec.compile()
    data = mujoco.MjData(model)
    if act:
        act(data)
    return respond(model, np.full(round(duration / timestep), REFERENCE), data)


@pytest.mark.filterwarnings("ignore:add_friction. tendon .tendon.. an axial stiffness")
@pytest.mark.parametrize("source", SOURCES, ids=lambda s: s.__name__)
def test_at_rest_the_tension_gives_way_by_the_torque_over_its_gain(source):
    tension = run(source, TIMESTEP, 2.0, motor_inertia=INERTIA)[-1, 1]
    # G_t r (T_r − T) + M = 0
    assert tension == pytest.approx(REFERENCE + EXTRA / (GAIN * RADIUS), rel=2e-4)


@pytest.mark.filterwarnings("ignore:add_friction. tendon .tendon.. an axial stiffness")
@pytest.mark.parametrize("backdrive", [False, True])
def test_on_the_way_it_costs_no_accuracy(backdrive):
    """The error of a step of this size is the same with another torque and without."""
    errors = {}
    for source in (None, applied):
        coarse, fine = (
            run(source, h, 0.1, backdrive=backdrive) for h in (TIMESTEP, TIMESTEP / 100.0)
        )
        errors[source] = np.abs(coarse[:, 1] - fine[::100, 1]).max()
    assert errors[applied] == pytest.approx(errors[None], rel=0.1)


@pytest.mark.parametrize("source", [None, applied])
@pytest.mark.parametrize("backdrive", [False, True])
def test_the_speed_stays_within_its_limit_whoever_turns_the_motor(source, backdrive):
    seen = run(source, 0.0005, 0.2, speed_limit=0.4, backdrive=backdrive)
    assert np.abs(seen[:, 4]).max() == pytest.approx(0.4, rel=1e-6)
