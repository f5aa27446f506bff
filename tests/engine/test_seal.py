"""The seal of a state: whole as long as the state is bound to its model, broken by any change."""

import mujoco
import numpy as np
import pytest

from tendon_mj.abi.layout import read_layout
from tendon_mj.engine import sheaths
from tendon_mj.engine.sheath_plugin.binding.seal import model_signature
from tendon_mj.engine.sheath_plugin.state import BOUND_BEGIN, BOUND_SIZE, view
from tests.engine.foreign_states import DRIVEN, MODELS, driven

LAYOUT = read_layout()
BOUND = slice(BOUND_BEGIN // 8, (BOUND_BEGIN + BOUND_SIZE) // 8)


def signature(model):
    return model_signature(LAYOUT, model._address)


def stepped(model, steps=3):
    data = mujoco.MjData(model)
    data.qvel[:] = 0.1
    for _ in range(steps):
        mujoco.mj_step(model, data)
    return data


@pytest.mark.parametrize("kind", MODELS)
def test_one_sheath_signs_for_all_and_each_is_sealed(kind):
    model = MODELS[kind]()
    data = stepped(model)
    states = [view(data.plugin_state, found.state).state for found in sheaths(model).values()]
    assert {state.first_sheath for state in states} == {min(s.first_sheath for s in states)}
    assert all(state.seal > 0.0 for state in states)
    assert [state.model_signature for state in states if state.model_signature] == [
        signature(model)
    ]


@pytest.mark.parametrize("word", range(BOUND.stop - BOUND.start))
def test_a_word_that_binds_and_is_not_as_it_was_is_set_right(word):
    model = driven()
    whole, broken = stepped(model), stepped(model)
    starts = [found.state for found in sheaths(model).values()]
    for start in starts:
        broken.plugin_state[start + BOUND.start + word] += 1.0
    for data in (whole, broken):
        mujoco.mj_step(model, data)
    for start in starts:
        words = slice(start + BOUND.start, start + BOUND.stop)
        np.testing.assert_array_equal(broken.plugin_state[words], whole.plugin_state[words])


def test_equal_models_have_equal_signatures():
    assert signature(driven()) == signature(driven())


@pytest.mark.parametrize(
    "array",
    [
        *("actuator_trntype", "actuator_trnid", "actuator_plugin", "sensor_plugin", "sensor_dim"),
        *("plugin", "plugin_attradr", "plugin_statenum", "plugin_stateadr"),
        *("tendon_adr", "tendon_num", "wrap_type"),
    ],
)
def test_a_change_of_what_binds_changes_the_signature(array):
    model = driven()
    before = signature(model)
    for k in range(getattr(model, array).size):
        getattr(model, array).flat[k] += 1
        assert signature(model) != before
        getattr(model, array).flat[k] -= 1
    assert signature(model) == before


@pytest.mark.parametrize(
    "change", [("wrapped", "twisted"), ("elbow", "wrist"), ('"pull"', '"push"')]
)
def test_names_are_part_of_the_signature(change):
    renamed = mujoco.MjModel.from_xml_string(DRIVEN.replace(*change))
    assert signature(renamed) != signature(mujoco.MjModel.from_xml_string(DRIVEN))


def test_that_a_spring_comes_or_goes_is_part_of_the_signature_and_how_stiff_it_is_is_not():
    model = driven()
    before = signature(model)
    model.tendon_stiffness[1] *= 2.0
    assert signature(model) == before
    model.tendon_stiffness[1] = 0.0
    assert signature(model) != before


def test_parameters_are_part_of_the_signature():
    spec = mujoco.MjSpec.from_string(DRIVEN)
    plain = signature(spec.compile())
    assert plain != signature(driven())
