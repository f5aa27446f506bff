"""Laws of what a column drives: several actuators at once, and joints that it prescribes."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from experiments.one_capstan import build, record
from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings import Recording, read_recording, write_recording
from tendon_mj.lab.replay import Simulator, patch_model, replay_recording
from tendon_mj.models import load_model
from tests.lab.recorded import recorded
from tests.refusals import refusing

TIME = np.arange(0.0, 1.0, 0.02)
MOTOR = 40.0 * np.sin(5.0 * TIME)  # [deg]
PLAY = {f"{cable}_sheath.backlash": 4e-4 for cable in ("agonist", "antagonist")}
ARM = """
<mujoco>
  <compiler angle="radian"/>
  <option timestep="0.001" integrator="{}"/>
  <worldbody>
    <body name="upper">
      <joint name="shoulder" axis="0 1 0" {}/>
      <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.03" contype="0"/>
      <body name="lower" pos="0.3 0 0">
        <joint name="elbow" axis="0 1 0" damping="0.05" stiffness="2"/>
        <geom type="capsule" fromto="0 0 0 0.25 0 0" size="0.02" contype="0"/>
      </body>
    </body>
    <body name="ball" pos="1 0 0"><joint name="ball" type="ball"/><geom size="0.1"/></body>
  </worldbody>
  <actuator>
    <motor name="shoulder_motor" joint="shoulder"/>
    <position name="elbow" joint="elbow" kp="20" kv="0.5"/>
  </actuator>
  <sensor>
    <jointpos name="shoulder_angle" joint="shoulder"/>
    <jointpos name="elbow_angle" joint="elbow"/>
  </sensor>
