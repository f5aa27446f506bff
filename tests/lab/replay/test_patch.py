"""Laws of a patched model: it loads, has what it was given, and moves as that was simulated."""

from __future__ import annotations

import dataclasses
import math

import mujoco
import numpy as np
import pytest

from tendon_mj.errors import InvalidValueError, TendonError, TendonWarning, UnknownNameError
from tendon_mj.lab.recordings import Uncertain
from tendon_mj.lab.replay import (
    Adjustable,
    Simulator,
    patch_model,
    read_intervals,
    replay_recording,
)
from tendon_mj.models import load_model, load_spec, model_path
from tests.lab.recorded import recorded
from tests.refusals import refusing
from tests.rigs import rope

TIME = np.arange(0.0, 0.4, 0.005)
DRIVEN = {  # model -> driven column and its actuator, measured columns and their sensors
    "bench": (
        ("reel_m", "reel", 1e-3),
        {"input_N": "input_tension", "output_N": "output_tension", "out_m": "output_displacement"},
    ),
    "joint": (
        ("command_rad", "command", 0.5),
        {"joint_rad": "joint_angle", "tension_N": "input_tension_1"},
    ),
    "finger": (("motor_Nm", None, 0.01), {"tension_N": "flexor_input_tension"}),
}
GIVEN = {
    "bench": {
        "sheath.friction": 0.1 + 0.2,
        "sheath.constant_friction": 1 / 3,
        "sheath.pretension": 25.0,
        "environment.stiffness": 12345.678901234567,
        "environment.springref": -0.0021,
        "sensor.armature": 0.125,
        "reel.command_scale": 0.97,
        "reel.command_offset": 1e-5,
        "reel.command_delay": 0.0123,
        "sensor.mass": 1.5,
        "input_tension.offset": 0.1234567890123,
        "input_tension.delay": 0.0123,
        "output_tension.lag": 0.02,
        "output_tension.scale": 1.05,
        "output_displacement.drift": 1e-4,
        "gravity.x": -1.0,
    },
    "joint": {
        "sheath_1.friction": 0.123456789012345,
        "sheath_2.reel_radius": -0.0031,
        "joint.stiffness": 0.03,
        "joint.springref": 0.1,
        "spool.armature": 0.02,
        "joint.frictionloss": 0.001,
        "command.kp": 9000.0,
        "command.kv": 21.0,
        "command.gear": 1.1,
        "joint.mass": 0.03,
        "joint_angle.lag": 0.05,
    },
    "finger": {"flexor_sheath.friction": 0.2, "pip.damping": 0.01, "gravity.z": -8.0},
}


def recording_of(name, **more):
    (column, actuator, size), measured = DRIVEN[name]
    actuator = actuator or load_model(name).actuator(0).name
    return recorded(TIME, {column: (actuator, size * np.sin(12.0 * TIME))}, measured, name, **more)


def patched(source, given, folder, **more):
    """A model as it is read from the file that it was written to."""
    return load_model(str(patch_model(source, given, folder / "patched.xml", **more)))


def values_of(model):
    return {name: p.value for name, p in Adjustable(model).parameters().items()}


@pytest.mark.parametrize("name", DRIVEN)
def test_a_patched_model_moves_as_was_simulated(name, tmp_path):
    recording = recording_of(name, known=GIVEN[name])
    (simulated,) = Simulator([recording])([{}])[0]
    written = patched(name, GIVEN[name], tmp_path)
    told = replay_recording(dataclasses.replace(recording, known={}), written)
    plain = replay_recording(dataclasses.replace(recording, known={}))
    for column, series in simulated.items():
        np.testing.assert_allclose(told.columns[column], series, rtol=1e-12, atol=1e-12)
        assert np.abs(plain.columns[column] - series).max() > 1e-6, column


