"""What an instance's name shares with a tendon's, as Python and compiled code find it."""

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tendon_mj import Parameters, add_friction, add_sensor, add_servo, view_sheath
from tendon_mj.plugin import servos, sheaths
from tendon_mj.plugin.sheath_plugin.names import Affixes, around_tendon
from tendon_mj.plugin.sheath_plugin.state import view
from tests.refusals import refusing
from tests.rigs import config, rope, sheath, shown, simulated, spatial

AFFIX = st.text("ab", max_size=2)
FEW = st.text("ab", min_size=1, max_size=6)  # so that many fit by chance


def compiled(own: str, affixes: Affixes, tendon: str, tendons: list[str]) -> mujoco.MjModel | None:
    """The model as attached with these; None if it is refused, as nothing says which is meant."""
    first, second, third = (affixes.around(site) for site in ("x0", "x1", "x2"))
    path = f"{first} {second} {third}"
    text = rope(
        f"{first}; {second} .2 0 0",
        f"{third} .3 .2 0",
        name=tendons[0],
        head=sheath(affixes.around(own), tendon=tendon, axial_stiffness=1000, friction=0.1),
        tendons="".join(spatial(name, path) for name in tendons[1:]),
        actuator="",
    )
    try:
        return mujoco.MjModel.from_xml_string(text)
    except ValueError as refused:
        if not any(reason in str(refused) for reason in ("may be", "unknown tendon")):
            raise
        return None


def all_shared(own: str, tendon: str, tendons: set[str]) -> list[Affixes]:
    """By trying every part of the name that `attach` may have added."""
    parts = [(end, start) for end in range(len(own)) for start in range(end + 1, len(own) + 1)]
    tried = [Affixes(own[:end], own[start:]) for end, start in parts]
    return [affixes for affixes in tried if affixes.around(tendon) in tendons]


@given(st.text("ab", max_size=6), FEW, st.sets(FEW, max_size=4))
def test_all_that_are_shared_are_found(own, tendon, tendons):
    assert around_tendon(own, tendon, tendons) == all_shared(own, tendon, tendons)


@given(AFFIX, AFFIX, FEW, FEW, st.sets(FEW, max_size=3))
def test_compiled_code_takes_the_tendon_that_python_takes(prefix, suffix, own, tendon, more):
    tendons = sorted(more | {prefix + tendon + suffix})
    model = compiled(own, Affixes(prefix, suffix), tendon, tendons)
    if model is None:
        return
    data = simulated(model, 1)
    ((_, sheath),) = sheaths(model).items()
    bound = int(view(data.plugin_state, sheath.state).state.tendon)
    assert tendons[bound] == sheath.tendon


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


def written(**more):
    law = {"tendon": "flexor", "axial_stiffness": 1000, "friction": 0.1}
    ends = shown("sheath", 'name="ends"')
    return mujoco.MjSpec.from_string(plain(sheath("sheath", **law, **more), ends))


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
    if child is written:  # who wrote it may have meant either
        with refusing(ValueError, "instance 'l_sheath'", "'flexor' or 'l_flexor'"):
            mujoco.MjModel.from_xml_string(whole)
    else:
        assert sheaths(mujoco.MjModel.from_xml_string(whole))["l_sheath"].tendon == "l_flexor"
    part = whole.replace('prefix="l_"', 'body="link" prefix="l_"')  # the tendon stays behind
    if child is not written:
        model = mujoco.MjModel.from_xml_string(part)
        assert "l_knuckle" in (model.joint(k).name for k in range(model.njnt))
        assert [model.tendon(k).name for k in range(model.ntendon)] == ["flexor"]  # the parent's
        assert not sheaths(model)  # it stays with its tendon
        assert model.nsensor == 0


def test_a_sheath_written_by_hand():
    assert pulled(attached(written(instance="sheath"), "l_").compile()) == set()  # no pretension
    assert (
        sheaths(attached(written(instance="sheath"), "l_").compile())["l_sheath"].tendon
        == "l_flexor"
    )
    alone = attached(written(), "l_", onto=mujoco.MjSpec()).compile()
    assert sheaths(alone)["l_sheath"].tendon == "l_flexor"
    with refusing(ValueError, "'flexor' or 'l_flexor'", 'key="instance"'):
        attached(written(), "l_").compile()


def test_an_instance_without_a_name_goes_by_what_refers_to_it():
    for more in ({}, {"instance": "t"}):
        keys = config(tendon="flexor", axial_stiffness=1, friction=0, **more)
        child = plain(
            '<extension><plugin plugin="tendon_mj.sheath"/></extension>',
            f'<plugin name="t" plugin="tendon_mj.sheath">{keys}</plugin>',
        )
        onto = parent() if more else mujoco.MjSpec()
        model = attached(mujoco.MjSpec.from_string(child), "l_", onto=onto).compile()
        assert list(sheaths(model)) == ["l_flexor"]


def test_a_name_by_chance_is_no_prefix():
    """Tendons `1` and `11`, a sheath `1_sheath`: nothing says that it was attached as `1`."""
    text = written().to_xml().replace('"flexor"', '"1"').replace('"sheath"', '"1_sheath"')
    other = spatial("11", "a b") + "</tendon>"
    model = mujoco.MjModel.from_xml_string(text.replace("</tendon>", other))
    assert sheaths(model)["1_sheath"].tendon == "1"
    with refusing(ValueError, "unknown tendon 'lexor'"):
        text = written().to_xml().replace('value="flexor"', 'value="lexor"')
        mujoco.MjModel.from_xml_string(text.replace('"sheath"', '"flexor_sheath"'))


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
    assert servos(model)[name].tendon == f"x_{prefix}flexor{suffix}"
    data = mujoco.MjData(model)
    data.actuator(name).ctrl[:] = 5.0
    mujoco.mj_step(model, data, 20)
    assert data.sensor(f"x_{prefix}slips{suffix}").data[0] == 1.0
    turned, idle = data.joint(f"x_{prefix}motor{suffix}").qpos[0], data.joint("x_motor").qpos[0]
    assert turned > 0.01
    assert idle < 0.001
