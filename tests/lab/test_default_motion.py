import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction
from tendon_mj.errors import RecordingError, TendonWarning, UnknownNameError
from tendon_mj.lab.motion import (
    control_limits,
    default_motion,
    demonstration_time,
    read_motion,
    record_frames,
    resting,
)
from tendon_mj.models import Bench, Joint, build_bench, build_joint
from tests.refusals import refusing
from tests.rigs import compiled, lever

TIMES = np.linspace(0.0, 12.0, 2401)


@pytest.mark.parametrize(
    ("name", "model", "actuator", "size"),
    [
        ("bench", build_bench(Bench()).compile(), "reel", 0.002),
        ("joint", build_joint(Joint()).compile(), "command", np.deg2rad(60.0)),
        ("mine", build_bench(Bench()).compile(), "reel", 0.001),
    ],
)
def test_a_named_model_swings_one_actuator_from_rest(name, model, actuator, size):
    drive = default_motion(name, model)
    control = np.array([drive(t) for t in TIMES])
    k = model.actuator(actuator).id
    assert control.shape == (len(TIMES), model.nu)
    assert control[0, k] == 0.0
    assert [control[:, k].max(), -control[:, k].min()] == pytest.approx([size, size], rel=1e-3)
    assert not np.delete(control, k, axis=1).any()


def test_any_other_model_moves_one_actuator_after_the_other_within_its_control_range():
    ranges = ('ctrlrange="2 5"', 'ctrlrange="-1 3"', 'ctrlrange="-4 0"', "")
    model = compiled(lever("".join(f'<motor joint="j" {given}/>' for given in ranges)))
    drive = default_motion("mine", model)
    control = np.array([drive(t) for t in TIMES])
    rest = [2.0, 0.0, 0.0, 0.0]
    np.testing.assert_array_equal(control[0], rest)
    assert ((np.abs(control - rest) > 1e-9).sum(axis=1) <= 1).all(), "so that opposed ones move it"
    np.testing.assert_allclose(control.max(axis=0), [4.4, 2.4, 0.0, 1.0], atol=1e-4)
    np.testing.assert_allclose(control.min(axis=0), [2.0, -0.8, -3.2, -1.0], atol=1e-4)
    assert np.abs(np.diff(control, axis=0)).max() < 0.05, "without a jump"


def test_a_muscle_without_a_range_is_activated_and_never_pushed():
    model = compiled(lever('<muscle joint="j" lengthrange="0 1"/>'))
    drive = default_motion("mine", model)
    control = np.array([drive(t) for t in TIMES])
    assert control.min() == 0.0
    assert control.max() == pytest.approx(0.8, abs=1e-4)
    assert [limit[0] for limit in control_limits(model)] == [0.0, 1.0]


def test_many_actuators_all_move_within_the_time_of_a_demonstration():
    model = compiled(lever('<motor joint="j"/>' * 30))
    times = np.arange(0.0, demonstration_time(model), 0.01)
    drive = default_motion("mine", model)
    control = np.array([drive(t) for t in times])
    assert (control.max(axis=0) > 0.99).all()


SERVO = '<general tendon="{}" gainprm="1e4" biastype="affine" biasprm="0 -1e4" ctrlrange="0.1 2"/>'


def servos(key=""):
    """A lever with a servo on each of two tendons; the first has a sheath."""
    spec = mujoco.MjSpec.from_string(f"""<mujoco><worldbody>
      <site name="a"/><site name="b" pos=".1 0 .1"/>
      <body pos=".2 0 0"><joint name="j" axis="0 1 0" range="-90 90" limited="true"/>
        <geom size=".02" pos=".1 0 0"/><site name="c" pos=".1 0 .02"/></body></worldbody>
      <tendon><spatial name="one"><site site="a"/><site site="b"/><site site="c"/></spatial>
        <spatial name="two"><site site="a"/><site site="c"/></spatial></tendon>
      <actuator>{SERVO.format("one")}{SERVO.format("two")}</actuator>{key}</mujoco>""")
    with pytest.warns(TendonWarning, match="push"):
        return add_friction(spec, "one", friction=0.1).compile()