def test_its_own_values_overrule_the_guesses_of_a_recording(tmp_path):
    recording = recording_of("bench", known={"sheath.friction": 0.3})
    written = patched("bench", {"sheath.friction": 0.1}, tmp_path)
    plain = dataclasses.replace(recording, known={"sheath.friction": 0.1})
    told = replay_recording(recording, written, described=False)
    assert all(
        np.array_equal(told.columns[c], replay_recording(plain).columns[c]) for c in told.columns
    )


def test_what_was_fitted_is_kept_and_what_else_is_known_is_applied(tmp_path):
    """On a model with intervals, which a diagnosis wrote."""
    recording = recording_of("bench", known={"input_tension.offset": 0.5})
    guess = {"sheath.friction": Uncertain(0.15, 0.05, 0.4)}
    described = dataclasses.replace(recording, uncertain=guess)
    within = {"sheath.friction": (0.2, 0.3)}
    written = patched("bench", {"sheath.friction": 0.25}, tmp_path, intervals=within)
    told = replay_recording(described, written)
    meant = replay_recording(recording, parameters={"sheath.friction": 0.25})
    for column in recording.measured:
        np.testing.assert_allclose(told.columns[column], meant.columns[column], rtol=1e-12)


@pytest.mark.parametrize("name", DRIVEN)
def test_every_parameter_can_be_written(name, tmp_path):
    before = values_of(load_model(name))
    # a radius is of a spool that is there, and static friction is above the dynamic one
    leave = {n for n, v in before.items() if n.endswith(("_radius", ".static_friction")) and not v}
    leave |= {n for n in before if ".slip" in n}  # of a recording
    given = {n: v * 1.125 + (0.0 if v else 0.125) for n, v in before.items() if n not in leave}
    after = values_of(patched(name, given, tmp_path))
    assert after.keys() == before.keys()
    for n, value in after.items():
        assert value == pytest.approx(given.get(n, before[n]), rel=1e-12), n


@pytest.mark.parametrize("name", DRIVEN)
def test_nothing_given_is_the_model_to_the_bit(name, tmp_path):
    written = patched(name, {}, tmp_path)
    model = load_model(name)
    for field in ("site_pos", "body_inertia", "jnt_axis", "geom_quat", "tendon_length0", "qpos0"):
        np.testing.assert_array_equal(getattr(written, field), getattr(model, field), field)


def test_a_patch_of_a_patch_is_both(tmp_path):
    once = patch_model(
        "bench",
        {"sheath.friction": 0.2, "input_tension.lag": 0.1},
        tmp_path / "once.xml",
        intervals={"sheath.friction": (0.1, 0.3)},
    )
    given, within = {"input_tension.scale": 2.0, "sheath.friction": 0.25}, (0.2, 0.3)
    twice = patched(once, given, tmp_path, intervals={"sheath.friction": within})
    assert (given | {"input_tension.lag": 0.1}).items() <= values_of(twice).items()
    assert read_intervals(twice) == {"sheath.friction": within}


def test_intervals_survive_mujocos_own_writing(tmp_path):
    intervals = {"sheath.friction": (0.1 + 0.02, 1 / 3), "input_tension.offset": (-1e-7, 0.5)}
    given = {"sheath.friction": 0.2, "input_tension.offset": 0.1}
    path = patch_model("bench", given, tmp_path / "model.xml", intervals=intervals)
    assert read_intervals(load_model(str(path))) == intervals
    spec = load_spec(str(path))
    spec.compile()
    again = mujoco.MjSpec.from_string(spec.to_xml()).compile()
    assert read_intervals(again) == intervals
    assert values_of(again)["input_tension.offset"] == pytest.approx(0.1)


