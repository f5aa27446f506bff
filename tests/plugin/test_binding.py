"""A sheath is bound by its data, not by its state, and to the model that is stepped."""

import copy
import itertools

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction, add_sites, add_tendon, view_sheath
from tendon_mj.plugin import advice, sheaths
from tendon_mj.plugin.abi.draft import Draft
from tendon_mj.plugin.sheath_plugin.state import STATE, Bound
from tests.rigs import driven, instance, plugin, rope, shown, simulated, spatial

SHEATHS = (("s1", "one"), ("s2", "two"))
TWINS = rope(
    "a -.1 0 .03; b 0 0 .05",
    "d .1 0 .02",
    "a b d",
    name="two",
    body='pos="0 1 0"',
    joint='name="j2" axis="0 1 0"',
    geom='size=".01" pos=".1 0 0"',
    world='<body><joint name="j1" axis="0 1 0"/><geom size=".01" pos=".1 0 0"/>'
    '<site name="c" pos=".1 0 .02"/></body>',
    head=f"<extension>{plugin(*(instance(k, tendon=t, friction=0.2) for k, t in SHEATHS))}"
    "</extension>",
    tendons=spatial("one", "a b c"),
    actuator='<motor tendon="one"/><motor tendon="two"/>',
    sensor=shown("s1") + shown("s2"),
)
FIELDS = list(Bound.__annotations__)
BEGIN = STATE.fields[FIELDS[0]][1] // 8
BOUND = slice(BEGIN, BEGIN + len(FIELDS))


def stepped(model, steps=3):
    data = mujoco.MjData(model)
    data.qvel[:] = 0.1
    for _ in range(steps):
        mujoco.mj_step(model, data)
    return data


def stepped_after(model, data, change):
    """Whether a step after a change of the state leaves the words that bind as they were."""
    starts = [sheath.state for sheath in sheaths(model).values()]
    bound = [data.plugin_state[start:][BOUND].copy() for start in starts]
    mujoco.mj_step1(model, data)
    change(data.plugin_state, starts)
    mujoco.mj_step2(model, data)  # what is not the model's is neither shown nor advanced
    mujoco.mj_step(model, data)
    actual = [data.plugin_state[start:][BOUND] for start in starts]
    return all(np.array_equal(*both) for both in zip(actual, bound, strict=True))


@pytest.mark.parametrize("factor", [-1.0, 1e100])
def test_words_that_bind_and_are_not_as_they_were_are_set_right(factor):
    """One at a time, and any two at once."""
    model = driven()
    whole = stepped(model)
    words = range(BOUND.start, BOUND.stop)
    for one, other in itertools.combinations_with_replacement(words, 2):
        data = copy.copy(whole)

        def change(state, starts, one=one, other=other):
            for start in starts:
                where = start + np.unique([one, other])
                state[where] = state[where] * factor + (one == other)

        assert stepped_after(model, data, change), (one, other)


def test_the_state_of_another_sheath_is_not_one_s_own():
    model = mujoco.MjModel.from_xml_string(TWINS)
    data = simulated(model, 1, ctrl=(-1.0, -2.0))
    first, second = (sheath.state for sheath in sheaths(model).values())
    size = model.plugin_statenum[1]  # the first has the forces of all dofs too

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
    data = simulated(model, 1)
    model.tendon_stiffness[0] = 0.0
    for force in (2.0, 3.0):
        data.ctrl[1] = -force
        mujoco.mj_step(model, data)
        assert view_sheath(model, data, "two").input_tension == force


SWAPPED = TWINS.replace("a b c", "d e f").replace("a b d", "a b c").replace("d e f", "a b d")
MORE = plugin(instance("k", sensor="slip", tendon="one"))
REORDERED = [
    TWINS.replace("<extension>", f"<extension>{MORE}"),
    TWINS.replace("</extension>", f"{MORE}</extension>"),
]


@pytest.mark.parametrize("texts", [[TWINS, SWAPPED], REORDERED], ids=["tendons", "instances"])
def test_a_model_that_takes_the_place_of_another_of_equal_sizes_is_noticed(texts):
    """As when `mujoco.rollout` steps one data with several models."""
    models = [mujoco.MjModel.from_xml_string(text) for text in texts]
    data = mujoco.MjData(models[0])
    start = data.plugin_state.copy()
    for model in (*models, *models):
        fresh = mujoco.MjData(model)
        for simulation in (data, fresh):
            mujoco.mj_resetData(model, simulation)
            simulation.ctrl[:] = -1.0, -2.0
            mujoco.mj_step(model, simulation, 3)
        np.testing.assert_array_equal(data.qpos, fresh.qpos)
        np.testing.assert_array_equal(data.plugin_state, fresh.plugin_state)
    assert not np.array_equal(data.plugin_state, start)


def test_a_model_in_the_memory_of_another_is_noticed():
    data = mujoco.MjData(mujoco.MjModel.from_xml_string(TWINS))
    for friction in (0.2, 0.6, 0.4, 0.2, 0.6) * 10:
        model = mujoco.MjModel.from_xml_string(TWINS.replace('"0.2"', f'"{friction}"'))
        fresh = mujoco.MjData(model)
        for simulation in (data, fresh):
            mujoco.mj_resetData(model, simulation)
            simulation.ctrl[:] = -1.0, -2.0
            mujoco.mj_step(model, simulation, 2)
        np.testing.assert_array_equal(data.qpos, fresh.qpos)
        del model


@pytest.mark.parametrize(
    ("array", "rows"), [("actuator_trnid", (0, 1)), ("wrap_objid", (2, 5)), ("site_pos", (0, 1))]
)
def test_what_is_written_while_it_is_simulated_acts(array, rows):
    """A changed model and its data go on as those of a model that was so from the start."""
    model, changed = (mujoco.MjModel.from_xml_string(TWINS) for _ in range(2))
    data = simulated(changed, 0, ctrl=(-1.0, -2.0))
    mujoco.mj_forward(changed, data)
    for one in (model, changed):  # what the two tendons are pulled by, or where they end
        values = getattr(one, array)
        values[list(rows)] = values[list(rows[::-1])]
    mujoco.mj_resetData(changed, data)
    fresh = mujoco.MjData(model)
    data.ctrl[:] = fresh.ctrl[:] = -1.0, -2.0
    mujoco.mj_step(changed, data, 3)
    mujoco.mj_step(model, fresh, 3)
    np.testing.assert_array_equal(data.sensordata, fresh.sensordata)
    np.testing.assert_array_equal(data.qpos, fresh.qpos)


def rig_many_sheaths(count):
    """So many tendons over the same three sites, each in a sheath with its sensors."""
    spec = mujoco.MjSpec()
    sites = add_sites(spec, "site", [[0, 0, 0], [1, 0, 0], [1, 1, 0]])
    for k in range(count):
        add_tendon(spec, f"t{k}", sites)
        add_friction(spec, f"t{k}", friction=0.1, axial_stiffness=1e3, pretension=1.0)
    return spec


def test_each_more_sheath_costs_as_many_reads_as_the_one_before(monkeypatch):
    """Of names and configurations, when a model is checked."""
    reads, counts = [], []

    def counting(read):
        return lambda *given: reads.append(given) or read(*given)

    for owner, read in ((Draft, "name"), (advice, "plugin_at"), (advice, "attribute_of")):
        monkeypatch.setattr(owner, read, counting(getattr(owner, read)))
    for count in (10, 20, 40):
        spec = rig_many_sheaths(count)
        reads.clear()
        mujoco.MjData(spec.compile())
        counts.append(len(reads))
    assert counts[2] - counts[1] == 2 * (counts[1] - counts[0])
