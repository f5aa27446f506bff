"""Laws of a replay: what a model did it does again, and the parameters that are named act."""

from __future__ import annotations

import dataclasses
import os
import warnings
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tendon_mj.attach import add_sensor
from tendon_mj.errors import (
    InvalidValueError,
    RecordingError,
    TendonError,
    TendonWarning,
    UnknownNameError,
)
from tendon_mj.lab.recordings import Measured, Uncertain, read_recording
from tendon_mj.lab.replay import Adjustable, patch_model, replay_error, replay_recording
from tendon_mj.lab.replay.readout import make_clock
from tendon_mj.models import Bench, Joint, build_bench, build_joint, load_model
from tendon_mj.models.load import models_folder
from tests.lab.recorded import recorded
from tests.lab.replay.rigs import MEASURED, bench, joint_recording, wave
from tests.refusals import refusing

BENDS = (0, 60, 120, 180, 240)


def simulated_by_hand(model, recording, steps_a_sample):
    """Replay by `mj_step`, from the reference pose; the drive linear between samples."""
    data = mujoco.MjData(model)
    sensors = {c: model.sensor(m.sensor).adr[0] for c, m in recording.measured.items()}
    time, out = recording.time, []
    for k in range(steps_a_sample * (len(time) - 1) + 1):
        now = time[0] + k * model.opt.timestep
        for column, actuator in recording.drive.items():
            drive = np.interp(now, time, recording.columns[column])
            data.ctrl[model.actuator(actuator).id] = drive
        mujoco.mj_step(model, data)
        out.append([data.sensordata[address] for address in sensors.values()])
    return dict(zip(sensors, np.array(out[::steps_a_sample]).T, strict=True))


def assert_same(a, b, atol=1e-9):
    for column in a.measured:
        np.testing.assert_allclose(a.columns[column], b.columns[column], atol=atol, err_msg=column)


def test_what_the_joint_did_it_does_again():
    model, recording = load_model("joint"), joint_recording()
    truth = simulated_by_hand(model, recording, 20)
    answer = replay_recording(recording, settle=0.0)
    for column, values in truth.items():
        np.testing.assert_allclose(answer.columns[column], values, rtol=1e-9, atol=1e-9)


def test_what_the_bench_did_it_does_again():
    model = build_bench(Bench()).compile()
    time = np.arange(0.0, 0.5, model.opt.timestep)
    recording = recorded(
        time,
        {"input_displacement_m": ("reel", 1e-3 * wave(time))},
        {"output_tension_N": "output_tension"},
    )
    truth = simulated_by_hand(model, recording, 1)
    answer = replay_recording(recording, model, settle=0.0)
    np.testing.assert_allclose(
        answer.columns["output_tension_N"], truth["output_tension_N"], rtol=1e-9, atol=1e-9
    )


def test_a_replay_of_a_replay_is_itself():
    once = replay_recording(joint_recording())
    twice = replay_recording(once)
    assert all(np.array_equal(once.columns[c], twice.columns[c]) for c in once.columns)


def test_the_answer_says_what_it_is():
    plain = joint_recording(known={"joint.stiffness": 0.03})
    columns = {**plain.columns, "room_rad": plain.time}  # of no meaning
    recording = dataclasses.replace(plain, columns=columns)
    answer = replay_recording(recording, parameters={"sheath_1.friction": 0.1})
    assert list(answer.columns) == list(plain.columns)
    np.testing.assert_array_equal(answer.time, recording.time)
    np.testing.assert_array_equal(answer.columns["command_rad"], recording.columns["command_rad"])
    assert "simulated by tendon-mj" in answer.source
    assert dict(answer.known) == {"joint.stiffness": 0.03, "sheath_1.friction": 0.1}
    assert answer.drive == recording.drive


def test_the_same_replay_twice_is_the_same_to_the_bit_with_or_without_progress():
    recording, told = joint_recording(np.arange(0.0, 6.0, 0.02)), []
    a, b = replay_recording(recording), replay_recording(recording, progress=told.append)
    assert all(np.array_equal(a.columns[c], b.columns[c]) for c in a.columns)
    assert told == sorted(told)
    assert len(told) > 2
    assert told[-1] == 1.0