def test_a_model_stays_where_what_was_to_take_its_place_does_not_hold(tmp_path):
    path = tmp_path / "model.xml"
    path.write_text(
        """<mujoco><compiler inertiafromgeom="true"/><worldbody><body name="b"><freejoint/>
        <geom size=".1"/></body></worldbody></mujoco>"""
    )
    before = path.read_text()
    with refusing(TendonError, str(path), "b.mass = 0.5"):
        patch_model(path, {"b.mass": 0.5}, path)
    assert path.read_text() == before
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", ["a---b", 'x---><option gravity="0 0 5"/>'])
def test_a_name_does_not_end_the_comment_that_says_it(name, tmp_path):
    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body(name="b")
    body.add_joint(name=name, damping=0.1)
    body.add_geom(size=[0.1, 0, 0])
    spec.compile()
    source = tmp_path / "m---x.xml"
    source.write_text(spec.to_xml())
    path = patch_model(source, {f"{name}.damping": 0.5}, tmp_path / "written.xml")
    again = patched(path, {}, tmp_path)
    assert again.joint(name).damping == 0.5
    assert again.opt.gravity[2] == -9.81


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("sheath.friction.interval", "abc"),
        ("sheath.friction.interval", "1 2 3"),
        ("sheath.drawn_bend.correction", "abc"),
        ("sheath.drawn_bend.correction", "nan"),
        ("sheath.drawn_bend.correction", "1e308"),
    ],
)
def test_a_text_of_the_model_that_is_none_of_ours_is_refused_by_name(name, data):
    spec = load_spec("bench")
    spec.add_text(name=name, data=data)
    model = spec.compile()
    read = read_intervals if name.endswith("interval") else Adjustable
    with refusing(InvalidValueError, f"custom text {name!r}"):
        read(model)


# models of one's own

OWN = """<?xml version="1.0"?>
<!-- a -->
<mujoco>
  <include file="parts.xml"/>
  <compiler {compiler} meshdir="shapes"/>
  <default><joint stiffness="3 0.5" damping="0.2"/></default>
  <asset><mesh name="tip" file="tip.obj"/></asset>
  <worldbody>
    <body>
      <joint name="hinge" axis="0 1 0" springref="{rest}"/>
      <geom type="mesh" mesh="tip" mass="1"/>
    </body>
  </worldbody>
  <actuator>
    <position name="plain" joint="hinge" kp="3" kv="1"/>
    <position name="ratio" joint="hinge" kp="3" dampratio="1"/>
    <motor name="motor" joint="hinge" gear="2 1"/>
  </actuator>
</mujoco>
"""
PARTS = """<mujocoinclude>
  <option timestep="0.001"/>
  <sensor><jointpos name="angle" joint="hinge" user="1 0.5"/></sensor>
</mujocoinclude>
"""
TIP = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def own_model(folder, compiler='angle="degree"', rest=30.0, parts=PARTS):
    (folder / "shapes").mkdir()
    (folder / "shapes" / "tip.obj").write_text(TIP)
    (folder / "parts.xml").write_text(parts)
    (folder / "own.xml").write_text(OWN.format(compiler=compiler, rest=rest))
    return folder / "own.xml"


@pytest.mark.parametrize(("compiler", "rest"), [('angle="degree"', 30.0), ('angle="radian"', 0.5)])
def test_angles_are_in_radians_whatever_the_text_is_in(compiler, rest, tmp_path):
    source = own_model(tmp_path, compiler, rest, PARTS.replace('user="1 0.5"', ""))
    model = patched(source, {"hinge.springref": 0.25, "hinge.stiffness": 4.0}, tmp_path)
    assert model.qpos_spring[0] == pytest.approx(0.25, rel=1e-14)
    assert model.jnt_stiffness[0] == 4.0
    assert model.jnt_stiffnesspoly[0, 0] == 0.5  # what a class says stays


def test_includes_and_meshes_are_found_from_elsewhere(tmp_path):
    (tmp_path / "there").mkdir()
    source = own_model(tmp_path, parts=PARTS.replace('user="1 0.5"', ""))
    given = {"plain.kp": 5.0, "ratio.kp": 4.0, "motor.gear": 3.0, "angle.offset": 0.5}
    model = patched(source, given, tmp_path / "there")
    kept = values_of(load_model(str(source)))["ratio.kv"]
    assert values_of(model)["ratio.kv"] == pytest.approx(kept, rel=1e-12)
    assert values_of(model)["plain.kv"] == 1.0
    assert model.actuator("motor").gear[:2].tolist() == [3.0, 1.0]
    assert model.opt.timestep == 0.001


