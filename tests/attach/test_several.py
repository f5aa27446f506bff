"""Friction on several tendons at once: choice, names, and what is said."""

import mujoco
import numpy as np
import pytest

from tendon_mj import (
    TendonWarning,
    add_friction,
    add_sensor,
)
from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.plugin import sheaths
from tests.refusals import refusing, silent
from tests.rigs import LIMP, finger, unsigned

WAYS = {
    "one list": ["flexor", "extensor"],
    "the other way round": ["extensor", "flexor"],
    "pattern": "?*or",
    "brackets": "[fe]*or",
    "all": "*",
    "twice": ["flexor", "*", "flexor"],
}
UNNAMED = LIMP.replace('name="limp"', 'stiffness="9"')
SHORT = '<spatial name="short" stiffness="9"><site site="a"/><site site="e"/></spatial>'
FIXED = '<fixed name="sum"><joint joint="mcp" coef="1"/></fixed>'


def named(spec):
    """Names by (tendon, what it is) of sheaths and of their sensors."""
    configs = {plugin.name: plugin.config for plugin in spec.plugins}
    names = {(c["tendon"], "sheath"): n for n, c in configs.items() if "sensor" not in c}
    for sensor in spec.sensors:
        config = configs[sensor.plugin.name]
        names[config.get("tendon", sensor.objname), config.get("sensor", "ends")] = sensor.name
    return names


@pytest.mark.parametrize("way", WAYS)
def test_names_follow_from_the_tendon_in_whatever_way_several_are_asked_for(way):
    spec = add_friction(finger(), WAYS[way], friction=0.1)
    assert named(spec) == {
        (tendon, what): f"{tendon}_{'sheath' if what == 'ends' else what}"
        for tendon in ("flexor", "extensor")
        for what in ("sheath", "ends", "input_tension", "output_tension")
    }
    assert spec.compile().nplugin == 4, "sensors of a kind share an instance"


def test_names_do_not_depend_on_the_order_of_the_calls():
    one, other = finger(), finger()
    for tendon in ("flexor", "extensor"):
        add_friction(one, [tendon], friction=0.1)
    for tendon in ("e*", "f*"):
        add_friction(other, tendon, friction=0.1)
    assert named(one) == named(other)


@pytest.mark.parametrize("first", ["flexor", ["flexor"]])
@pytest.mark.parametrize("second", ["extensor", ["extensor"], "e*"])
def test_a_second_sheath_renames_nothing(first, second):
    spec = add_friction(finger(), first, friction=0.1)
    before = named(spec)
    add_friction(spec, second, friction=0.1)
    assert named(spec).items() >= before.items()
    assert len(set(named(spec).values())) == 6, "the ends go by their sheath's name"


def test_automatic_names_are_free_ones():
    spec = finger()
    taken = ("flexor_sheath", "flexor_sheath_ends", "flexor_input_tension", "output_tension")
    for name in taken:
        spec.add_sensor(
            name=name, type=mujoco.mjtSensor.mjSENS_JOINTPOS, objtype=mujoco.mjtObj.mjOBJ_JOINT,
            objname="mcp",
        )  # fmt: skip
    add_friction(spec, "extensor", friction=0.1, name="flexor_sheath.input_tension")
    add_friction(spec, ["flexor"], friction=0.1)
    add_sensor(spec, "flexor_sheath", "input_tension")
    names = [sensor.name for sensor in spec.sensors]
    assert len(set(names)) == len(names)
    assert spec.compile().nsensor == len(names) == 4 + 3 + 3 + 1
    with refusing(InvalidValueError, "'output_tension'"):
        add_sensor(spec, "flexor_sheath", "slip", name="output_tension")


