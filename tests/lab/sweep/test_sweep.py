"""Laws of a sweep: each rollout is its own single run, wherever and in whatever company it runs."""

import dataclasses
import importlib

import mujoco
import numpy as np
import pytest

from experiments.one_capstan import build, record
from tendon_mj.errors import InvalidValueError, RecordingError
from tendon_mj.lab.recordings import read_recording
from tendon_mj.lab.replay import Simulator, replay_error, replay_recording
from tendon_mj.lab.sweep import Sweep, motion_recording, read_policy, run_sweep
from tendon_mj.lab.sweep.rollouts import FAILED
from tendon_mj.lab.sweep.sweep import batch_size, recording_digest
from tendon_mj.lab.workers import Workers
from tendon_mj.models import example_recording, load_model
from tests.refusals import refusing
from tests.rigs import lever

VARIED = (
    "flexor.friction=0.05:0.3",
    "mcp.armature=1e-5:1e-4",  # changes what MuJoCo computes from a model before it runs
    "pip.mass=0.004:0.01",
    "flexor_sheath.drawn_bend=2:4",
    "flexor_angle.command_scale=0.9:1.1",
    "extensor_angle.command_delay=0:0.02",
    "mcp_angle.lag=0:0.01",
    "gravity.z=-9.81:0",
)


@pytest.fixture(scope="module")
def finger():
    return load_model("finger")


def finger_sweep(model, *varied, duration=0.06, **options):
    recording = motion_recording("finger", model, "tap", duration)
    return Sweep(model, recording, varied, settle=0.02, **options)


def test_each_rollout_is_its_own_single_run_to_the_bit(finger):
    sweep = finger_sweep(finger, *VARIED, draws=6, seed=4)
    table = sweep.rollouts.of(sweep.batch(0, 6))
    recording = sweep.rollouts.recording
    single = Simulator([recording], finger, settle=0.02, threads=1)
    values = sweep.design.values(0, 6)
    targets = [axis.targets[0] for axis in sweep.axes]
    for k in reversed(range(6)):
        ((series,),) = single([dict(zip(targets, values[k].tolist(), strict=True))])
        for column, measured in recording.measured.items():
            assert table[f"{measured.sensor}.final"][k] == series[column][-1]
            assert table[f"{measured.sensor}.max"][k] == series[column].max()
    assert len(np.unique(table["flexor_output_tension.final"])) == 6


def test_numbers_depend_on_neither_processes_nor_batches_and_a_run_goes_on(
    finger, tmp_path, monkeypatch
):
    pytest.importorskip("pyarrow", reason="the extra tendon-mj[parquet] is not installed")
    module = importlib.import_module("tendon_mj.lab.sweep.sweep")
    monkeypatch.setattr(module, "batch_size", lambda seconds, rollouts: 5)
    sweep = finger_sweep(finger, "*.friction=0.05:0.3", "mcp.damping=0:0.01:2", draws=8)
    result = run_sweep(sweep, tmp_path, on=Workers(processes=2))
    whole = sweep.rollouts.of(sweep.batch(0, sweep.design.rollouts))
    table = result.table.read()
    assert table.keys() == whole.keys()
    for name, column in whole.items():
        assert (table[name] == column).all()
    lost, *kept, broken = sorted((tmp_path / "rollouts").glob("*.parquet"))
    lost.unlink()
    broken.write_bytes(broken.read_bytes()[:100])
    before = {path: path.stat().st_mtime_ns for path in kept}
    said = []
    run_sweep(sweep, tmp_path, on=Workers(processes=1), progress=lambda *a: said.append(a[1:]))
    assert {path: path.stat().st_mtime_ns for path in kept} == before
    assert (result.table.read()["mcp.damping"] == whole["mcp.damping"]).all()
    assert [said[0], said[-1]] == [(10, 16), (16, 16)]
    other = finger_sweep(finger, "*.friction=0.05:0.3", "mcp.damping=0:0.01:2", draws=8, seed=3)
    with refusing(InvalidValueError, str(tmp_path), "seed is 0 there and 3 here"):
        run_sweep(other, tmp_path)
    heavy = load_model("finger")
    heavy.body("pip").mass *= 2
    other = finger_sweep(heavy, "*.friction=0.05:0.3", "mcp.damping=0:0.01:2", draws=8)
    with refusing(InvalidValueError, str(tmp_path), "model finger is"):
        run_sweep(other, tmp_path)