def test_text_from_outside_the_model_s_folder_is_told_of(tmp_path):
    (tmp_path / "rig").mkdir()
    source = own_model(tmp_path / "rig", parts=PARTS.replace('user="1 0.5"', ""))
    (tmp_path / "rig" / "parts.xml").rename(tmp_path / "secret.xml")
    source.write_text(source.read_text().replace("parts.xml", "../secret.xml"))
    with pytest.warns(TendonWarning, match=r"p.xml holds the text of .*secret\.xml, which .*own"):
        patch_model(source, {"hinge.stiffness": 4.0}, tmp_path / "p.xml")


@pytest.mark.parametrize(
    "body",
    [
        '<geom type="box" size="0.1 0.2 0.3" pos="0.1 0 0" euler="10 20 30" mass="2"/>',
        '<inertial pos="0.1 0 0" mass="2" diaginertia="0.1 0.2 0.15"/>',
        '<inertial pos="0.1 0 0" mass="2" fullinertia="0.1 0.2 0.15 0.01 0.02 0.03"/>',
    ],
)
def test_a_mass_is_written_with_its_inertia_and_a_damping_ratio_as_what_it_was(body, tmp_path):
    (tmp_path / "arm.xml").write_text(
        f"""<mujoco><worldbody><body name="arm"><joint name="hinge" axis="0 1 0"/>{body}</body>
        </worldbody><actuator><position name="servo" joint="hinge" kp="3" dampratio="1"/>
        </actuator></mujoco>"""
    )
    meant = Adjustable(load_model(str(tmp_path / "arm.xml")))
    kept = values_of(meant.model)["servo.kv"]
    meant.set({"arm.mass": 5.0})
    written = patched(tmp_path / "arm.xml", {"arm.mass": 5.0}, tmp_path)
    for field in ("body_mass", "body_inertia", "body_ipos", "dof_invweight0", "actuator_biasprm"):
        np.testing.assert_allclose(getattr(written, field), getattr(meant.model, field), rtol=1e-12)
    assert values_of(written)["servo.kv"] == pytest.approx(kept, rel=1e-12)


def test_user_data_of_someone_else_is_not_overwritten(tmp_path):
    with refusing(InvalidValueError, "angle.offset", "2 numbers"):
        patch_model(own_model(tmp_path), {"angle.offset": 0.5}, tmp_path / "patched.xml")


def test_a_sheath_without_a_name_goes_by_its_tendons(tmp_path):
    text = model_path("bench").read_text("utf-8")
    start, end = text.index('<instance name="sheath">'), text.index("<!-- what the sensors")
    config = text[start:end].split(">", 1)[1].rsplit("</instance>", 1)[0]
    text = text[:start] + text[end:]
    reel = '<plugin name="reel" plugin="tendon_mj.sheath" instance="sheath" tendon="tendon"/>'
    assert reel in text
    text = text.replace(
        reel, f'<plugin name="reel" plugin="tendon_mj.sheath" tendon="tendon">{config}</plugin>'
    )
    (tmp_path / "unnamed.xml").write_text(text)
    given = {"tendon.friction": 0.25, "tendon.constant_friction": 0.5}
    written = patched(tmp_path / "unnamed.xml", given, tmp_path)
    assert given.items() <= values_of(written).items()


def test_what_the_text_does_not_spell_out_is_refused(tmp_path):
    (tmp_path / "many.xml").write_text(
        "<mujoco><worldbody><replicate count='3' offset='1 0 0'><body>"
        "<joint name='hinge'/><geom size='0.1'/></body></replicate></worldbody></mujoco>"
    )
    with pytest.raises(TendonError, match="`attach` or `replicate` makes"):
        patch_model(tmp_path / "many.xml", {"hinge1.damping": 1.0}, tmp_path / "patched.xml")


