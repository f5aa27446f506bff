"""The seal of a state: whole as long as the state is bound to its model, broken by any change."""

import copy
import itertools

import mujoco
import numpy as np
import pytest

from tendon_mj import view_sheath
from tendon_mj.plugin import read_layout, sheaths
from tendon_mj.plugin.sheath_plugin.signature import model_signature
from tendon_mj.plugin.sheath_plugin.state import BOUND_BEGIN, BOUND_SIZE, view
from tests.plugin.rigs import DRIVEN, MODELS, driven

LAYOUT = read_layout()
TWINS = """
<mujoco>
  <extension><plugin plugin="tendon_mj.sheath">
    <instance name="s1"><config key="tendon" value="one"/><config key="friction" value="0.2"/>
    </instance>
    <instance name="s2"><config key="tendon" value="two"/><config key="friction" value="0.2"/>
    </instance>
  </plugin></extension>
  <worldbody>
    <site name="a" pos="-.1 0 .03"/><site name="b" pos="0 0 .05"/>
    <body><joint name="j1" axis="0 1 0"/><geom size=".01" pos=".1 0 0"/>
      <site name="c" pos=".1 0 .02"/></body>
    <body pos="0 1 0"><joint name="j2" axis="0 1 0"/><geom size=".01" pos=".1 0 0"/>
      <site name="d" pos=".1 0 .02"/></body>
  </worldbody>
  <tendon>
    <spatial name="one"><site site="a"/><site site="b"/><site site="c"/></spatial>
    <spatial name="two"><site site="a"/><site site="b"/><site site="d"/></spatial>
  </tendon>
  <actuator><motor tendon="one"/><motor tendon="two"/></actuator>
  <sensor><plugin plugin="tendon_mj.sheath" instance="s1"/>
    <plugin plugin="tendon_mj.sheath" instance="s2"/></sensor>
</mujoco>
"""
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


def stepped_after(model, data, change):
    """Whether a step after a change of the state leaves the words that bind as they were."""
    starts = [found.state for found in sheaths(model).values()]
    bound = [data.plugin_state[start:][BOUND].copy() for start in starts]
    mujoco.mj_step1(model, data)
    change(data.plugin_state, starts)
    mujoco.mj_step2(model, data)  # what is not the model's is neither shown nor advanced
    mujoco.mj_step(model, data)
    found = [data.plugin_state[start:][BOUND] for start in starts]
    return all(np.array_equal(*both) for both in zip(found, bound, strict=True))


@pytest.mark.parametrize("word", range(BOUND.stop - BOUND.start))
def test_a_word_that_binds_and_is_not_as_it_was_is_set_right(word):
    model = driven()
    data = stepped(model)

    def change(state, starts):
        for start in starts:
            state[start + BOUND.start + word] += 1.0

    assert stepped_after(model, data, change)


@pytest.mark.parametrize("factor", [-1.0, 1e100])
def test_so_are_two_words_that_change_at_once(factor):
    model = driven()
    whole = stepped(model)
    words = range(BOUND.start, BOUND.stop)
    for one, other in itertools.combinations(words, 2):
        data = copy.copy(whole)

        def change(state, starts, one=one, other=other):
            for start in starts:
                state[start + np.array([one, other])] *= factor

        assert stepped_after(model, data, change), (one, other)


def test_the_state_of_another_sheath_is_not_one_s_own():
    model = mujoco.MjModel.from_xml_string(TWINS)
    data = mujoco.MjData(model)
    data.ctrl[:] = (-1.0, -2.0)
    mujoco.mj_step(model, data)
    first, second = (found.state for found in sheaths(model).values())
    size = model.plugin_statenum[0]

    def change(state, starts):
        state[second : second + size] = state[first : first + size]

    assert stepped_after(model, data, change)
    assert [view_sheath(model, data, name).input_tension for name in ("one", "two")] == [1.0, 2.0]


def test_who_has_actuators_computed_is_known_when_a_spring_goes():
    model = mujoco.MjModel.from_xml_string(
        TWINS.replace('name="one"', 'name="one" stiffness="5" springlength="0 0.01"').replace(
            '<motor tendon="one"/>', '<motor joint="j1"/>'
        )
    )
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    model.tendon_stiffness[0] = 0.0
    for force in (2.0, 3.0):
        data.ctrl[1] = -force
        mujoco.mj_step(model, data)
        assert view_sheath(model, data, "two").input_tension == force


def test_equal_models_have_equal_signatures():
    assert signature(driven()) == signature(driven())


@pytest.mark.parametrize(
    "array",
    [
        *("actuator_trntype", "actuator_trnid", "actuator_plugin", "sensor_plugin", "sensor_dim"),
        *("sensor_objtype", "sensor_objid"),
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
