"""Signatures of a state: alike for models that say the same, of another number for all others."""

import copy
import itertools

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction, add_sites, add_tendon, view_sheath
from tendon_mj.plugin import read_layout, sheaths
from tendon_mj.plugin.abi.checks import Draft
from tendon_mj.plugin.sheath_plugin import signature as sg
from tendon_mj.plugin.sheath_plugin.signature import model_signature
from tendon_mj.plugin.sheath_plugin.state import BOUND_BEGIN, BOUND_SIZE, STATE, view
from tests.rigs import MODELS, driven, driven_xml, instance, plugin, rope, shown, simulated, spatial

LAYOUT = read_layout()


def rig(tendons=("one", "two"), friction=0.1, **more):
    spec = mujoco.MjSpec()
    sites = add_sites(spec, "site", [[0, 0, 0], [1, 0, 0], [1, 1, 0]])
    for name in ("near", "far"):
        body = spec.worldbody.add_body(name=name)
        body.add_geom(size=[0.1, 0, 0])
        body.add_joint(name=name)
    for name in tendons:
        add_tendon(spec, name, sites)
    law = {"axial_stiffness": 1e3, "pretension": 1.0, "sensors": ()}
    add_friction(spec, "one", friction=friction, name="sheath", **law, **more)
    return spec.compile()


def configured(model):
    return sg.config_signature(LAYOUT, model._address, 0)


def bound(model, tendon=0.0, joints=(-1.0, -1.0), actuator=-1.0, sensors=(0.0, -1.0)):
    state = np.zeros(model.npluginstate * 8, np.uint8)
    fields = state[: STATE.itemsize].view(STATE)
    fields["tendon"], fields["reel_actuator"] = tendon, actuator
    fields["reel_joint"], fields["output_joint"] = joints
    fields["first_sensor"], fields["last_sensor"] = sensors
    fields["first_actuator"] = fields["last_actuator"] = -1.0
    return sg.binding_signature(LAYOUT, model._address, 0, state.ctypes.data)


def test_models_that_say_the_same_have_the_same():
    for read in (configured, bound):
        numbers = {read(model) for model in (rig(), rig())}
        assert len(numbers) == 1
        (number,) = numbers
        assert number >= 1.0
        assert number == int(number)


def test_every_change_of_the_configuration_is_seen():
    changes = [{"friction": mu} for mu in np.linspace(0.1, 0.9, 81).round(2)]
    changes += [{"axial_damping": 1.0}, {"backlash": 1.0}, {"tendon_mass": 1.0}]
    changes += [{"reel_joint": j, "reel_radius": 0.1} for j in ("near", "far")]
    numbers = [configured(rig(**change)) for change in changes]
    assert len(set(numbers)) == len(changes)


def test_every_other_element_under_an_index_is_seen():
    model = rig(reel="reel")
    spools = {
        joints: bound(model, joints=joints) for joints in ((-1.0, -1.0), (0.0, -1.0), (-1.0, 0.0),
                                                           (1.0, -1.0), (0.0, 1.0), (1.0, 0.0))
    }  # fmt: skip
    assert len(set(spools.values())) == len(spools)
    assert bound(rig(), 0.0) != bound(rig(), 1.0)
    assert bound(rig(("one", "two"))) != bound(rig(("two", "one")))  # sizes and names are the same
    assert bound(rig()) != bound(rig(("one", "two", "three")))


@pytest.mark.parametrize("index", [-2.0, 2.0, 1e300, np.nan, np.inf, -np.inf, -0.5])
def test_an_index_that_the_model_has_not_is_none(index):
    model = rig()
    assert bound(model, index) == sg.NONE
    assert bound(model, joints=(index, -1.0)) == sg.NONE
    assert bound(model, joints=(-1.0, index)) == sg.NONE
    assert bound(model, actuator=index) == sg.NONE
    assert bound(model, sensors=(0.0, index)) == sg.NONE
    assert bound(model, sensors=(index, 0.0)) == sg.NONE


def test_sensors_and_actuators_are_those_of_the_instance():
    model = rig(reel="reel")
    assert bound(model, actuator=0.0) != sg.NONE
    assert bound(rig(), sensors=(0.0, 0.0)) != sg.NONE


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
    states = [view(data.plugin_state, sheath.state).state for sheath in sheaths(model).values()]
    assert {state.first_sheath for state in states} == {min(s.first_sheath for s in states)}
    assert all(state.seal > 0.0 for state in states)
    assert [state.model_signature for state in states if state.model_signature] == [
        signature(model)
    ]


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
    data = simulated(model, 1, ctrl=(-1.0, -2.0))
    first, second = (sheath.state for sheath in sheaths(model).values())
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
    data = simulated(model, 1)
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
    renamed = mujoco.MjModel.from_xml_string(driven_xml().replace(*change))
    assert signature(renamed) != signature(mujoco.MjModel.from_xml_string(driven_xml()))


def test_that_a_spring_comes_or_goes_is_part_of_the_signature_and_how_stiff_it_is_is_not():
    model = driven()
    before = signature(model)
    model.tendon_stiffness[1] *= 2.0
    assert signature(model) == before
    model.tendon_stiffness[1] = 0.0
    assert signature(model) != before


def test_parameters_are_part_of_the_signature():
    spec = mujoco.MjSpec.from_string(driven_xml())
    plain = signature(spec.compile())
    assert plain != signature(driven())


def rig_many_sheaths(count):
    """So many tendons over the same three sites, each in a sheath with its sensors."""
    spec = mujoco.MjSpec()
    sites = add_sites(spec, "site", [[0, 0, 0], [1, 0, 0], [1, 1, 0]])
    for k in range(count):
        add_tendon(spec, f"t{k}", sites)
        add_friction(spec, f"t{k}", friction=0.1, axial_stiffness=1e3, pretension=1.0)
    return spec


@pytest.fixture
def reads(monkeypatch):
    """Every call with which a check reads a name or a configuration."""
    seen = []

    def counting(read):
        def counted(self, *arguments):
            seen.append(arguments)
            return read(self, *arguments)

        return counted

    for method in ("config", "name", "plugin"):
        monkeypatch.setattr(Draft, method, counting(getattr(Draft, method)))
    return seen


def test_each_more_sheath_costs_as_many_reads_as_the_one_before(reads):
    counts = []
    for count in (10, 20, 40):
        reads.clear()
        mujoco.MjData(rig_many_sheaths(count).compile())
        counts.append(len(reads))
    assert counts[2] - counts[1] == 2 * (counts[1] - counts[0])


def test_models_compiled_in_turn_do_not_see_each_other():
    for count in (3, 1, 5, 2):
        model = rig_many_sheaths(count).compile()
        assert len(sheaths(model)) == count
        data = simulated(model)
        names = [model.sensor(k).name for k in range(model.nsensor)]
        assert [float(data.sensor(n).data[0]) for n in names] == pytest.approx([1.0] * len(names))
