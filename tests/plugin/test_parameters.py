"""Friction and stiffness by name, live in the data of a simulation."""

import mujoco
import numpy as np
import pytest

from tendon_mj import Parameters
from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.plugin import PARAMETERS
from tests.refusals import refusing
from tests.rigs import arm, fixed_sheaths, restore, run, snapshot, started

MU = "sheath.friction"


def test_names_and_values_are_those_of_the_model():
    model = arm(friction=0.2, static_friction=0.25, spools=True)
    parameters = Parameters(model, mujoco.MjData(model))
    assert list(parameters) == [f"sheath.{name}" for name in PARAMETERS]
    assert len(parameters) == len(PARAMETERS)
    assert dict(parameters) == dict.fromkeys(parameters, 0.0) | {
        "sheath.axial_stiffness": 500.0,
        MU: 0.2,
        "sheath.static_friction": 0.25,
        "sheath.constant_friction": 0.0,
        "sheath.axial_damping": 0.0,
        "sheath.pretension": 8.0,
        "sheath.reel_radius": 0.02,
        "sheath.output_radius": 0.5,
    }


def test_a_change_acts_and_equals_a_model_made_with_it():
    model, other = arm(friction=0.05), arm(friction=0.4, static_friction=0.5)
    plain = run(model, started(model, 1, 2.0), 200)
    changed = started(model, 1, 2.0)
    parameters = Parameters(model, changed)
    parameters["sheath.static_friction"] = 0.5
    parameters[MU] = 0.4
    run(model, changed, 200)
    expected = run(other, started(other, 1, 2.0), 200)
    np.testing.assert_array_equal(changed.qpos, expected.qpos)
    assert not np.array_equal(changed.qpos, plain.qpos)


def test_a_change_in_the_middle_acts_from_the_next_step_on():
    law = {"guides": 4, "bend": 2.0, "friction": 0.1, "pretension": 20.0}
    model = fixed_sheaths([law])
    data = mujoco.MjData(model)
    parameters = Parameters(model, data)
    near, far = data.sensordata[:1], data.sensordata[1:2]

    def pull(k):
        data.ctrl[0] += 1e-5

    run(model, data, 300, pull)
    assert far / near == pytest.approx(np.exp(-0.2), rel=1e-9)
    parameters["sheath0.static_friction"] = parameters["sheath0.friction"] = 0.3
    run(model, data, 300, pull)
    assert far / near == pytest.approx(np.exp(-0.6), rel=1e-9)


def test_a_reset_brings_back_what_the_model_says():
    model = arm()
    data = started(model)
    parameters = Parameters(model, data)
    before = dict(parameters)
    for name in parameters:
        parameters[name] = 0.75
    run(model, data, 5)
    mujoco.mj_resetData(model, data)
    assert dict(parameters) == before


def test_every_data_has_its_own():
    model = arm()
    one, other = started(model, 1), started(model, 1)
    Parameters(model, one)[MU] = 0.01
    assert Parameters(model, other)[MU] == 0.2
    run(model, one, 100)
    run(model, other, 100)
    untouched = run(model, started(model, 1), 100)
    np.testing.assert_array_equal(other.qpos, untouched.qpos)
    assert not np.array_equal(one.qpos, other.qpos)


def test_the_tail_of_a_state_vector_will_do():
    model = arm()
    data = run(model, started(model, 1), 50)
    state = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_PLUGIN))
    mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_PLUGIN)
    parameters = Parameters(model, state)
    assert dict(parameters) == dict(Parameters(model, data))
    parameters["sheath.static_friction"] = 0.6
    parameters[MU] = 0.5
    assert Parameters(model, data)[MU] == 0.2
    mujoco.mj_setState(model, data, state, mujoco.mjtState.mjSTATE_PLUGIN)
    assert Parameters(model, data)[MU] == 0.5


def test_parameters_are_part_of_a_saved_state():
    model = arm()
    data = started(model, 1)
    Parameters(model, data)[MU] = 0.11
    saved = snapshot(model, data)
    mujoco.mj_resetData(model, data)
    restore(model, data, saved)
    assert Parameters(model, data)[MU] == 0.11


@pytest.mark.parametrize("value", [-1.0, np.nan, np.inf])
@pytest.mark.parametrize("name", list(PARAMETERS))
def test_a_value_out_of_range_is_refused_and_changes_nothing(name, value):
    model = arm(spools=True)
    data = mujoco.MjData(model)
    parameters = Parameters(model, data)
    if value == -1.0 and PARAMETERS[name].range.admits(value):
        return  # a spool may wind the other way round, friction may fall
    before = data.plugin_state.copy()
    with pytest.raises(InvalidValueError, match=rf"sheath\.{name} = |sheath\.{name}: {name} = "):
        parameters[f"sheath.{name}"] = value
    np.testing.assert_array_equal(data.plugin_state, before)


def test_an_unknown_name_comes_with_the_nearest():
    parameters = Parameters(arm(), mujoco.MjData(arm()))
    with pytest.raises(
        UnknownNameError, match=r"'sheath\.fricton'; did you mean 'sheath\.friction'"
    ):
        parameters["sheath.fricton"] = 0.1
    with pytest.raises(UnknownNameError, match=r"there are: 'sheath\.axial_damping'"):
        parameters["nothing"]
    with pytest.raises(InvalidValueError, match="cannot be removed"):
        del parameters[MU]


@pytest.mark.parametrize("value", ["0.1 N", None, [0.1, 0.2], 1j, np.array([0.1]), 10**400])
def test_what_is_no_number_is_refused_with_the_parameter(value):
    model = arm()
    parameters = Parameters(model, mujoco.MjData(model))
    with refusing(InvalidValueError, "sheath.friction: "):
        parameters[MU] = value
    assert parameters[MU] == 0.2


@pytest.mark.parametrize("name", [3, None, ("sheath", "friction"), ["sheath.friction"]])
def test_what_is_no_name_is_unknown(name):
    model = arm()
    parameters = Parameters(model, mujoco.MjData(model))
    with pytest.raises(UnknownNameError, match="unknown parameter"):
        parameters[name]


def test_an_array_that_would_round_or_hold_no_change_is_refused():
    model = arm()
    for data in (np.zeros(model.npluginstate, np.float32), [0.0] * model.npluginstate, None):
        with refusing(InvalidValueError, "MjData", "float64"):
            Parameters(model, data)
    fixed = mujoco.MjData(model).plugin_state.copy()
    fixed.setflags(write=False)
    with pytest.raises(InvalidValueError, match="read-only"):
        Parameters(model, fixed)[MU] = 0.1


@pytest.mark.parametrize("garbage", [0.0, np.nan, 1e300])
def test_what_is_no_state_of_the_model_is_refused_as_a_view_does(garbage):
    """What is set there would be lost, since such a state is bound anew when it is stepped."""
    model = arm()
    with refusing(InvalidValueError, "sheath"):
        Parameters(model, np.full(model.npluginstate, garbage))
