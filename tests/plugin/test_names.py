"""The tendon and the joints of a sheath after `attach`, as Python and compiled code find them."""

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tendon_mj import Parameters, add_friction, add_sensor, add_servo, remove_friction, view_sheath
from tendon_mj.attach.instances import instances
from tendon_mj.plugin import sheaths
from tendon_mj.plugin.sheath_plugin.state import view
from tests.refusals import refusing
from tests.rigs import config, rope, sheath, shown, simulated, spatial

pytestmark = pytest.mark.filterwarnings("ignore:Attaching a spec with an empty prefix")
MOTOR = '<body name="motor"><joint name="motor" armature=".1"/><geom size=".1"/></body>'


def plain(extension="", sensor=""):
    """MJCF of a finger with one tendon, and of a motor beside it."""
    return rope(
        "a; g .2 0 0",
        "b .3 .2 0",
        name="flexor",
        body='name="link"',
        joint='name="knuckle" axis="0 0 1"',
        geom='size=".1"',
        head=extension,
        actuator="",
        sensor=sensor,
        rest=f"<worldbody>{MOTOR}</worldbody>",
    )


PLAIN = plain()
SPOOL = {"reel_joint": "motor", "reel_radius": 0.01}
AFFIXES = [("left_", ""), ("", "_left"), ("left/", "_1"), ("sheath", ""), ("", "sheath")]


def parent():
    return mujoco.MjSpec.from_string(PLAIN)


def finger(**more):
    law = {"name": "sheath", "friction": 0.1, "axial_stiffness": 1e3, "pretension": 1.0}
    return add_friction(parent(), "flexor", **(law | more))


ON_FLEXOR = 'objtype="tendon" objname="flexor"'


def written(sensor=ON_FLEXOR, **more):
    law = {"tendon": "flexor", "axial_stiffness": 1000, "friction": 0.1, "pretension": 1}
    ends = shown("sheath", f'name="ends" {sensor}')
    return mujoco.MjSpec.from_string(plain(sheath("sheath", **law | more), ends))


def attached(child, prefix, suffix="", onto=None):
    spec = parent() if onto is None else onto
    spec.attach(child, prefix=prefix, suffix=suffix, frame=spec.worldbody.add_frame())
    return spec


def pulled(model):
    """Joints that a step with the pretended tendon sets in motion, by name."""
    model.opt.gravity = 0
    data = simulated(model, 1)
    assert np.isfinite(data.qpos).all()
    return {model.jnt(k).name for k in np.flatnonzero(data.qvel)}


@pytest.mark.parametrize(("prefix", "suffix"), AFFIXES)
def test_it_acts_on_its_own_tendon_and_joints(prefix, suffix):
    spec = attached(finger(**SPOOL), prefix, suffix)
    for model in (spec.compile(), mujoco.MjModel.from_xml_string(spec.to_xml())):
        assert pulled(model) == {f"{prefix}{name}{suffix}" for name in ("knuckle", "motor")}
        (sheath,) = sheaths(model).values()
        assert sheath.tendon == f"{prefix}flexor{suffix}"
        data = simulated(model)
        assert data.sensor(f"{prefix}output_tension{suffix}").data[0] > 0.5
        assert view_sheath(model, data, f"{prefix}flexor{suffix}").output_tension > 0.5
        assert Parameters(model, data)[f"{prefix}sheath{suffix}.friction"] == 0.1
    model = attached(finger(reel="reel"), prefix, suffix).compile()
    assert pulled(model) == {f"{prefix}knuckle{suffix}"}


def test_several_copies_and_copies_of_copies():
    model = attached(finger(**SPOOL), "left_", onto=finger()).compile()
    assert {s.tendon for s in sheaths(model).values()} == {"flexor", "left_flexor"}
    assert pulled(model) == {"knuckle", "left_knuckle", "left_motor"}
    spec = mujoco.MjSpec()
    for prefix in ("left_", "right_"):
        attached(finger(), prefix, onto=spec)
    assert pulled(spec.compile()) == {"left_knuckle", "right_knuckle"}
    deep = attached(attached(finger(**SPOOL), "l_", "_s"), "x_", "_y")
    assert pulled(deep.compile()) == {"x_l_knuckle_s_y", "x_l_motor_s_y"}


@pytest.mark.parametrize("child", [finger, written], ids=["added", "by hand"])
def test_attach_in_mjcf(tmp_path, child):
    spec = child()
    spec.compile()
    (tmp_path / "finger.xml").write_text(spec.to_xml())
    asset = f'<asset><model name="finger" file="{tmp_path}/finger.xml"/></asset><worldbody>'
    whole = PLAIN.replace("<worldbody>", f'{asset}<attach model="finger" prefix="l_"/>', 1)
    assert sheaths(mujoco.MjModel.from_xml_string(whole))["l_sheath"].tendon == "l_flexor"
    part = whole.replace('prefix="l_"', 'body="link" prefix="l_"')  # the tendon stays behind
    model = mujoco.MjModel.from_xml_string(part)
    assert "l_knuckle" in (model.joint(k).name for k in range(model.njnt))
    assert [model.tendon(k).name for k in range(model.ntendon)] == ["flexor"]  # the parent's
    assert not sheaths(model)  # it stays with its tendon
    assert model.nsensor == 0