@pytest.mark.parametrize(
    ("given", "interval", "kind", "facts"),
    [
        ({"sheath.fricton": 0.1}, None, UnknownNameError, ["did you mean 'sheath.friction'"]),
        ({"sheath.friction": -0.1}, None, InvalidValueError, ["sheath.friction"]),
        ({"sheath.reel_radius": 0.01}, None, TendonError, ["reel_radius", "reel_joint"]),
        ({"input_tension.scale": 0.0}, None, InvalidValueError, ["input_tension.scale"]),
        ({}, (0.0, 1.0), UnknownNameError, ["interval", "sheath.friction"]),
        ({"sheath.friction": 0.1}, (0.2, 0.1), InvalidValueError, ["sheath.friction", "0.2 … 0.1"]),
        ({"sheath.friction": 0.1}, (0.0, math.inf), InvalidValueError, ["sheath.friction", "inf"]),
        ({"sheath.friction": 0.1}, (math.nan, 1.0), InvalidValueError, ["sheath.friction", "nan"]),
    ],
)
def test_other_parameters_are_refused_and_nothing_is_written(
    given, interval, kind, facts, tmp_path
):
    within = {"sheath.friction": interval} if interval else None
    with refusing(kind, *facts):
        patch_model("bench", given, tmp_path / "model.xml", intervals=within)
    assert not list(tmp_path.iterdir())


MUSCLE = rope(
    "fixed 0 0 .3",
    "moved .1 0 .02",
    name="biceps",
    body='name="arm"',
    joint='name="elbow" axis="0 1 0" range="-60 60" damping=".1"',
    geom='type="capsule" fromto="0 0 0 .3 0 0" size=".02"',
    actuator='<muscle name="{name}" tendon="biceps"/>',
    sensor='<jointpos name="angle" joint="elbow"/>',
)


@pytest.mark.parametrize(
    ("force", "given", "differs"),
    [
        ("20", {"biceps.gear": 2.0}, True),
        ("-1", {"biceps.gear": 2.0}, False),  # its force is then that of an acceleration
        ("-1", {"arm.mass": 2.0, "elbow.armature": 0.01}, True),
    ],
)
def test_a_muscle_pulls_as_it_was_simulated(force, given, differs, tmp_path):
    """What MuJoCo computes when it compiles, acc0 and lengthrange, depends on such numbers."""
    (tmp_path / "arm.xml").write_text(MUSCLE.format(name=f'biceps" force="{force}'))
    model = load_model(str(tmp_path / "arm.xml"))
    time = np.linspace(0.0, 0.5, 51)
    recording = recorded(
        time,
        {"excitation_N": ("biceps", 0.3 * np.sin(6.0 * time) ** 2)},
        {"angle_rad": "angle"},
        tmp_path / "arm.xml",
        settle=0.0,
    )
    plain, simulated = (
        replay_recording(recording, model, parameters=p).columns["angle_rad"] for p in ({}, given)
    )
    written = patched(tmp_path / "arm.xml", given, tmp_path)
    told = replay_recording(recording, written).columns["angle_rad"]
    np.testing.assert_allclose(told, simulated, rtol=1e-12, atol=1e-12)
    assert (np.abs(plain - simulated).max() > 1e-4) == differs


@pytest.mark.parametrize("before", [1.0, -1.0])
@pytest.mark.parametrize("gear", [2.0, 0.5, -2.0])
def test_a_muscle_s_gear_is_what_mujoco_makes_of_it(before, gear, tmp_path):
    (tmp_path / "arm.xml").write_text(MUSCLE.format(name=f'biceps" gear="{before}'))
    adjustable = Adjustable(load_model(str(tmp_path / "arm.xml")))
    adjustable.set({"biceps.gear": -3.0})
    adjustable.set({"biceps.gear": gear})
    compiled = mujoco.MjModel.from_xml_string(MUSCLE.format(name=f'biceps" gear="{gear}'))
    np.testing.assert_allclose(adjustable.model.actuator_acc0, compiled.actuator_acc0, rtol=1e-12)
    np.testing.assert_allclose(
        adjustable.model.actuator_lengthrange, compiled.actuator_lengthrange, rtol=1e-3
    )


