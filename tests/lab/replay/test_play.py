"""Laws of a play behind the tendon, and of limits as parameters."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from tendon_mj.attach import add_cable_drive, add_friction
from tendon_mj.lab.replay import Adjustable, Simulator, patch_model, replay_recording
from tendon_mj.models import load_model
from tests.lab.recorded import recorded

ARM = """<mujoco><compiler angle="degree"/>
<option timestep=".001" integrator="implicitfast" gravity="0 {g} 0"/>
<worldbody><site name="a"/><site name="b" pos=".1 0 0"/>
<body pos=".2 0 0"><inertial pos="0 -.2 0" mass=".5" diaginertia=".01 .01 .01"/>
<joint name="arm" damping="1" {more}/></body>
<body pos="1 0 0"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
<joint name="stop" range="-10 20"/></body></worldbody>
<tendon>
<spatial name="one"><site site="a"/><site site="b"/></spatial>
<spatial name="two"><site site="a"/><site site="b"/></spatial>
</tendon>
<sensor><jointpos name="angle" joint="arm"/></sensor></mujoco>"""
DEFAULTS = """<default><joint ref="0.3" springdamper="0.1 1"/>
<tendon stiffness="100" damping="3" frictionloss="2"/></default>"""
RADIUS, WIDTH = 0.03, 0.04
TIME = np.arange(0.0, 6.0, 0.03)


def arm(folder, g=-9.81, more="", stiffness=2e3, turned=("arm", "arm")):
    """An arm that hangs from a pulley, which two cables turn; or two arms, with one cable each."""
    spec = mujoco.MjSpec.from_string(ARM.format(g=g, more=more))
    for tendon, side, joint in zip(("one", "two"), (-1.0, 1.0), turned, strict=True):
        law = {"friction": 0.2, "axial_stiffness": stiffness, "pretension": 30.0, "extra_bend": 1.0}
        ends = {"reel": f"{tendon}_reel", "output_joint": joint, "output_radius": side * RADIUS}
        add_friction(spec, tendon, inner_guides=3, sensors=("input_tension",), **law, **ends)
    path = folder / "arm.xml"
    path.write_text(spec.to_xml())
    return path


def motion(path, wave=None, drive=None):
    if drive is not None:
        still = 0.0 * TIME
        read = {"read_N": ("j_cable_input_tension", 0.2)}
        return recorded(TIME, {"drive_rad": (drive, still)}, read, path, settling_time=None)
    drive = RADIUS * 0.3 * (1.0 - np.cos(1.5 * TIME)) if wave is None else wave
    return recorded(
        TIME,
        {"one_m": ("one_reel", drive), "two_m": ("two_reel", -drive)},
        {"arm_rad": ("angle", 1e-3), "one_N": ("input_tension", 0.2)},
        path,
        settling_time=None,
    )


def test_the_load_decides_on_which_flank_the_joint_is(tmp_path):
    held = np.interp(TIME, [0.0, 3.0], [0.0, RADIUS * 0.5])
    for sign in (1.0, -1.0):
        made = motion(arm(tmp_path), sign * held)
        turned, with_play = (
            replay_recording(made, parameters=values).columns["arm_rad"][-1]
            for values in ({}, {"arm_play.range_width": WIDTH})
        )
        assert with_play - turned == pytest.approx(-sign * WIDTH / 2.0, rel=0.05)


def test_a_joint_that_is_loaded_where_angles_are_zeroed_begins_on_its_flank(tmp_path):
    made = motion(arm(tmp_path, more='stiffness="2" springref="40"'), np.zeros(TIME.size))
    shown = replay_recording(made, parameters={"arm_play.range_width": WIDTH})
    assert abs(shown.columns["arm_rad"] - replay_recording(made).columns["arm_rad"]).max() < 1e-3


def test_without_a_width_nothing_changes_and_a_narrow_play_changes_little(tmp_path):
    made = motion(arm(tmp_path))
    ((plain,), (none,), (narrow,)) = Simulator([made], threads=1)(
        [{}, {"arm_play.range_width": 0.0}, {"arm_play.range_width": 1e-6}]
    )
    assert np.array_equal(plain["arm_rad"], none["arm_rad"])
    for column, measured in made.measured.items():
        assert abs(narrow[column] - plain[column]).max() < measured.noise


def test_a_joint_without_a_width_has_no_play_beside_one_that_has(tmp_path):
    made = motion(arm(tmp_path, turned=("arm", "stop")))
    values = {"arm_play.range_width": WIDTH, "stop_play.range_width": 0.0}
    alone = replay_recording(made, parameters={"arm_play.range_width": WIDTH})
    for simulator in (Simulator([made], threads=1), Simulator([made], threads=1).split(2)):
        ((one,), (both,)) = simulator([{"arm_play.range_width": WIDTH}, values])
        assert np.array_equal(one["arm_rad"], both["arm_rad"])
        assert abs(one["arm_rad"] - alone.columns["arm_rad"]).max() < 1e-3


def test_a_pulley_takes_no_longer_steps_than_the_model_s(tmp_path):
    """In longer ones it would ring between guides that hold."""
    own = Simulator([motion(arm(tmp_path))], threads=1)
    play = [{"arm_play.range_width": WIDTH}]
    ((searched,),), ((simulated,),) = own.in_steps(2.0)(play), own(play)
    for column, series in simulated.items():
        assert np.array_equal(searched[column], series)


@pytest.mark.parametrize("stiffness", [2e3, 1e6])
def test_a_pulley_turns_by_root_2_in_a_step_and_has_a_tenth_of_its_joint_s_inertia(
    stiffness, tmp_path
):
    """It turns by ωh = h √(k/I), of which 2 is unstable; k of two cables in four segments."""
    path = arm(tmp_path, stiffness=stiffness)
    played = patch_model(path, {"arm_play.range_width": WIDTH}, tmp_path / "played.xml")
    model = load_model(str(played))
    pulley, joint = (model.joint(name).dofadr[0] for name in ("arm_pulley", "arm"))
    per_angle = 2.0 * 4.0 * stiffness / model.tendon_length0[0] * RADIUS**2
    inertia = min(0.5 * per_angle * model.opt.timestep**2, 0.1 * model.dof_M0[joint])
    assert model.dof_armature[pulley] == pytest.approx(inertia, rel=1e-3)


def test_the_inertia_of_a_pulley_is_not_felt(tmp_path):
    """It goes with the square of the step, and a quarter of the step changes little."""
    path = arm(tmp_path)
    ((coarse,),) = Simulator([motion(path)], threads=1)([{"arm_play.range_width": WIDTH}])
    path.write_text(path.read_text().replace('timestep="0.001"', 'timestep="0.00025"'))
    ((fine,),) = Simulator([motion(path)], threads=1)([{"arm_play.range_width": WIDTH}])
    assert abs(coarse["one_N"] - fine["one_N"]).max() < 0.06


def test_a_written_model_has_the_play_that_was_simulated(tmp_path):
    made, values = motion(arm(tmp_path)), {"arm_play.range_width": WIDTH, "arm.damping": 0.2}
    ((simulated,),) = Simulator([made])([values])
    model = load_model(str(patch_model(made.model, values, tmp_path / "played.xml")))
    shown = replay_recording(made, model)
    assert np.array_equal(shown.columns["arm_rad"], simulated["arm_rad"])
    assert Adjustable(model).parameters()["arm_play.range_width"].value == WIDTH


def test_limits_of_a_model_are_parameters(tmp_path):
    path = arm(tmp_path)
    known = Adjustable(load_model(str(path))).parameters()
    ends = [known[f"stop.range_{end}"].value for end in ("low", "high", "width")]
    assert ends == pytest.approx(np.radians([-10.0, 20.0, 30.0]))
    for values in ({"stop.range_width": 1.0}, {"stop.range_low": -1 / 3, "stop.range_high": 2 / 3}):
        written = load_model(str(patch_model(path, values, tmp_path / "limited.xml")))
        assert written.joint("stop").range == pytest.approx([-1 / 3, 2 / 3])


def driven(folder, **changed):
    """A joint with a load that a servo turns by two cables, with play at its drum."""
    spec = mujoco.MjSpec.from_string("""<mujoco><option timestep=".001" integrator="implicitfast"/>
    <worldbody><body><joint name="j" axis="0 1 0" damping=".01"/>
    <geom size=".02" pos="0 0 -.1" mass=".1"/></body></worldbody>
    <actuator><position name="m" joint="j" kp="4" kv=".1"/></actuator></mujoco>""")
    cable = {"radius": 0.01, "bend": 3.0, "friction": 0.1, "pretension": 20.0, "armature": 0.002}
    cable |= {"motor": True, "axial_stiffness": 5e3, "length": 0.5}
    add_cable_drive(spec, "m", **cable | changed)
    path = folder / "driven.xml"
    path.write_text(spec.to_xml())
    return path


@pytest.mark.parametrize("axial_damping", [0.0, 5.0, 20.0])
def test_the_cables_of_a_motor_carry_its_drum_to_a_flank_and_rest_in_between(
    axial_damping, tmp_path
):
    """In the gap they are as tight as each other, the motor is free and friction holds the load."""
    path = driven(tmp_path, axial_damping=axial_damping)
    width = {"j_motor_drum_play.range_width": 0.1}
    model = load_model(str(patch_model(path, width, tmp_path / "played.xml")))
    data = mujoco.MjData(model)
    joint, motor, drum = (data.joint(name) for name in ("j", "j_motor", "j_motor_drum"))

    def turn(begin, end, seconds):
        steps = round(seconds / model.opt.timestep)
        for share in np.linspace(0.0, 1.0, steps):
            data.ctrl[0] = begin + (end - begin) * share
            mujoco.mj_step(model, data)
        return motor.qpos[0] - drum.qpos[0], data.actuator("m").force[0]

    ahead, torque = turn(0.0, 0.8, 1.0)
    assert ahead == pytest.approx(0.05, abs=1e-3)
    assert torque > 0.1
    seen = []
    for k in range(12):
        gap, torque = turn(0.8 - 0.02 * k, 0.78 - 0.02 * k, 0.05)
        seen.append((gap, abs(torque), joint.qpos[0]))
    free = np.array([row for row in seen if abs(row[0]) < 0.04])
    assert len(free) >= 3
    assert free[:, 1].max() < 0.03  # friction of the motor's own inertia and rate gain alone
    assert np.ptp(free[:, 2]) < 2e-3


def test_a_model_with_play_has_the_parameters_of_the_model_without(tmp_path):
    path = driven(tmp_path)
    plain = Adjustable(load_model(str(path))).names()
    for play in ("j_motor_drum_play.range_width", "j_play.range_width"):
        played = patch_model(path, {play: 0.1}, tmp_path / "played.xml")
        assert {*plain} < {*Adjustable(load_model(str(played))).names()}


@pytest.mark.parametrize("name", ["left_drum", "left_pulley"])
def test_a_joint_may_be_called_like_a_drum_or_a_pulley(name, tmp_path):
    path = driven(tmp_path)
    path.write_text(path.read_text().replace("j_motor", name))
    width = {f"{name}_drum_play.range_width": 0.1}
    assert {*width} < {*Simulator([motion(path, drive="m")], threads=1).parameters}
    played = load_model(str(patch_model(path, width, tmp_path / "played.xml")))
    assert played.joint(f"{name}_drum").id >= 0
    geared = "j_cable_input_tension.efficiency"
    assert geared in {*Adjustable(load_model(str(path))).names()} & {*Adjustable(played).names()}


def test_what_a_model_gives_joints_and_tendons_by_default_is_not_that_of_a_play(tmp_path):
    path = driven(tmp_path)
    text = path.read_text().replace("<option", DEFAULTS + "<option").replace(' ref="0"', "")
    own = '<spatial stiffness="0" damping="0" frictionloss="0" '
    path.write_text(text.replace("<spatial ", own))
    played = load_model(str(patch_model(path, {"j_play.range_width": 0.1}, tmp_path / "p.xml")))
    data = mujoco.MjData(played)
    mujoco.mj_forward(played, data)
    pulley, k = played.joint("j_pulley"), played.tendon("j_play").id
    assert played.qpos0[pulley.qposadr[0]] == pytest.approx(played.qpos0[0]) != 0.0
    assert data.tendon("j_play").length[0] == pytest.approx(0.0)
    of_joint = np.ravel(pulley.stiffness).sum() + np.ravel(played.dof_damping[pulley.dofadr]).sum()
    own = played.tendon_stiffness[k], played.tendon_damping[k], played.tendon_frictionloss[k]
    assert [of_joint, *(np.ravel(value).sum() for value in own)] == [0.0] * 4


def test_one_cable_alone_rests_on_its_flank_and_has_no_such_play(tmp_path):
    names = set(Simulator([motion(arm(tmp_path))], threads=1).parameters)
    assert not any(name.endswith("_drum_play.range_width") for name in names)
