"""Sensors that share an instance and say by their object whose sheath they show."""

import copy
import itertools

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction, add_sensor, remove_friction, view_sheath
from tendon_mj.plugin import sheaths
from tests.refusals import refusing
from tests.rigs import compiled, config, restore, rope, sheath, shown, simulated, snapshot, spatial

TENDONS = ("one", "two", "three")
KINDS = ("input_tension", "output_tension", "unsolved")


def finger():
    """A tendon with a motor on each of three hinges that do not touch each other."""
    spec = mujoco.MjSpec()
    for k, name in enumerate(TENDONS):
        spec.worldbody.add_site(name=f"{name}_a", pos=[0, k, 0])
        spec.worldbody.add_site(name=f"{name}_b", pos=[0.1, k, 0.02])
        body = spec.worldbody.add_body(pos=[0.2, k, 0])
        body.add_joint(name=name, axis=[0, 1, 0])
        body.add_geom(size=[0.02, 0, 0])
        body.add_site(name=f"{name}_c", pos=[0.05, 0, 0.01])
        tendon = spec.add_tendon(name=name)
        for end in "abc":
            tendon.wrap_site(f"{name}_{end}")
        motor = spec.add_actuator(name=name, target=name)
        motor.trntype = mujoco.mjtTrn.mjTRN_TENDON
    return spec


def pulled(spec, steps=5):
    """Each tendon is pulled with another force."""
    model = spec.compile()
    data = mujoco.MjData(model)
    data.ctrl[:] = -1.0 - np.arange(model.nu)
    mujoco.mj_step(model, data, steps)
    return model, data


def shows(model, data, prefix=""):
    """Whether each sensor shows the sheath on the tendon that it is named after."""
    for tendon, kind in itertools.product(TENDONS, KINDS[:2]):
        name = f"{prefix}{tendon}"
        shown = data.sensor(f"{name}_{kind}").data
        assert shown == getattr(view_sheath(model, data, name), kind), name
        assert shown > 0.5
    return True


@pytest.fixture
def spec():
    return add_friction(finger(), "*", friction=0.2, sensors=KINDS)


def test_each_shows_the_tendon_that_is_its_object_also_in_copies_and_restored(spec):
    model, data = pulled(spec)
    assert model.nplugin == len(TENDONS) + len(KINDS)
    tensions = [float(data.sensor(f"{name}_input_tension").data[0]) for name in TENDONS]
    assert tensions == [1.0, 2.0, 3.0]
    fresh = mujoco.MjData(model)
    restore(model, fresh, snapshot(model, data))
    for one in (data, copy.copy(data), fresh):
        mujoco.mj_forward(model, one)
        assert shows(model, one)
        np.testing.assert_array_equal(one.sensordata, data.sensordata)


def test_what_attach_renames_is_shown_on_both_sides(spec):
    hand = mujoco.MjSpec()
    for k, side in enumerate(("left", "right")):
        frame = hand.worldbody.add_frame(pos=[0, 10 * k, 0])
        hand.attach(spec.copy(), prefix=f"{side}_", frame=frame)
    model, data = pulled(hand)
    assert len(sheaths(model)) == 2 * len(TENDONS)
    assert shows(model, data, "left_")
    assert shows(model, data, "right_")


@pytest.mark.parametrize("removed", TENDONS)
def test_those_that_stay_go_on_where_a_sheath_is_removed(spec, removed):
    model, data = pulled(spec)
    remove_friction(spec, removed)
    model, data = spec.recompile(model, data)
    mujoco.mj_step(model, data)
    stay = [tendon for tendon in TENDONS if tendon != removed]
    for tendon in stay:
        shown = data.sensor(f"{tendon}_input_tension").data
        assert shown == 1.0 + TENDONS.index(tendon)
    spec.sensor(f"{stay[0]}_input_tension").objname = stay[1]  # it may be another's the next time
    model, data = spec.recompile(model, data)
    mujoco.mj_forward(model, data)
    assert data.sensor(f"{stay[0]}_input_tension").data == 1.0 + TENDONS.index(stay[1])
    remove_friction(spec, "*")
    assert not spec.plugins
    assert not spec.sensors


def test_a_state_that_points_elsewhere_is_not_believed(spec):
    model, data = pulled(spec)
    shared = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_PLUGIN, "input_tension")
    sensors = np.flatnonzero(model.sensor_plugin == shared)
    start, count = model.plugin_stateadr[shared], model.plugin_statenum[shared]
    mujoco.mj_forward(model, data)
    before = data.sensordata.copy()
    for word in range(count):
        for value in (-1.0, 1e300, np.nan, float(sensors[0])):
            data.plugin_state[start + word] = value
            data.sensordata[:] = 0.0
            mujoco.mj_forward(model, data)
            np.testing.assert_array_equal(data.sensordata, before)


