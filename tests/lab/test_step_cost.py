"""The models whose steps are timed are the ones that they stand for."""

import mujoco
import numpy as np
import pytest

from tendon_mj import add_cable_drive
from tendon_mj.errors import InvalidValueError, TendonError, UnknownNameError
from tendon_mj.lab.finger import prepare_finger, tap
from tendon_mj.lab.replay import full_state, rollout_sensors
from tendon_mj.lab.step_cost import (
    StepCost,
    bench_runs,
    finger_runs,
    measure_models,
    mujoco_tendon_bench,
    mujoco_tendon_finger,
    prepare_model,
    without_tension_sensors,
)
from tendon_mj.models import JOINTS, Bench, Finger, build_bench, build_finger
from tendon_mj.plugin import sheaths
from tests.refusals import refusing
from tests.rigs import rope, route

ARM = rope(
    "a 0 0 .05",
    "b .02 0 .03; c .1 0 .03",
    name="flexor",
    body='pos="0.1 0 0"',
    joint='name="elbow" axis="0 1 0" range="-60 60" damping="0.05"',
    geom='size="0.02" fromto="0 0 0 0.2 0 0" type="capsule"',
    tendons=f"<spatial>{route('a b c')}</spatial>",
    actuator="{}",
)
MUSCLE = '<muscle tendon="flexor" force="20" ctrllimited="true" ctrlrange="0 1"/>'
MOTOR = '<motor name="m" joint="elbow"/>'


def tapping_angles(spec, finger):
    """(steps, 3) joint angles of three taps [rad]."""
    prepared, controls = prepare_finger(tap(), spec.compile(), finger)
    model, data = prepared.model, prepared.data
    readings = rollout_sensors(model, [data], full_state(model, data)[None], controls[None])[0]
    return readings[:, [int(model.sensor(f"{joint}_angle").adr[0]) for joint in JOINTS]]


def test_without_friction_the_finger_moves_as_with_mujocos_own_tendons():
    finger = Finger(friction=0.0)
    ours = tapping_angles(build_finger(finger), finger)
    reference = tapping_angles(mujoco_tendon_finger(finger), finger)
    # what is wound in stretches no more: a tenth of the tendon, which MuJoCo's spring neglects
    np.testing.assert_allclose(ours, reference, atol=np.radians(1.0))


def test_the_finger_moves_alike_without_its_tension_sensors():
    finger = Finger()
    bare = without_tension_sensors(build_finger(finger))
    np.testing.assert_array_equal(
        tapping_angles(bare, finger), tapping_angles(build_finger(finger), finger)
    )


def test_without_friction_the_bench_is_as_stiff_as_with_mujocos_own_tendon():
    bench = Bench(friction=0.0)
    pulled = []
    for spec in (build_bench(bench), mujoco_tendon_bench(bench)):
        model = spec.compile()
        data = mujoco.MjData(model)
        data.joint("environment").qpos = -1e-4
        mujoco.mj_forward(model, data)
        pulled.append(data.qfrc_passive.copy())
    # the plugin's spring is EA/L at the pretension, MuJoCo's EA/S: T_0/EA apart
    rel = 2.0 * bench.pretension / bench.axial_stiffness
    np.testing.assert_allclose(pulled[0], pulled[1], rtol=rel, atol=1e-6)


def test_a_step_cost_is_positive_and_its_ratio_that_of_the_times():
    cost = bench_runs(Bench(guides=4)).cost(rounds=1).cost
    assert cost.step > 0.0
    assert cost.reference_step > 0.0
    cost = StepCost(np.array([3e-6, 5e-6, 4e-6]), np.array([2e-6, 2e-6, 1e-6]))
    assert cost.ratio == pytest.approx(2.5)
    assert cost.added.median == pytest.approx(3e-6)
    assert finger_runs(Finger()).cost(rounds=1).cost.ratio > 0.0


@pytest.fixture
def arm(tmp_path):
    path = tmp_path / "arm.xml"
    path.write_text(ARM.format(MUSCLE + MOTOR))
    return path


def test_each_driven_tendon_gets_a_sheath_and_nothing_else_changes(arm):
    model = prepare_model(str(arm), steps=50)
    assert len(sheaths(model.sheathed.model)) == 1  # nothing pulls the other tendon
    assert not sheaths(model.plain.model)
    assert list(sheaths(model.sheathed.model)) == list(sheaths(model.unsensed.model))
    assert model.unsensed.model.nsensordata < model.sheathed.model.nsensordata
    np.testing.assert_array_equal(model.plain.controls, model.sheathed.controls)


def test_a_file_with_sheaths_runs_as_it_is_and_without_them(arm):
    spec = mujoco.MjSpec.from_file(str(arm))
    stock = spec.compile()
    add_cable_drive(spec, "m", radius=0.01, bend=3.0, friction=0.2, pretension=1.0)
    arm.write_text(spec.to_xml())
    model = prepare_model(str(arm), steps=50)
    assert len(sheaths(model.sheathed.model)) == len(sheaths(model.unsensed.model)) == 1
    assert not sheaths(model.plain.model)
    assert model.unsensed.model.nsensordata < model.sheathed.model.nsensordata
    assert (model.plain.model.nu, model.plain.model.ntendon) == (stock.nu, stock.ntendon)


def test_the_cost_has_both_memories(arm):
    cost = prepare_model(str(arm), steps=50).cost(rounds=1)
    assert (cost.sheaths, cost.cost.ratio > 0.0) == (1, True)
    assert cost.memory["plugin_state"] > 0 == cost.reference_memory["plugin_state"]
    assert cost.result()["without_tension_sensors"]["ratio"] > 0.0


@pytest.mark.parametrize(
    ("text", "error", "fact"),
    [
        (ARM.format(""), InvalidValueError, "no actuator"),
        (ARM.format(MOTOR), TendonError, "none of the tendons"),
        (ARM.format(MOTOR).replace('site="b"', 'site="d"'), TendonError, "arm.xml"),
        ("no XML", TendonError, "arm.xml"),
        (
            ARM.format(MUSCLE + MOTOR.replace("/>", ' gear="1e15"/>')).replace("0.05", "0"),
            TendonError,
            "unstable",
        ),
    ],
)
def test_a_model_that_cannot_be_compared_is_refused(arm, text, error, fact):
    arm.write_text(text)
    with refusing(error, fact):
        prepare_model(str(arm))


def test_a_measurement_that_cannot_be_made_is_refused_before_anything_is_timed(arm, tmp_path):
    reported = []
    other = tmp_path / "other"
    other.mkdir()
    (other / "arm.xml").write_text(arm.read_text())
    for models, rounds, error, fact in (
        (["nowhere.xml"], 1, UnknownNameError, "nowhere.xml"),
        ([str(arm), str(other / "arm.xml")], 1, InvalidValueError, "2 models are called 'arm'"),
        ([], 0, InvalidValueError, "rounds = 0"),
    ):
        with refusing(error, fact):
            measure_models(models, rounds=rounds, progress=lambda *done: reported.append(done))
    assert not reported