def test_the_model_that_is_given_stays_as_it_was():
    model = load_model("joint")
    before = (model.opt.timestep, model.jnt_stiffness.copy(), model.actuator_biasprm.copy())
    changes = {"joint.stiffness": 1.0, "command.kp": 500.0, "sheath_1.friction": 0.0}
    recording = joint_recording(np.linspace(0.0, 1.0, 42))
    first = replay_recording(recording, model)
    replay_recording(recording, model, parameters=changes)
    assert model.opt.timestep == before[0]
    np.testing.assert_array_equal(model.jnt_stiffness, before[1])
    np.testing.assert_array_equal(model.actuator_biasprm, before[2])
    assert_same(first, replay_recording(recording, model), atol=0.0)


# the drive between the samples, and the samples between the steps


def test_the_drive_is_linear_between_samples():
    knots = np.array([0.0, 0.2, 0.5, 1.0])
    angles = np.array([0.0, 0.5, -0.5, 0.3])
    fine = np.arange(0.0, 1.0001, 0.02)
    dense = replay_recording(joint_recording(fine, np.interp(fine, knots, angles)))
    sparse = replay_recording(joint_recording(knots, angles))
    for k, time in enumerate(knots):
        at = int(np.argmin(np.abs(fine - time)))
        for column in MEASURED:
            assert sparse.columns[column][k] == pytest.approx(dense.columns[column][at], abs=2e-4)


def test_rows_left_out_of_a_regular_recording_change_nothing_where_the_drive_is_straight():
    time = np.arange(0.0, 1.0, 0.02)
    kept = np.sort(np.random.default_rng(0).permutation(len(time))[:30])
    kept = np.union1d(kept, [0, len(time) - 1])
    full, gaps = joint_recording(time, 0.5 * time), joint_recording(time[kept], 0.5 * time[kept])
    a, b = replay_recording(full), replay_recording(gaps)
    for column in MEASURED:
        np.testing.assert_allclose(a.columns[column][kept], b.columns[column], atol=1e-9)


def test_a_clock_that_starts_elsewhere_changes_nothing():
    recording = joint_recording()
    later = dataclasses.replace(recording, time=recording.time + 1000.0)
    assert_same(replay_recording(recording), replay_recording(later), atol=1e-6)


@pytest.mark.parametrize("interval", [0.0003, 0.001, 0.0017, 0.025, 1.0 / 30.0])
def test_regular_samples_lie_on_the_grid_and_no_step_is_too_long(interval):
    clock = make_clock(5.0 + interval * np.arange(101), longest=0.001)
    np.testing.assert_array_equal(clock.places, np.rint(clock.places))
    assert clock.timestep <= 0.001 * (1.0 + 1e-9)
    assert clock.steps * clock.timestep == pytest.approx(100 * interval, rel=1e-12)
    assert clock.timestep > 0.0005 or clock.timestep == pytest.approx(interval)


def test_samples_off_the_grid_are_read_between_steps():
    time = np.cumsum(np.random.default_rng(1).uniform(0.001, 0.05, 200))
    clock = make_clock(time, longest=0.001)
    assert clock.timestep <= 0.001
    series = np.stack([3.0 + 2.0 * clock.time, -clock.time], axis=1)
    np.testing.assert_allclose(clock.sample(series)[:, 0], 3.0 + 2.0 * time, rtol=1e-12)
    np.testing.assert_allclose(clock.sample(series)[:, 1], -time, rtol=1e-12)


def test_readings_between_steps_converge_with_the_step():
    time = np.cumsum(np.random.default_rng(2).uniform(0.005, 0.05, 30))
    recording = joint_recording(time, 0.5 * np.sin(2.0 * (time - time[0])))
    fine = replay_recording(recording, build_joint(Joint(timestep=0.00025)).compile())
    assert_same(replay_recording(recording), fine, atol=0.02)


# before the first sample


def test_the_first_sample_is_at_rest_where_the_drive_begins():
    held = joint_recording(np.arange(0.0, 0.5, 0.02), np.full(25, 0.6))
    answer = replay_recording(held)
    for column in MEASURED:
        np.testing.assert_allclose(answer.columns[column], answer.columns[column][0], atol=2e-3)
    assert answer.columns["joint_rad"][0] > 0.4