def test_a_sensor_that_is_added_shares_the_instance_too(spec):
    before = len(spec.plugins)
    sheath = spec.plugin("two_sheath").name
    assert add_sensor(spec, sheath, "input_tension", "again").objname == "two"
    add_sensor(spec, sheath, "reel_displacement")
    add_sensor(spec, sheath, "slip")
    assert len(spec.plugins) == before + 2
    model, data = pulled(spec)
    assert data.sensor("again").data == 2.0
    assert model.sensor("slip").dim == 1


@pytest.mark.parametrize("removed", ["one", "two", "*"])
def test_instances_that_were_read_from_a_file_are_shared_as_well(removed):
    spec = add_friction(finger(), "one", friction=0.2)
    spec.compile()
    spec = add_friction(mujoco.MjSpec.from_string(spec.to_xml()), "two", friction=0.2)
    assert len(spec.plugins) == 4
    assert all(sensor.plugin.active for sensor in spec.sensors)
    remove_friction(spec, removed)
    assert spec.compile().nplugin == (0 if removed == "*" else 3)


def digit(guides):
    """A finger whose tendon runs over so many sites between its ends, with sensors."""
    names = [f"g{k}" for k in range(guides)]
    ground = "a; " + "; ".join(f"{name} .{k + 1} 0 .0{k % 2}" for k, name in enumerate(names))
    spec = mujoco.MjSpec.from_string(rope(ground, "b .9 .2 0", actuator=""))
    law = {"friction": 0.1, "axial_stiffness": 1e2, "pretension": 1.0}
    return add_friction(spec, "t", sensors=("tension",), **law)


def test_a_sensor_is_as_long_as_the_path_of_its_own_tendon_after_attach():
    hand = digit(2)
    for name, guides in (("index_", 4), ("thumb_", 3)):
        hand.attach(digit(guides), prefix=name, frame=hand.worldbody.add_frame())
    add_sensor(hand, "t_sheath", "slip", "slip")
    add_sensor(hand, "index_t_sheath", "bend_angle", "bend")
    data = simulated(hand.compile())
    for name, guides in (("", 2), ("index_", 4), ("thumb_", 3)):
        assert data.sensor(f"{name}tension").data == pytest.approx(np.ones(guides + 1))
    assert (data.sensor("slip").data.size, data.sensor("bend").data.size) == (2, 4)
    hand.plugin("thumb_t_sheath.tension").config = {"sensor": "tension", "guides": "4"}
    with refusing(ValueError, "sensor 'thumb_tension'", "'thumb_t'", "guides"):
        hand.compile()


def mjcf(sensor):
    return rope(
        "a; b .1 0 .01",
        "c .1 0 0",
        name="flexor",
        body='pos=".2 0 0"',
        head=sheath("sheath", tendon="flexor", friction=0.1),
        tendons=spatial("bare", "a b c"),
        actuator='<motor tendon="flexor"/>',
        sensor=f'<plugin name="ends" plugin="tendon_mj.sheath" instance="sheath"/>{sensor}',
    )


def plugin_sensor(attributes, **values):
    return (
        f'<plugin name="shown" plugin="tendon_mj.sheath" {attributes}>{config(**values)}</plugin>'
    )


FLEXOR = 'objtype="tendon" objname="flexor"'


@pytest.mark.parametrize(
    "sensor",
    [
        plugin_sensor(FLEXOR, sensor="input_tension"),
        plugin_sensor("", sensor="input_tension", tendon="flexor"),
        plugin_sensor(FLEXOR, sensor="input_tension", tendon="flexor"),
        plugin_sensor(FLEXOR, sensor="tension", tendon="flexor"),
    ],
)
def test_a_tendon_is_said_by_the_object_or_by_the_configuration(sensor):
    data = simulated(compiled(mjcf(sensor)), 1, ctrl=-2.0)
    assert data.sensor("shown").data[0] == data.sensor("ends").data[0] == 2.0


BARE = 'objtype="tendon" objname="bare"'


REFUSED = [
    (plugin_sensor("", sensor="input_tension"), ["'shown'", "objtype"]),
    (
        plugin_sensor('objtype="site" objname="a"', sensor="input_tension"),
        ["'shown'", "objtype"],
    ),
    (plugin_sensor(BARE, sensor="input_tension"), ["'shown'", "'bare'"]),
    (plugin_sensor(BARE, sensor="input_tension", tendon="flexor"), ["'shown'", "'flexor'"]),
    (plugin_sensor(FLEXOR, sensor="slip"), ["slip", "guides is missing"]),
    (
        shown("sheath", BARE),
        ["sensor 'ends'", "'flexor'", "'bare'"],
    ),  # of both ends, which are the sheath's own
]


@pytest.mark.parametrize(("sensor", "facts"), REFUSED)
def test_a_sensor_of_no_tendon_or_of_two_is_refused(sensor, facts):
    with refusing(ValueError, *facts):
        compiled(mjcf(sensor))