def test_a_servo_rests_where_it_has_no_force():
    model = servos()
    data = resting(model)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.actuator_force, 0.0, atol=1e-8)
    np.testing.assert_allclose(default_motion("mine", model)(0.0), data.ctrl)
    frames = record_frames(model, lambda _: data.ctrl, duration=0.2, fps=5, at_rest=True)
    assert frames.cables["one_sheath"].tensions[0].max() == pytest.approx(0.0, abs=1e-6)


def test_a_keyframe_is_the_rest_and_its_controls_if_it_has_any():
    model = servos('<keyframe><key qpos="0.5"/></keyframe>')
    data = resting(model)
    mujoco.mj_forward(model, data)
    assert data.qpos[0] == 0.5
    np.testing.assert_allclose(data.actuator_force, 0.0, atol=1e-8)
    data = resting(servos('<keyframe><key qpos="0.5" ctrl="0.3 0.4"/></keyframe>'))
    assert data.ctrl.tolist() == [0.3, 0.4]


def test_the_actuator_of_a_tendon_in_a_sheath_only_pulls():
    model = servos()
    rest = resting(model).ctrl
    drive = default_motion("mine", model)
    control = np.array([drive(t) for t in TIMES])
    assert control[:, 0].max() == rest[0], "a longer tendon would be pushed"
    assert control[:, 0].min() < rest[0]
    assert control[:, 1].min() < rest[1] < control[:, 1].max()


def test_of_chosen_tendons_alone_the_actuators_move():
    model = servos()
    drive = default_motion("mine", model, ["one"])
    control = np.array([drive(t) for t in TIMES])
    assert np.ptp(control, axis=0).astype(bool).tolist() == [True, False]


def test_a_bench_without_its_reel_is_any_other_model():
    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    assert default_motion("bench", model)(1.0).shape == (0,)


@pytest.mark.parametrize("name", ["left_m", "mm", "speed_rad_per_s"])
@pytest.mark.parametrize("ending", ["_N", "_kN"])
def test_an_actuator_whose_name_is_or_ends_in_a_unit_is_driven(name, ending, tmp_path):
    motors = "".join(f'<motor name="{motor}" joint="j"/>' for motor in ("other", name))
    model = compiled(lever(motors, joint='name="j" type="slide"'))
    path = tmp_path / "motion.csv"
    path.write_text(f"time_s,{name}{ending}\n0,0\n2,4\n")
    drive, _ = read_motion(path, model)
    assert drive(1.0) == pytest.approx([0.0, 2000.0 if ending == "_kN" else 2.0])


def test_a_table_moves_the_actuators_that_it_names(tmp_path):
    model = build_joint(Joint()).compile()
    table = tmp_path / "mine.csv"
    table.write_text("time_s,command_rad\n1,0\n3,0.5\n")
    drive, duration = read_motion(table, model)
    assert duration == 2.0
    k = model.actuator("command").id
    assert drive(1.0)[k] == pytest.approx(0.25)
    assert drive(9.0)[k] == pytest.approx(0.5)
    assert np.abs(np.delete(drive(1.0), k)).max() == 0.0
    table.write_text("time_s,comand_rad\n1,0\n3,0.5\n")
    with refusing(UnknownNameError, str(table), "'command'"):
        read_motion(table, model)


@pytest.mark.parametrize("columns", ["reel_N", "reel_kN", "reel_deg", "reel_m,reel_rad"])
def test_a_column_in_another_unit_than_the_control_is_refused(columns, tmp_path):
    rows = "0,0,0\n1,1,1\n" if "," in columns else "0,0\n1,1\n"
    (tmp_path / "motion.csv").write_text(f"time_s,{columns}\n{rows}")
    column = columns.split(",")[-1]
    with refusing(RecordingError, f"column {column!r}", "[m]", "'reel_m'"):
        read_motion(tmp_path / "motion.csv", build_bench(Bench()).compile())


@pytest.mark.parametrize("columns", ["twitch_s,twitch_N", "twitch_mm,twitch_rad"])
def test_two_columns_of_one_actuator_are_refused(columns, tmp_path):
    """Of a muscle, whose control has no unit of its own."""
    muscle = '<muscle name="twitch" joint="j" lengthrange="-1 1"/>'
    model = compiled(lever(muscle, joint='name="j" range="-1 1"'))
    (tmp_path / "motion.csv").write_text(f"time_s,{columns}\n0,0,0\n1,1,1\n")
    with refusing(RecordingError, "motion.csv", "'twitch'"):
        read_motion(tmp_path / "motion.csv", model)