def test_a_pattern_does_what_the_calls_one_by_one_do():
    spec, other = finger(), finger()
    add_friction(spec, "*", friction=0.2, static_friction=0.3)
    for tendon in ("extensor", "flexor"):
        add_friction(other, tendon, friction=0.2, static_friction=0.3)
    one, two = spec.compile(), other.compile()
    data = [mujoco.MjData(one), mujoco.MjData(two)]
    for model, simulation in zip((one, two), data, strict=True):
        simulation.qvel[:] = [1.0, -2.0]
        mujoco.mj_step(model, simulation, 100)
    np.testing.assert_array_equal(data[0].sensordata, data[1].sensordata)
    np.testing.assert_array_equal(unsigned(data[0].plugin_state), unsigned(data[1].plugin_state))
    np.testing.assert_array_equal(one.tendon_lengthspring, two.tendon_lengthspring)


def test_a_name_with_the_characters_of_a_pattern_is_that_tendon_s():
    more = UNNAMED.replace("<spatial", '<spatial name="f*"')
    spec = add_friction(finger(more), "f*", friction=0.1)
    assert named(spec)["f*", "sheath"] == "f*_sheath"
    assert {tendon for tendon, _ in named(spec)} == {"f*"}


def test_a_pattern_leaves_out_what_cannot_be_and_says_so_once():
    spec = add_friction(finger(LIMP + FIXED), "flexor", friction=0.1)
    with pytest.warns(TendonWarning) as caught:
        add_friction(spec, "*", friction=0.1)
    (said,) = caught
    assert said.filename == __file__
    assert "'limp': has no stiffness to take over" in str(said.message)
    assert "give axial_stiffness [N] and pretension [N]" in str(said.message)
    assert "'flexor': already runs in sheath 'flexor_sheath'" in str(said.message)
    assert "'sum': is fixed" in str(said.message), "or it would be without friction in silence"
    assert {s.tendon for s in sheaths(spec.compile()).values()} == {"flexor", "extensor"}


def test_tendons_without_a_name_are_given_a_free_one_and_it_is_said():
    spec = finger(UNNAMED + UNNAMED.replace("<spatial", '<spatial name="tendon_2"'))
    with pytest.warns(TendonWarning, match="now 'tendon_2_2'$"):
        add_friction(spec, "*", friction=0.1)
    tendons = {s.tendon for s in sheaths(spec.compile()).values()}
    assert tendons == {"flexor", "extensor", "tendon_2", "tendon_2_2"}
    spec = finger(UNNAMED)
    with silent():
        add_friction(spec, "f*", friction=0.1)
    assert spec.tendons[2].name == ""


@pytest.mark.parametrize("tendon", ["short", ["short"], "sh*"])
def test_a_tendon_without_bend_is_said_to_be_one_with_the_remedy(tendon):
    with pytest.warns(TendonWarning, match=r"no effect on 'short'.*extra_bend \[rad\], or route"):
        add_friction(finger(SHORT), tendon, friction=0.1)
    with silent():
        add_friction(finger(SHORT), tendon, friction=0.1, extra_bend=1.0)


REFUSED = [
    (["flexor", "extensr"], {}, "did you mean 'extensor'"),
    ("thumb*", {}, "thumb*"),
    ("s*m", {}, "'sum': is fixed"),
    ("", {}, "''"),
    ([], {}, "tendon"),
    ([3], {}, "3"),
    (["flexor", "sum"], {}, "'sum' is fixed"),
    (["flexor", "limp"], {}, "'limp'"),
    ("l*", {}, "'limp': has no stiffness"),
    ("*", {"reel": "motor"}, "reel = 'motor'"),
    ("*", {"reel_joint": "mcp", "reel_radius": 0.1}, "reel_joint = 'mcp'"),
    (["flexor"], {"name": "tube"}, "name = 'tube'"),
    *[("*", {"arc_guides": n}, f"arc_guides = {n!r}") for n in (0, 1.5, True, "2")],
    *[("*", {"inner_guides": n}, f"inner_guides = {n!r}") for n in (-1, 1.5, True, "2")],
]


@pytest.mark.parametrize(("tendon", "more", "fact"), REFUSED)
def test_a_refusal_leaves_the_model_as_it_was(tendon, more, fact):
    spec = finger(FIXED + LIMP + UNNAMED)
    spec.compile()
    before = spec.to_xml()
    with refusing((UnknownNameError, InvalidValueError), fact):
        add_friction(spec, tendon, friction=0.1, **more)
    assert spec.to_xml() == before