</mujoco>
"""


def arm(drive: dict[str, str], columns: dict[str, np.ndarray], time: np.ndarray) -> Recording:
    driven = {column: (drive[column], series) for column, series in columns.items()}
    read = {f"{joint}_rad": f"{joint}_angle" for joint in ("shoulder", "elbow")}
    return recorded(time, driven, read, "arm", settle=0.0)


@pytest.fixture(scope="module")
def wrists() -> dict[str, mujoco.MjModel]:
    return {way: build(way).compile() for way in ("reel", "prescribed")}


def wrist(way: str) -> Recording:
    return record("loops", TIME, MOTOR, np.zeros((TIME.size, 3)), way, "wrist")


def assert_same(a: Recording, b: Recording, rtol: float = 0.0) -> None:
    for column in a.measured:
        atol = rtol * float(np.abs(a.columns[column]).max())
        np.testing.assert_allclose(a.columns[column], b.columns[column], rtol=0, atol=atol)


@pytest.mark.parametrize("integrator", ["Euler", "implicit", "implicitfast"])
def test_a_prescribed_joint_retraces_what_a_motor_did_and_so_does_all_that_hangs_on_it(integrator):
    model = mujoco.MjModel.from_xml_string(ARM.format(integrator, 'damping="0.1"'))
    time = np.arange(0.0, 1.0, 0.001)
    pushed = {"torque_Nm": 12.0 + 8.0 * np.sin(9.0 * time)}
    swung = replay_recording(arm({"torque_Nm": "shoulder_motor"}, pushed, time), model)
    assert np.ptp(swung.columns["elbow_rad"]) > 0.1
    angle = {"encoder_rad": swung.columns["shoulder_rad"]}
    recording = arm({"encoder_rad": "shoulder"}, angle, time)
    assert_same(swung, replay_recording(recording, model), rtol=1e-7)


def test_no_load_limit_friction_or_servo_moves_a_prescribed_joint():
    held = 'stiffness="500" damping="20" frictionloss="30" limited="true" range="-0.1 0.1"'
    model = mujoco.MjModel.from_xml_string(ARM.format("implicitfast", held))
    angle = 0.9 * np.sin(4.0 * TIME)
    recording = arm({"encoder_rad": "shoulder"}, {"encoder_rad": angle}, TIME)
    shown = replay_recording(recording, model)
    np.testing.assert_allclose(shown.columns["shoulder_rad"], angle, rtol=0, atol=1e-10)


def test_a_prescribed_spool_is_two_reels_and_its_play_has_no_soft_flank(wrists):
    reels = replay_recording(wrist("reel"), wrists["reel"], parameters=PLAY)
    spool = replay_recording(wrist("prescribed"), wrists["prescribed"], parameters=PLAY)
    plain = replay_recording(wrist("prescribed"), wrists["prescribed"])
    assert_same(reels, spool, rtol=1e-9)
    assert np.abs(plain.columns["wrist_rad"] - spool.columns["wrist_rad"]).max() > 0.01


def test_a_prescribed_replay_is_the_same_to_the_bit_in_any_company(wrists):
    recording = wrist("prescribed")
    once = replay_recording(recording, wrists["prescribed"], parameters=PLAY)
    sets = [PLAY, {"spool.command_delay": 0.01}, PLAY]
    for series in np.array(Simulator([recording], wrists["prescribed"], threads=2)(sets))[
        [0, 2], 0
    ]:
        for column in recording.measured:
            np.testing.assert_array_equal(series[column], once.columns[column])


def test_a_column_of_two_actuators_is_the_column_written_twice_to_the_bit(wrists):
    one = wrist("reel")
    motor = one.columns["motor_rad"]
    two = replace(
        one,
        columns={**one.columns, "again_rad": motor},
        drive={"motor_rad": "agonist_reel", "again_rad": "antagonist_reel"},
        known={**one.known, "antagonist_reel.command_scale": -0.008},
    )
    assert one.drive == {"motor_rad": ("agonist_reel", "antagonist_reel")}
    assert_same(replay_recording(one, wrists["reel"]), replay_recording(two, wrists["reel"]))


def test_scale_offset_and_delay_of_a_joint_act_and_are_written_with_the_model(tmp_path, wrists):
    path = tmp_path / "wrist.xml"
    path.write_text(build("prescribed").to_xml())
    recording = replace(wrist("prescribed"), model=str(path))
    command = {"spool.command_scale": 0.5, "spool.command_offset": 0.1, "spool.command_delay": 0.02}
    motor = recording.columns["motor_rad"]
    moved = 0.5 * np.concatenate([motor[:1], motor[:-1]]) + 0.1
    by_hand = replace(recording, columns={**recording.columns, "motor_rad": moved})
    expected = replay_recording(by_hand)
    assert_same(expected, replay_recording(recording, parameters=command), rtol=1e-9)
    patched = load_model(str(patch_model(path, command, tmp_path / "patched.xml")))
    assert_same(expected, replay_recording(recording, patched), rtol=1e-9)


def test_several_names_are_written_and_read_back_with_and_without_hold(tmp_path, wrists):
    for hold in ((), ("motor_rad",)):
        recording = replace(wrist("reel"), hold=hold)
        again = read_recording(write_recording(recording, tmp_path / "loops.csv"))
        assert again == recording
        assert again.driven == [("motor_rad", "agonist_reel"), ("motor_rad", "antagonist_reel")]


@pytest.mark.parametrize(
    ("drive", "says"),
    [
        ({"motor_rad": ("agonist_reel", "agonist_reel")}, "already drives 'agonist_reel'"),
        ({"motor_rad": ()}, "[drive] 'motor_rad'"),
        ({"motor_rad": ("agonist_reel", "spoool")}, "'spoool'"),
    ],
)
def test_a_drive_of_nothing_of_one_twice_or_of_what_is_not_there_is_refused(wrists, drive, says):
    with refusing(RecordingError, says):
        Simulator([replace(wrist("reel"), drive=drive)], wrists["reel"])


def test_joints_that_cannot_be_prescribed_are_refused_by_name():
    for integrator, joint in (("RK4", "shoulder"), ("Euler", "ball")):
        model = mujoco.MjModel.from_xml_string(ARM.format(integrator, ""))
        with refusing(RecordingError, "'angle_rad'", integrator if joint == "shoulder" else joint):
            replay_recording(arm({"angle_rad": joint}, {"angle_rad": 0.1 * TIME}, TIME), model)


def test_an_actuator_goes_before_a_joint_of_its_name():
    model = mujoco.MjModel.from_xml_string(ARM.format("implicitfast", ""))
    recording = arm({"elbow_command_rad": "elbow"}, {"elbow_command_rad": 0.3 + 0.0 * TIME}, TIME)
    shown = replay_recording(recording, model)
    assert shown.columns["elbow_rad"][0] == 0.0, "a servo takes its time, a prescription none"


def test_no_effect_is_sought_on_a_prescribed_joint(wrists):
    joints = Simulator([wrist("prescribed")], wrists["prescribed"]).joints
    assert joints == {"spool": True, "wrist": False}