@pytest.mark.parametrize(
    ("effect", "scale"), [("creep", "creep_time"), ("stribeck_friction", "stribeck_velocity")]
)
def test_an_effect_without_its_scale_is_refused_as_mjcf_does(effect, scale, tmp_path):
    with refusing(InvalidValueError, f"sheath: {effect} = 0.2", scale):
        patch_model("bench", {f"sheath.{effect}": 0.2}, tmp_path / "model.xml")
    both = {f"sheath.{effect}": 0.2, f"sheath.{scale}": 0.1}
    assert patch_model("bench", both, tmp_path / "model.xml").is_file()


SPRUNG = """<mujoco>
<default><default class="sprung"><joint springdamper="0.1 1"/></default></default>
<worldbody><body name="upper"><joint name="a" axis="0 1 0" {a}/><geom size=".02" pos=".1 0 0"/>
<body name="lower" pos=".2 0 0"><joint {name} class="sprung" axis="0 1 0"/>
<geom size=".02" pos=".1 0 0"/></body></body></worldbody></mujoco>"""


@pytest.mark.parametrize("given", [{"lower.mass": 0.3}, {"a.damping": 0.02}, {"b.stiffness": 0.5}])
def test_a_spring_damper_keeps_what_it_was_made_of_before_the_masses_changed(given, tmp_path):
    path = tmp_path / "arm.xml"
    path.write_text(SPRUNG.format(a='springdamper="0.2 0.5"', name='name="b"'))
    adjustable = Adjustable(load_model(str(path)))
    adjustable.set(given)
    written = patched(path, given, tmp_path)
    for field in ("jnt_stiffness", "dof_damping"):
        meant, got = getattr(adjustable.model, field), getattr(written, field)
        np.testing.assert_array_equal(meant, got)


def test_a_spring_damper_without_a_name_is_refused_where_its_masses_change(tmp_path):
    path = tmp_path / "arm.xml"
    path.write_text(SPRUNG.format(a="", name=""))
    patch_model(path, {"a.damping": 0.1}, tmp_path / "new.xml")
    with refusing(TendonError, "new.xml", "dof_damping"):
        patch_model(path, {"lower.mass": 0.3}, tmp_path / "new.xml")


PENDULUM = """<mujoco><worldbody><body>
  <joint name="hinge" axis="0 1 0" damping="0.01" {}/>
  <geom type="capsule" size="0.01" fromto="0 0 0 0.1 0 0" mass="0.1"/>
</body></worldbody></mujoco>"""


def crept(model):
    """Angle by which a pendulum moves in two seconds; its friction would hold twice its weight."""
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=round(2.0 / model.opt.timestep))
    return abs(float(data.qpos[0]))


def test_a_joint_that_is_given_dry_friction_sticks_as_does_what_is_written(tmp_path):
    plain = tmp_path / "plain.xml"
    plain.write_text(PENDULUM.format(""))
    given = {"hinge.frictionloss": 0.1}
    adjustable = Adjustable(load_model(str(plain)))
    adjustable.set(given)
    assert crept(adjustable.model) < 1e-4
    assert crept(patched(plain, given, tmp_path)) == crept(adjustable.model)


@pytest.mark.parametrize(
    "own", ['frictionloss="0.05"', 'solreffriction="0.01 1" solimpfriction="0.8 0.9 0.01 0.5 2"']
)
def test_softness_that_a_model_chose_stays(own, tmp_path):
    chosen = tmp_path / "chosen.xml"
    chosen.write_text(PENDULUM.format(own))
    model = load_model(str(chosen))
    made = patched(chosen, {"hinge.frictionloss": 0.1}, tmp_path)
    np.testing.assert_array_equal(made.dof_solref, model.dof_solref)
    np.testing.assert_array_equal(made.dof_solimp, model.dof_solimp)
    assert crept(made) > 1e-2