def test_without_settling_the_first_sample_is_the_reference_pose():
    held = joint_recording(np.arange(0.0, 0.5, 0.02), np.full(25, 0.6))
    answer = replay_recording(held, settle=0.0)
    assert_same(answer, replay_recording(dataclasses.replace(held, settle=0.0)), atol=0.0)
    assert answer.columns["joint_rad"][0] == 0.0
    assert answer.columns["tension_1_N"][0] == pytest.approx(5.0)


@pytest.mark.parametrize("settle", [-0.1, np.nan, np.inf])
def test_a_time_to_settle_that_is_none_is_refused(settle):
    with refusing(InvalidValueError, f"settle = {settle}"):
        replay_recording(joint_recording(), settle=settle)


@pytest.mark.parametrize(
    ("interval", "settle", "steps"), [(1e-2, 1e5, "100000490"), (5e-324, 0.5, "inf")]
)
def test_more_steps_than_are_simulated_are_refused_by_their_number(interval, settle, steps):
    recording = joint_recording(interval * np.arange(50), np.full(50, 0.6))
    with refusing(RecordingError, "'made up'", f" {steps} in all"):
        replay_recording(recording, settle=settle)


# parameters


@pytest.mark.parametrize(
    ("parameters", "numbers"),
    [
        ({"sheath_1.friction": 0.05, "sheath_2.friction": 0.05}, {"friction": 0.05}),
        (
            {"sheath_1.axial_stiffness": 8e3, "sheath_2.axial_stiffness": 8e3},
            {"axial_stiffness": 8e3},
        ),
        ({"sheath_1.pretension": 3.0, "sheath_2.pretension": 3.0}, {"pretension": 3.0}),
        ({"joint.stiffness": 0.05}, {"stiffness": 0.05}),
        ({"joint.damping": 0.01}, {"damping": 0.01}),
        ({"spool.armature": 0.02}, {"motor_inertia": 0.02}),
        ({"command.kp": 2e3, "command.kv": 7.0}, {"servo_stiffness": 2e3, "servo_damping": 7.0}),
    ],
)
def test_a_parameter_does_what_building_with_it_does(parameters, numbers):
    recording = joint_recording()
    built = replay_recording(
        recording, build_joint(dataclasses.replace(Joint(), **numbers)).compile()
    )
    changed = replay_recording(recording, parameters=parameters)
    assert_same(changed, built, atol=2e-5)
    plain = replay_recording(recording)
    assert any(
        np.abs(plain.columns[c] - changed.columns[c]).max() > 1e-4 for c in recording.measured
    )


def test_the_rigs_scales_and_offsets_are_applied_to_columns():
    recording = joint_recording()
    plain = replay_recording(recording)
    shown = replay_recording(
        recording, parameters={"joint_angle.scale": 2.0, "joint_angle.offset": 0.1}
    )
    np.testing.assert_allclose(
        shown.columns["joint_rad"], 2.0 * plain.columns["joint_rad"] + 0.1, atol=1e-12
    )
    doubled = joint_recording(drive=0.5 * wave(recording.time) + 0.2)
    told = replay_recording(
        recording, parameters={"command.command_scale": 0.5, "command.command_offset": 0.2}
    )
    assert_same(told, replay_recording(doubled), atol=1e-9)


def test_a_late_command_is_the_drive_as_it_was_before():
    recording = joint_recording()
    late = replay_recording(recording, parameters={"command.command_delay": 0.06})
    before = np.interp(recording.time - 0.06, recording.time, wave(recording.time))
    assert_same(late, replay_recording(joint_recording(drive=before)), atol=1e-9)


def test_a_mass_and_its_inertia_grow_together():
    plain, heavy = Adjustable(load_model("joint")), Adjustable(load_model("joint"))
    heavy.set({"joint.mass": 3.0 * plain.parameters()["joint.mass"].value})
    body = plain.model.body("joint").id
    for field in ("body_mass", "body_inertia"):
        before, after = getattr(plain.model, field), getattr(heavy.model, field)
        np.testing.assert_allclose(after[body], 3.0 * before[body], rtol=1e-14)
        np.testing.assert_array_equal(np.delete(after, body, 0), np.delete(before, body, 0))
    dof = int(plain.model.joint("joint").dofadr[0])
    weights = [a.model.dof_invweight0[dof] for a in (plain, heavy)]
    assert weights[1] == pytest.approx(weights[0] / 3.0, rel=1e-9)
    assert plain.parameters()["joint.mass"].joints == ("joint",)
    with refusing(InvalidValueError, "joint.mass = 0"):
        heavy.set({"joint.mass": 0.0})


