"""Views of sheaths by name, in one simulation and in the states of many."""

import mujoco
import numpy as np
import pytest
from mujoco import rollout

from tendon_mj import Parameters, add_friction, add_sensor, load_model, view_sheath
from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.plugin import KINDS, PARAMETERS, sheaths
from tests.refusals import refusing
from tests.rigs import finger, simulated

SHOWN = [kind for kind in KINDS if kind != "reel_displacement"]
FULL = int(mujoco.mjtState.mjSTATE_FULLPHYSICS)


@pytest.fixture(scope="module")
def model():
    """Model with a sheath on each tendon, named like it, as are its sensors."""
    spec = finger()
    for tendon in ("extensor", "flexor"):
        name = f"{tendon}_sheath"
        add_friction(spec, tendon, friction=0.2, name=name, sensors=())
        for kind in SHOWN:
            add_sensor(spec, name, kind, name=f"{tendon}_{kind}")
    return spec.compile()


@pytest.fixture(scope="module")
def states(model):
    """States of three simulations of different speeds over forty steps."""
    data = mujoco.MjData(model)
    start = np.empty((3, mujoco.mj_stateSize(model, FULL)))
    for k in range(3):
        mujoco.mj_resetData(model, data)
        data.qvel[:] = [k, -2.0 * k]
        mujoco.mj_forward(model, data)
        mujoco.mj_getState(model, data, start[k], FULL)
    states, _ = rollout.rollout(model, [data], start, nstep=40)
    return states


@pytest.mark.parametrize("kind", SHOWN)
@pytest.mark.parametrize("tendon", ["flexor", "extensor"])
def test_a_view_shows_what_the_sensors_show(model, kind, tendon):
    data = simulated(model, 30, forward=True, qvel=[3.0, -1.0])
    shown = getattr(view_sheath(model, data, tendon), kind)
    np.testing.assert_array_equal(np.atleast_1d(shown), data.sensor(f"{tendon}_{kind}").data)


def test_a_tendon_and_its_sheath_are_the_same_view(model):
    data = simulated(model)
    by_tendon, by_sheath = (view_sheath(model, data, n) for n in ("flexor", "flexor_sheath"))
    assert (by_tendon.name, by_tendon.tendon) == (by_sheath.name, by_sheath.tendon)
    np.testing.assert_array_equal(by_tendon.tension, by_sheath.tension)
    assert by_tendon.positions.shape == (3, 3)
    np.testing.assert_array_equal(by_tendon.positions[0], data.site("d").xpos)


@pytest.mark.parametrize("part", ["full state", "plugin state"])
def test_states_of_many_read_as_each_of_them_does(model, states, part):
    given = states if part == "full state" else states[..., -model.npluginstate :]
    many = view_sheath(model, given, "flexor")
    for kind in (*SHOWN, "positions", "friction"):
        shown = getattr(many, kind)
        assert shown.shape[:2] == states.shape[:2]
        for k in np.ndindex(3, 40):
            one = view_sheath(model, given[k], "flexor")
            np.testing.assert_array_equal(shown[k], getattr(one, kind))
    assert np.ptp(many.input_tension) > 0.0


def test_a_parameter_is_live_and_its_own_in_each_simulation(model, states):
    data = mujoco.MjData(model)
    view = view_sheath(model, data, "flexor")
    view.friction = 0.5
    assert view.friction == Parameters(model, data)["flexor_sheath.friction"] == 0.5
    assert view_sheath(model, data, "extensor").friction == 0.2
    many = states.copy()
    view_sheath(model, many, "flexor").friction = np.array([[0.1], [0.2], [0.3]])
    changed = np.argwhere((many != states).any(axis=(0, 1)))
    assert len(changed) == 1
    np.testing.assert_array_equal(
        view_sheath(model, many, "flexor").friction[:, 7], [0.1, 0.2, 0.3]
    )
    assert set(PARAMETERS) <= set(dir(view))


@pytest.mark.parametrize(
    ("parameter", "value", "fact"),
    [
        *(("friction", value, "flexor_sheath.friction") for value in (-0.1, np.nan, np.inf)),
        *(("friction", value, "flexor_sheath.friction") for value in ("much", {}, 10**400)),
        ("friction", [0.1, 0.2], "(2,)"),
        ("reel_radius", 0.1, "flexor_sheath.reel_radius has no meaning"),
        ("frictoin", 0.1, "did you mean 'friction'"),
    ],
)
def test_what_cannot_be_set_is_refused_and_changes_nothing(model, parameter, value, fact):
    data = mujoco.MjData(model)
    before, view = data.plugin_state.copy(), view_sheath(model, data, "flexor")
    with refusing((InvalidValueError, UnknownNameError), fact):
        setattr(view, parameter, value)
    np.testing.assert_array_equal(data.plugin_state, before)
    assert not hasattr(view, "frictoin")


def test_other_sheaths_and_other_states_are_refused_by_name(model, states):
    fixed = states.copy()
    fixed.flags.writeable = False
    one_sheath = add_friction(finger(), "flexor", friction=0.2).compile()
    for call, fact in (
        (lambda: setattr(view_sheath(model, fixed, "flexor"), "friction", 0.1), "read-only"),
        (lambda: view_sheath(model, mujoco.MjData(model), "flexr"), "did you mean 'flexor"),
        (lambda: view_sheath(model, states[..., :-1], "flexor"), str(states[..., :-1].shape)),
        (lambda: view_sheath(one_sheath, mujoco.MjData(model), "flexor"), "do not fit this model"),
    ):
        with refusing(ValueError, fact):
            call()
    for nothing in (np.full((2, model.npluginstate), np.nan), np.zeros(model.npluginstate)):
        with refusing(InvalidValueError, "flexor_sheath"):
            _ = view_sheath(model, nothing, "flexor").tension


def test_friction_work_counts_a_step_once_whether_it_is_finished_or_not():
    model = add_friction(finger(), "flexor", friction=0.2, sensors=("friction_work",)).compile()
    data = mujoco.MjData(model)
    data.qvel[:] = [3.0, -2.0]
    view, before = view_sheath(model, data, "flexor"), 0.0
    for _ in range(50):
        mujoco.mj_step(model, data)
        finished = float(view.friction_work[0])
        assert finished == data.sensor("friction_work").data[0] >= before
        mujoco.mj_forward(model, data)
        before = float(view.friction_work[0])
        assert before == data.sensor("friction_work").data[0] >= finished
    assert before > 0.0


def test_data_that_were_never_evaluated_show_their_state():
    model = load_model("finger")
    data = mujoco.MjData(model)
    for name in sheaths(model):
        assert not view_sheath(model, data, name).tension.any()


def test_the_stiffness_that_is_chosen_reads_as_it_acts_from_the_start():
    spec = finger()
    spec.tendon("flexor").stiffness[0] = 0.0
    spec.add_actuator(name="pull", trntype=mujoco.mjtTrn.mjTRN_TENDON, target="flexor")
    elastic = {"creep": 0.1, "creep_time": 1.0}
    add_friction(spec, "flexor", friction=0.2, name="sheath", **elastic)
    model = spec.compile()
    data = mujoco.MjData(model)
    parameters, name = Parameters(model, data), "sheath.axial_stiffness"
    before = dict(parameters)
    assert view_sheath(model, data, "sheath").axial_stiffness == before[name]
    parameters.update(before)
    mujoco.mj_forward(model, data)
    assert dict(parameters) == before
    mujoco.mj_resetData(model, data)
    mujoco.mj_forward(model, data)
    assert data.plugin_state[list(PARAMETERS).index("axial_stiffness")] == before[name]
