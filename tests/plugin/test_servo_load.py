"""A torque beside the servo's on its motor weighs what it is, however large h G_v/J."""

import mujoco
import numpy as np
import pytest

from tests.plugin.rigs import INERTIA, RADIUS, hand, respond

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


@pytest.mark.parametrize("source", SOURCES, ids=lambda s: s.__name__)
def test_at_rest_the_tension_gives_way_by_the_torque_over_its_gain(source):
    tension = run(source, TIMESTEP, 2.0, motor_inertia=INERTIA)[-1, 1]
    # G_t r (T_r − T) + M = 0
    assert tension == pytest.approx(REFERENCE + EXTRA / (GAIN * RADIUS), rel=2e-4)


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


def test_the_speed_stays_within_its_limit_whoever_turns_the_motor():
    seen = run(applied, 0.0005, 0.2, speed_limit=0.4)
    assert np.abs(seen[:, 4]).max() == pytest.approx(0.4, rel=1e-6)