def test_known_then_uncertain_then_given():
    recording = joint_recording(
        known={"joint.stiffness": 0.03}, uncertain={"sheath_1.friction": Uncertain(0.3, 0.0, 0.5)}
    )
    as_described = replay_recording(recording)
    by_hand = replay_recording(
        joint_recording(), parameters={"joint.stiffness": 0.03, "sheath_1.friction": 0.3}
    )
    assert_same(as_described, by_hand, atol=0.0)
    given = replay_recording(
        recording, parameters={"sheath_1.friction": 0.19, "joint.stiffness": 0.02}
    )
    assert_same(given, replay_recording(joint_recording()), atol=1e-12)


@pytest.mark.parametrize(
    ("name", "nearest"),
    [
        ("sheath_1.fricton", "sheath_1.friction"),
        ("sheath_3.friction", "sheath_"),
        ("joint.stifness", "joint.stiffness"),
        ("comand.kp", "command.kp"),
        ("joint_angle.ofset", "joint_angle.offset"),
    ],
)
def test_an_unknown_parameter_is_refused_with_the_nearest(name, nearest):
    with refusing(UnknownNameError, f"did you mean '{nearest}"):
        replay_recording(joint_recording(), parameters={name: 1.0})
    with refusing(UnknownNameError, f"did you mean '{nearest}"):
        replay_recording(joint_recording(known={name: 1.0}))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("sheath_1.friction", -0.1),
        ("sheath_1.axial_stiffness", 0.0),
        ("sheath_1.static_friction", 0.1),  # below the dynamic one
        ("joint.stiffness", -1.0),
        ("joint.damping", np.nan),
        ("command.kp", -1.0),
        ("joint_angle.offset", np.inf),
    ],
)
def test_a_parameter_out_of_range_is_refused(name, value):
    with refusing(InvalidValueError, *name.split(".")):
        replay_recording(joint_recording(), parameters={name: value})


# what does not fit


@pytest.mark.parametrize(
    ("changed", "kind", "fact"),
    [
        ({"drive": {"command_rad": "comand"}}, RecordingError, "did you mean 'command'"),
        (
            {"measured": {"joint_rad": Measured("joint_angel")}},
            RecordingError,
            "did you mean 'joint_angle'",
        ),
        ({"measured": {"joint_rad": Measured("slips")}}, RecordingError, "16 numbers"),
    ],
)
def test_a_recording_that_does_not_fit_the_model_is_refused(changed, kind, fact):
    spec = build_joint(Joint())
    add_sensor(spec, "sheath_1", "slip", "slips")
    with refusing(kind, "made up", fact):
        replay_recording(dataclasses.replace(joint_recording(), **changed), spec.compile())
    with refusing(UnknownNameError, "did you mean 'joint'"):
        replay_recording(joint_recording(model="joind"))


def test_a_simulation_that_fails_says_when(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)  # MuJoCo writes a log where it runs
    recording = joint_recording(np.arange(0.0, 2.0, 0.02))
    shaky = build_joint(Joint(timestep=0.01, stiffness=50.0)).compile()
    with pytest.raises(TendonError, match=r"on model 'joint' failed (at time|.* before the first)"):
        replay_recording(recording, shaky)


# errors


def test_no_error_is_none_and_a_shift_is_itself():
    recording = joint_recording()
    same = replay_error(recording, recording)
    assert all(m.rmse == m.largest == m.bias == m.share_of_range == 0.0 for m in same.values())
    true = replay_recording(recording)
    shifted = {**true.columns, "joint_rad": true.columns["joint_rad"] - 0.1}
    misfit = replay_error(true, dataclasses.replace(true, columns=shifted))["joint_rad"]
    assert misfit.rmse == pytest.approx(0.1)
    assert misfit.bias == pytest.approx(-0.1)
    assert misfit.largest == pytest.approx(0.1)
    assert misfit.share_of_range == pytest.approx(0.1 / np.ptp(true.columns["joint_rad"]))