def test_the_error_of_a_recording_is_that_of_its_replay():
    recording = read_recording(example_recording())
    short = dataclasses.replace(
        recording,
        time=recording.time[:60],
        columns={name: values[:60] for name, values in recording.columns.items()},
    )
    model = load_model(recording.model)
    sweep = Sweep(model, short, ["sheath.friction=0.1,0.2"], measured=True, outputs=["*.error"])
    table = sweep.rollouts.of(sweep.batch(0, 2))
    for k, friction in enumerate((0.1, 0.2)):
        replayed = replay_recording(short, model, parameters={"sheath.friction": friction})
        for column, misfit in replay_error(short, replayed).items():
            sensor = short.measured[column].sensor
            assert table[f"{sensor}.error"][k] == pytest.approx(misfit.rmse, rel=1e-12)


def test_a_rollout_that_becomes_unstable_is_nan_and_the_next_is_not():
    model = load_model("bench")
    recording = motion_recording("bench", model, None, 0.1)
    sweep = Sweep(
        model, recording, ["environment.stiffness=1e12,1e4,1e12"], outputs=["output_tension.max"]
    )
    table = sweep.rollouts.of(sweep.batch(0, 3))
    alone = Sweep(
        model, recording, ["environment.stiffness=1e4,1e4"], outputs=["output_tension.max"]
    )
    assert table[FAILED].tolist() == np.isnan(table["output_tension.max"]).tolist()
    assert (
        table["output_tension.max"][1]
        == alone.rollouts.of(alone.batch(0, 1))["output_tension.max"][0]
    )


@pytest.mark.parametrize(
    ("varied", "facts"),
    [
        ("mcp.damping=-1:1", ["mcp.damping = -1 is outside 0"]),
        ("flexor_sheath.static_friction=0.2,0.05", ["rollout 1", "friction"]),
        ("*.stiffness=0.05:0.2", ["*.stiffness", "stiffness [N/m]"]),  # of different units
    ],
)
def test_values_out_of_range_are_refused_by_name(varied, facts, finger):
    with refusing(InvalidValueError, *facts):
        (lambda sweep: sweep.rollouts.of(sweep.batch(0, 2)))(finger_sweep(finger, varied))


ARM = lever(
    '<general name="pull" joint="elbow" gainprm="3" gaintype="affine"/>',
    '<jointpos name="angle" joint="elbow"/><jointvel joint="elbow"/>',
    joint='name="elbow" stiffness="1" damping="1"',
    geom='size=".1" pos=".2 0 0"',
)


def test_any_model_moves_as_its_default_motion_has_it():
    model = mujoco.MjModel.from_xml_string(ARM)
    sweep = Sweep(model, motion_recording("arm", model, None, 0.2), ["elbow.stiffness=1:4:3"])
    table = sweep.rollouts.of(sweep.batch(0, 3))
    assert {name.partition(".")[0] for name in table} >= {"angle"}
    assert np.ptp(table["angle.rms"]) > 0.0
    with refusing(InvalidValueError, "--duration", "0 s"):
        motion_recording("arm", model, None, 0.0)
    with refusing(RecordingError, "curl"):
        motion_recording("arm", model, "curl", None)


@pytest.mark.parametrize("asked", ["elbow.stiffness=1:4:3", "pull.command_scale=0.5:1:3"])
def test_a_motion_is_of_controls_whatever_the_model_says_of_a_rig_s_commands(asked):
    """As `render` and `view` have it; a scale that is swept scales it."""
    told = ARM.replace('<general name="pull"', '<general name="pull" user="0.01 0.5 0.1"')
    tables = []
    for text in (ARM, told):
        model = mujoco.MjModel.from_xml_string(text)
        sweep = Sweep(model, motion_recording("arm", model, None, 0.2), [asked])
        tables.append(sweep.rollouts.of(sweep.batch(0, 3)))
    assert np.ptp(tables[0]["angle.rms"]) > 0.0
    for name, column in tables[0].items():
        np.testing.assert_array_equal(column, tables[1][name])