def test_a_sheath_without_an_object_is_on_the_tendon_of_the_name_unless_attach_renamed_it():
    objectless = written(sensor="", **SPOOL)
    assert pulled(objectless.compile()) == {"knuckle", "motor"}
    unheld = sheath("sheath", tendon="flexor", axial_stiffness=1000, friction=0.1, pretension=1)
    assert pulled(mujoco.MjModel.from_xml_string(plain(unheld))) == {"knuckle"}
    for onto in (parent(), mujoco.MjSpec()):
        spec = attached(written(sensor=""), "l_", onto=onto)
        with refusing(ValueError, "sensor 'l_ends' has no object", "'l_flexor'", "objname"):
            spec.compile()


def test_an_instance_of_an_earlier_release_keeps_its_tendon_and_joints(tmp_path):
    """It had its name in the attribute `instance`, which has no meaning now."""
    child = written(instance="sheath", **SPOOL)
    for spec, prefix in ((child, ""), (attached(child.copy(), "l_"), "l_")):
        mujoco.mj_saveModel(spec.compile(), str(tmp_path / "model.mjb"))
        for model in (spec.compile(), mujoco.MjModel.from_binary_path(str(tmp_path / "model.mjb"))):
            assert pulled(model) == {f"{prefix}knuckle", f"{prefix}motor"}


def test_an_instance_without_a_name_has_its_sensor_s_tendon():
    keys = config(tendon="flexor", axial_stiffness=1, friction=0)
    child = plain(
        '<extension><plugin plugin="tendon_mj.sheath"/></extension>',
        f'<plugin name="t" plugin="tendon_mj.sheath" {ON_FLEXOR}>{keys}</plugin>',
    )
    for onto in (parent(), mujoco.MjSpec()):
        model = attached(mujoco.MjSpec.from_string(child), "l_", onto=onto).compile()
        assert list(sheaths(model)) == ["l_flexor"]


def test_the_object_alone_says_which_tendon_it_is_but_not_which_joint():
    spec = attached(written(tendon=None), "l_")
    assert pulled(spec.compile()) == {"l_knuckle"}
    assert not remove_friction(spec, "l_flexor").compile().nplugin
    with refusing(ValueError, "reel_joint and tendon go together"):
        written(tendon=None, **SPOOL).compile()


def test_a_tendon_that_is_not_the_one_written_is_refused():
    other = spatial("extensor", "a b") + "</tendon>"
    text = written().to_xml().replace("</tendon>", other)
    with refusing(ValueError, "sensor 'ends' is on tendon 'flexor'", "'extensor'"):
        mujoco.MjModel.from_xml_string(text.replace('value="flexor"', 'value="extensor"'))


WORD = st.text("ab", min_size=1, max_size=3)


def places(text, part):
    return [k for k in range(len(text)) if text.startswith(part, k)]


@given(st.text("ab", max_size=2), st.text("ab", max_size=2), WORD, WORD, st.sets(WORD, max_size=3))
def test_a_joint_is_renamed_like_the_tendon_or_refused(prefix, suffix, tendon, joint, more):
    joints = [f"{prefix}{joint}{suffix}", *sorted(more - {f"{prefix}{joint}{suffix}"})]
    bodies = "".join(f'<body><joint name="{name}"/><geom size=".1"/></body>' for name in joints)
    law = {"axial_stiffness": 1000, "friction": 0.1, "reel_joint": joint, "reel_radius": 0.01}
    now = f"{prefix}{tendon}{suffix}"
    text = rope(
        "x; y .2 0 0",
        "z .3 .2 0",
        name=now,
        joint="",
        head=sheath("s", tendon=tendon, **law),
        actuator="",
        sensor=shown("s", f'objtype="tendon" objname="{now}"'),
        rest=f"<worldbody>{bodies}</worldbody>",
    )
    around = {now[:k] + joint + now[k + len(tendon) :] for k in places(now, tendon)}
    if len(around & set(joints)) > 1:
        with refusing(ValueError, "may mean two joints"):
            mujoco.MjModel.from_xml_string(text)
        return
    model = mujoco.MjModel.from_xml_string(text)
    (instance,) = sheaths(model).values()
    assert instance.tendon == now
    bound = view(simulated(model, 1).plugin_state, instance.state).state
    assert model.joint(int(bound.reel_joint)).name == joints[0]
    ((_, as_spec),) = instances(mujoco.MjSpec.from_string(text))
    assert (as_spec["tendon"], as_spec["reel_joint"]) == (now, joints[0])


@pytest.mark.parametrize("added_later", [False, True])
@pytest.mark.parametrize(("prefix", "suffix"), AFFIXES)
def test_servos_and_sensors_go_with_it_or_are_added_after_attaching(prefix, suffix, added_later):
    def add(spec, before="", behind=""):
        tendon, sheath = (f"{before}{name}{behind}" for name in ("flexor", "sheath"))
        add_servo(
            spec, tendon, tension_gain=100.0, velocity_gain=1.0, name=f"{before}servo{behind}"
        )
        add_sensor(spec, sheath, "slip", name=f"{before}slips{behind}")

    child = finger(**SPOOL)
    if not added_later:
        add(child)
    spec = attached(child, prefix, suffix, onto=finger(**SPOOL))
    if added_later:
        add(spec, prefix, suffix)
    model = attached(spec, "x_").compile()
    name = f"x_{prefix}servo{suffix}"
    data = mujoco.MjData(model)
    data.actuator(name).ctrl[:] = 5.0
    mujoco.mj_step(model, data, 20)
    assert data.sensor(f"x_{prefix}slips{suffix}").data[0] == 1.0
    turned, idle = data.joint(f"x_{prefix}motor{suffix}").qpos[0], data.joint("x_motor").qpos[0]
    assert turned > 0.01
    assert idle < 0.001
