"""Friction and stiffness by name, live in the data of a simulation."""

import mujoco
import numpy as np
import pytest

from tendon_mj import Parameters, add_friction
from tendon_mj.errors import InvalidValueError, UnknownKeyError, UnknownNameError, UnusedKeyError
from tendon_mj.plugin import PARAMETERS, sheaths
from tendon_mj.plugin.compiled_checks import OF_A_DRUM
from tests.refusals import refusing
from tests.rigs import arm, fixed_sheaths, pulled_xml, run, started

MU = "sheath.friction"


def test_names_and_values_are_those_of_the_model():
    model = arm(friction=0.2, static_friction=0.25, spools=True)
    parameters = Parameters(model, mujoco.MjData(model))
    of_drawn = [name for name in PARAMETERS if name not in OF_A_DRUM]
    assert list(parameters) == [f"sheath.{name}" for name in of_drawn]
    assert len(parameters) == len(of_drawn)
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


def test_the_tail_of_a_state_vector_will_do():
    model = arm()
    data = run(model, started(model, 1), 50)
    state = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_PLUGIN))
    mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_PLUGIN)
    parameters = Parameters(model, state)
    assert dict(parameters) == dict(Parameters(model, data))
    parameters["sheath.static_friction"] = 0.6
    parameters[MU] = 0.5
    assert Parameters(model, data)[MU] == 0.2  # every data has its own
    mujoco.mj_setState(model, data, state, mujoco.mjtState.mjSTATE_PLUGIN)
    assert Parameters(model, data)[MU] == 0.5


OUT_OF_RANGE = [
    (name, value)
    for name, parameter in PARAMETERS.items()
    for value in (-1.0, np.nan, np.inf)
    if not (value == -1.0 and parameter.range.admits(value))  # a spool may wind the other way
]


@pytest.mark.parametrize(
    ("name", "value"), [*OUT_OF_RANGE, *(("friction", value) for value in ("0.1 N", None, [0.1]))]
)
def test_a_value_that_is_none_or_out_of_range_is_refused_and_changes_nothing(name, value):
    model = arm(spools=True)
    data = mujoco.MjData(model)
    parameters = Parameters(model, data)
    before = data.plugin_state.copy()
    with refusing(InvalidValueError, f"sheath.{name}"):
        parameters[f"sheath.{name}"] = value
    np.testing.assert_array_equal(data.plugin_state, before)


def test_an_unknown_name_comes_with_the_nearest():
    parameters = Parameters(arm(), mujoco.MjData(arm()))
    with refusing(UnknownNameError, "'sheath.fricton'; did you mean 'sheath.friction'"):
        parameters["sheath.fricton"] = 0.1
    for name in ("nothing", 3, None):
        with refusing(UnknownNameError, "unknown parameter", "there are: 'sheath."):
            parameters[name]
    with refusing(InvalidValueError, "cannot be removed"):
        del parameters[MU]


def test_what_would_round_a_change_or_is_no_state_of_the_model_is_refused():
    """What is set in such a state would be lost, since it is bound anew when it is stepped."""
    model = arm()
    size = model.npluginstate
    for data in (np.zeros(size, np.float32), [0.0] * size, None):
        with refusing(InvalidValueError, "MjData", "float64"):
            Parameters(model, data)
    for garbage in (0.0, np.nan, 1e300):
        with refusing(InvalidValueError, "sheath"):
            Parameters(model, np.full(size, garbage))
    fixed = mujoco.MjData(model).plugin_state.copy()
    fixed.setflags(write=False)
    with refusing(InvalidValueError, "read-only"):
        Parameters(model, fixed)[MU] = 0.1


def test_a_sheath_goes_by_its_tendon_too():
    model = add_friction(mujoco.MjSpec.from_string(pulled_xml()), "t", friction=0.1).compile()
    parameters = Parameters(model, mujoco.MjData(model))
    assert list(sheaths(model)) == ["t_sheath"]
    parameters["t.friction"] = 0.3
    assert parameters["t_sheath.friction"] == parameters["t.friction"] == 0.3
    assert "t.friction" not in list(parameters), "one entry each"
    with refusing(UnusedKeyError, "t.pretension"):
        parameters["t.pretension"] = 1.0
    with refusing(UnknownKeyError, "'t.fricton'"):
        parameters["t.fricton"] = 0.1
