"""A control that is set after passive forces were computed meets friction in the same step."""

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction, view_sheath
from tests.rigs import GIVEN, driven, driven_xml, sheathed, started

EPS = 2.0**-20  # of which sums with controls are exact
ACTUATORS = {
    "motor": '<motor name="pull" tendon="wrapped" gear="-1"/>',
    "clamped": '<motor name="pull" tendon="wrapped" gear="-1" forcerange="0 3"/>',
    "filtered": '<general name="pull" tendon="wrapped" dyntype="filter" dynprm=".1" gainprm="-5"/>',
    "position": '<position name="pull" tendon="wrapped" kp="300" kv="5"/>',
    "muscle": '<muscle name="pull" tendon="wrapped" range=".7 1.1" force="40"/>',
}


def driven_by(actuator):
    spec = mujoco.MjSpec.from_string(driven_xml(actuators=ACTUATORS[actuator]))
    return add_friction(spec, "*", friction=0.2, arc_guides=2).compile()


def in_motion(model, steps=40):
    """Data in the middle of a motion, with a control that pulls."""
    data = started(model, 3)
    for k in range(steps):
        data.ctrl[:] = 0.6 + 0.3 * np.sin(0.1 * k)
        mujoco.mj_step(model, data)
    return data


def full(model, data):
    state = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    return state


@pytest.mark.parametrize("copied", [False, True])
@pytest.mark.parametrize("actuator", ACTUATORS)
def test_a_control_between_the_halves_of_a_step_is_as_one_before_it(actuator, copied):
    model = driven_by(actuator)
    whole, halves = in_motion(model), in_motion(model)
    for control in (0.5, 4.0, 0.0, 2.0):
        whole.ctrl[:] = control
        mujoco.mj_step(model, whole)
        mujoco.mj_step1(model, halves)
        if copied:
            half, halves = halves, mujoco.MjData(model)
            mujoco.mj_copyData(halves, model, half)
        halves.ctrl[:] = control
        mujoco.mj_step2(model, halves)
        np.testing.assert_array_equal(full(model, halves), full(model, whole))


@pytest.mark.parametrize("actuator", ACTUATORS)
def test_a_look_without_actuation_before_the_second_half_leaves_no_trace(actuator):
    """As `Physics.copy` of dm_control does."""
    model = driven_by(actuator)
    whole, halves = in_motion(model), in_motion(model)
    for _ in range(3):
        mujoco.mj_step(model, whole)
        off = mujoco.mjtDisableBit.mjDSBL_ACTUATION
        model.opt.disableflags |= off
        mujoco.mj_forward(model, halves)
        model.opt.disableflags &= ~int(off)
        mujoco.mj_step1(model, halves)
        mujoco.mj_step2(model, halves)
        np.testing.assert_array_equal(full(model, halves), full(model, whole))


def test_the_force_that_acts_is_the_one_that_rubs_where_a_callback_draws_it_at_random():
    model = driven_by("motor")
    model.actuator_gaintype[:] = mujoco.mjtGain.mjGAIN_USER
    data, rng = mujoco.MjData(model), np.random.default_rng(0)
    mujoco.set_mjcb_act_gain(lambda m, d, i: 10.0 + rng.normal())
    try:
        data.ctrl[:] = 1.0
        for _ in range(20):
            mujoco.mj_step(model, data)
            shown = float(view_sheath(model, data, "wrapped").input_tension)
            assert shown == pytest.approx(float(data.actuator_force[0]), abs=1e-12)
    finally:
        mujoco.set_mjcb_act_gain(None)


def test_inverse_dynamics_leave_the_actuators_forces_and_see_the_friction_of_the_last_call():
    model = driven_by("motor")
    data = in_motion(model)
    data.ctrl[:] = 4.0
    mujoco.mj_forward(model, data)
    force, smooth = data.actuator_force.copy(), data.qfrc_actuator + data.qfrc_applied
    data.ctrl[:] = 9.0
    mujoco.mj_inverse(model, data)
    np.testing.assert_array_equal(data.actuator_force, force)
    np.testing.assert_allclose(data.qfrc_inverse, smooth, rtol=1e-9, atol=1e-9)


def test_a_control_of_a_callback_is_as_one_before_the_step():
    model = driven()
    whole, called = in_motion(model), in_motion(model)
    whole.ctrl[:] = 5.0
    mujoco.mj_step(model, whole)
    mujoco.set_mjcb_control(lambda m, d: d.ctrl.fill(5.0))
    try:
        mujoco.mj_step(model, called)
    finally:
        mujoco.set_mjcb_control(None)
    np.testing.assert_array_equal(full(model, called), full(model, whole))


def next_state(model, data, change):
    """Position, velocity and activation one step after a change to the data."""
    after = mujoco.MjData(model)
    mujoco.mj_copyData(after, model, data)
    change(after)
    mujoco.mj_step(model, after)
    return np.concatenate([after.qpos, after.qvel, after.act])


def check_derivatives(model, data):
    """Columns of controls and activations of `mjd_transitionFD` against whole steps."""
    n, eps = 2 * model.nv + model.na, 1e-6
    a, b = np.zeros((n, n)), np.zeros((n, model.nu))
    copy = mujoco.MjData(model)
    mujoco.mj_copyData(copy, model, data)
    mujoco.mjd_transitionFD(model, copy, eps, True, a, b, None, None)

    def column(field, k):
        ends = []
        for sign in (1.0, -1.0):

            def change(d, sign=sign):
                getattr(d, field)[k] += sign * eps

            ends.append(next_state(model, data, change))
        return (ends[0] - ends[1]) / (2.0 * eps)

    for k in range(model.nu):
        np.testing.assert_allclose(b[:, k], column("ctrl", k), rtol=1e-6, atol=1e-6)
    for k in range(model.na):
        seen = a[:, 2 * model.nv + k]
        np.testing.assert_allclose(seen, column("act", k), rtol=1e-6, atol=1e-6)


# not the muscle: with implicit integration MuJoCo's own columns leave out what varies with velocity
@pytest.mark.parametrize("actuator", [name for name in ACTUATORS if name != "muscle"])
def test_derivatives_to_controls_are_those_of_the_model_with_friction(actuator):
    model = driven_by(actuator)
    data = in_motion(model)
    data.ctrl[:] = 0.5
    check_derivatives(model, data)


def test_derivatives_do_not_depend_on_the_control_before():
    model = driven_by("motor")
    columns = []
    for before in (0.5, 0.5 + EPS, 0.5 - EPS):
        data = in_motion(model)
        data.ctrl[:] = before
        mujoco.mj_forward(model, data)
        data.ctrl[:] = 0.5
        b = np.zeros((2 * model.nv, model.nu))
        mujoco.mjd_transitionFD(model, data, EPS, True, None, b, None, None)
        columns.append(b)
    np.testing.assert_array_equal(columns[1], columns[0])
    np.testing.assert_array_equal(columns[2], columns[0])


@pytest.mark.filterwarnings("ignore:add_friction")
@pytest.mark.parametrize("name", GIVEN)
def test_derivatives_of_published_models_are_those_of_whole_steps(name):
    model = sheathed(name, friction=0.15)
    data = started(model)
    rng = np.random.default_rng(0)
    for _ in range(20):
        data.ctrl[:] = rng.uniform(*model.actuator_ctrlrange.T)
        mujoco.mj_step(model, data)
    check_derivatives(model, data)