def test_a_policy_sees_the_model_s_own_user_data(tmp_path):
    (tmp_path / "own.py").write_text(
        "def act(model, data): data.ctrl[0] = model.actuator_user[0, 0]"
    )
    policy = read_policy(f"{tmp_path / 'own.py'}:act")
    angles = []
    for user in ("0 0", "0.7 0"):
        model = mujoco.MjModel.from_xml_string(
            ARM.replace('<general name="pull"', f'<general name="pull" user="{user}"')
        )
        still = motion_recording("arm", model, None, 0.2, still=True)
        sweep = Sweep(model, still, ["elbow.stiffness=1:4:2"], policy=policy)
        angles.append(sweep.rollouts.of(sweep.batch(0, 2))["angle.max"])
    assert (angles[0] == 0.0).all()
    assert (angles[1] > 0.0).all()


def test_tasks_last_from_a_fifth_of_a_second_to_two():
    assert batch_size(1e-3, 100_000) == 391  # 256 tasks
    assert batch_size(1e-3, 100) == 200  # all in one
    assert batch_size(1e-3, 10**8) == 2000
    assert batch_size(5.0, 10**6) == 1


def test_values_that_cannot_be_together_are_refused_before_the_first_rollout(finger, tmp_path):
    pytest.importorskip("pyarrow", reason="the extra tendon-mj[parquet] is not installed")
    varied = ("flexor.friction=0.1:0.3", "flexor.static_friction=0.15:0.4")
    with refusing(InvalidValueError, "static_friction = 0.15"):
        run_sweep(finger_sweep(finger, *varied, draws=3), tmp_path)
    assert not list(tmp_path.rglob("*.parquet"))
    assert not (tmp_path / "plan.json").exists()


def test_tables_of_another_hand_are_not_removed(finger, tmp_path):
    pytest.importorskip("pyarrow", reason="the extra tendon-mj[parquet] is not installed")
    (tmp_path / "rollouts").mkdir()
    other = tmp_path / "rollouts" / "mine.parquet"
    other.write_bytes(b"mine")
    sweep = finger_sweep(finger, "flexor.friction=0.1:0.3", draws=1)
    with refusing(InvalidValueError, str(tmp_path / "rollouts"), "plan.json"):
        run_sweep(sweep, tmp_path)
    for broken in ("{", "[]", "{}"):
        (tmp_path / "plan.json").write_text(broken)
        with refusing(InvalidValueError, str(tmp_path / "plan.json")):
            run_sweep(sweep, tmp_path)
    assert other.read_bytes() == b"mine"


def test_what_a_column_drives_or_shows_is_part_of_the_plan(finger):
    recording = motion_recording("finger", finger, "tap", 0.06)
    first, second, *rest = recording.measured
    swapped = {first: recording.measured[second], second: recording.measured[first]}
    other = dataclasses.replace(
        recording, measured={**swapped, **{c: recording.measured[c] for c in rest}}
    )
    assert recording_digest(other) != recording_digest(recording)


def test_rollouts_that_prescribe_a_joint_are_their_single_runs_and_take_no_policy(tmp_path):
    time = np.arange(0.0, 0.3, 0.02)
    model = build("prescribed").compile()
    recording = record(
        "loops", time, 30.0 * np.sin(9.0 * time), np.zeros((time.size, 3)), "prescribed", "wrist"
    )
    varied = ["wrist.armature=0,1e-4", "spool.command_scale=0.5,1"]  # the first computes constants
    sweep = Sweep(model, recording, varied, measured=True, outputs=["*.error"])
    table = sweep.rollouts.of(sweep.batch(0, 4))
    for k, (armature, scale) in enumerate(sweep.design.values(0, 4).tolist()):
        given = {"wrist.armature": armature, "spool.command_scale": scale}
        errors = replay_error(recording, replay_recording(recording, model, parameters=given))
        for column, measured in recording.measured.items():
            assert table[f"{measured.sensor}.error"][k] == errors[column].rmse
    policy = tmp_path / "still.py"
    policy.write_text("def act(model, data):\n    pass\n")
    with refusing(InvalidValueError, recording.name, "joint"):
        Sweep(model, recording, varied[:1], policy=read_policy(f"{policy}:act"))