def test_recordings_of_other_times_or_columns_are_not_compared():
    recording = joint_recording()
    with refusing(RecordingError, "times", "'made up'"):
        replay_error(recording, dataclasses.replace(recording, time=recording.time + 0.001))
    columns = {c: v for c, v in recording.columns.items() if c != "tension_2_N"}
    measured = {c: m for c, m in MEASURED.items() if c != "tension_2_N"}
    less = dataclasses.replace(recording, columns=columns, measured=measured)
    with refusing(RecordingError, "'tension_2_N'"):
        replay_error(recording, less)


# the real recordings, which are not in the repository


def real_recording(bend):
    folder = os.environ.get("TENDON_MJ_DATA")
    if not folder or not (Path(folder) / "tendon_sheath_joint").is_dir():
        pytest.skip("TENDON_MJ_DATA names no folder with tendon_sheath_joint (see docs/data.md)")
    return read_recording(
        Path(folder) / "tendon_sheath_joint" / f"bend_{bend:03d}deg.csv",
        description=models_folder() / "joint" / "tendon_sheath_joint.toml",
    )


def real_error(bend, friction, slower=1.0):
    measured = real_recording(bend)
    measured = dataclasses.replace(measured, time=slower * measured.time)
    model = build_joint(Joint(bend=np.radians(bend), friction=friction)).compile()
    return replay_error(measured, replay_recording(measured, model))


@pytest.mark.parametrize("bend", BENDS)
def test_real_recordings_replay_and_friction_takes_the_error_the_right_way(bend):
    without, with_friction = real_error(bend, 0.0), real_error(bend, 0.19)
    assert 0.0 < with_friction["joint_rad"].rmse < np.radians(35.0)
    if bend:
        assert with_friction["joint_rad"].rmse < without["joint_rad"].rmse
    else:
        assert with_friction["joint_rad"].rmse == pytest.approx(without["joint_rad"].rmse, rel=1e-6)


def test_the_doubtful_clock_of_the_real_recordings_hardly_matters():
    as_told, slower = real_error(120, 0.19), real_error(120, 0.19, slower=2.0)
    assert slower["joint_rad"].rmse == pytest.approx(as_told["joint_rad"].rmse, abs=np.radians(0.1))
    assert slower["tension_1_N"].rmse == pytest.approx(as_told["tension_1_N"].rmse, abs=0.02)


FRICTION, STIFFNESS, SCALE = "sheath.friction", "sheath.axial_stiffness", "reel.command_scale"
SAID = {SCALE: 2.0, STIFFNESS: 4000.0}


@pytest.mark.parametrize(
    ("described", "changed", "expected"),
    [  # the bench has friction 0.15, axial stiffness 20 kN and a plain command
        (None, {}, SAID | {FRICTION: 0.15}),
        (None, {STIFFNESS: 9e3}, {SCALE: 2.0, FRICTION: 0.15, STIFFNESS: 9e3}),
        (None, {FRICTION: 0.0}, SAID | {FRICTION: 0.0}),
        (None, {SCALE: 1.5}, {SCALE: 1.5, STIFFNESS: 4000.0, FRICTION: 0.15}),
        (False, {STIFFNESS: 9e3}, {SCALE: 2.0, FRICTION: 0.15, STIFFNESS: 9e3}),
        (True, {STIFFNESS: 9e3, FRICTION: 0.0}, SAID | {FRICTION: 0.3}),
    ],
)
def test_a_given_model_keeps_its_physics_and_the_description_its_columns(
    described, changed, expected, tmp_path
):
    guess = {FRICTION: Uncertain(0.3, 0.0, 0.5)}
    recording = bench("pull", known=SAID, uncertain=guess)
    path = patch_model("bench", changed, tmp_path / "other.xml")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", TendonWarning)
        answer = replay_recording(recording, load_model(str(path)), described=described)
    plain = replay_recording(replace(recording, known=expected, uncertain={}))
    assert_same(answer, plain)
    kept = {name for name in (FRICTION, STIFFNESS, SCALE) if name in "".join(map(str, caught))}
    told = {FRICTION, *changed} if described is None else set()
    assert kept == told


def test_a_description_holds_on_its_own_model():
    recording = bench("pull", uncertain={FRICTION: Uncertain(0.3, 0.0, 0.5)})
    assert_same(replay_recording(recording), replay_recording(bench("p", known={FRICTION: 0.3})))
