"""Models of others: what drives them, what they get, and what is refused."""

import numpy as np
import pytest

from experiments.benchmarks import run_benchmark
from tendon_mj.errors import InvalidValueError, TendonError, UnknownNameError
from tendon_mj.lab.verification import smooth_controls
from tendon_mj.lab.verification.foreign_model import model_cost, prepare_model
from tendon_mj.plugin import sheaths

ARM = """
<mujoco>
  <worldbody>
    <site name="a" pos="0 0 0.05"/>
    <body pos="0.1 0 0">
      <joint name="elbow" axis="0 1 0" range="-60 60" damping="0.05"/>
      <geom size="0.02" fromto="0 0 0 0.2 0 0" type="capsule"/>
      <site name="b" pos="0.02 0 0.03"/><site name="c" pos="0.1 0 0.03"/>
    </body>
  </worldbody>
  <tendon>
    <spatial name="flexor"><site site="a"/><site site="b"/><site site="c"/></spatial>
    <spatial><site site="a"/><site site="b"/><site site="c"/></spatial>
  </tendon>
  <actuator>{}</actuator>
</mujoco>
"""
MUSCLE = '<muscle tendon="flexor" force="20" ctrllimited="true" ctrlrange="0 1"/>'
MOTOR = '<motor name="m" joint="elbow"/>'


@pytest.fixture
def arm(tmp_path):
    path = tmp_path / "arm.xml"
    path.write_text(ARM.format(MUSCLE + MOTOR))
    return path


def test_each_driven_tendon_gets_a_sheath_and_nothing_else_changes(arm):
    model = prepare_model(str(arm), steps=50)
    assert (model.name, model.sheaths) == ("arm", 1)  # nothing pulls the other tendon
    assert not sheaths(model.plain.model)
    assert list(sheaths(model.sheathed.model)) == list(sheaths(model.unsensed.model))
    assert model.unsensed.model.nsensordata < model.sheathed.model.nsensordata
    np.testing.assert_array_equal(model.plain.controls, model.sheathed.controls)


def test_controls_are_smooth_and_within_their_ranges(arm):
    model = prepare_model(str(arm)).plain.model
    controls = smooth_controls(model, 2000)
    assert controls.shape == (2000, 2)
    assert controls[:, 0].min() >= 0.0
    assert controls.max() <= 1.0
    assert controls.min() >= -1.0
    assert (controls.std(axis=0) > 0.05).all()
    assert np.abs(np.diff(controls, axis=0)).max() < 10.0 * model.opt.timestep
    np.testing.assert_array_equal(controls, smooth_controls(model, 2000))


def test_the_cost_has_both_memories(arm):
    found = model_cost(prepare_model(str(arm), steps=50), rounds=1)
    assert found.cost.ratio > 0.0
    assert found.memory.plugin_state > 0 == found.reference_memory.plugin_state
    assert found.result()["without_tension_sensors"]["ratio"] > 0.0


@pytest.mark.parametrize(
    ("text", "error", "said"),
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
def test_a_model_that_cannot_be_compared_is_refused(arm, text, error, said):
    arm.write_text(text)
    with pytest.raises(error, match=said):
        prepare_model(str(arm))


def test_what_the_benchmark_cannot_do_is_refused_before_anything_is_timed(arm, tmp_path):
    reported = []
    other = tmp_path / "other"
    other.mkdir()
    (other / "arm.xml").write_text(arm.read_text())
    for models, rounds, error, said in (
        (["nowhere.xml"], 1, UnknownNameError, "nowhere.xml"),
        ([str(arm), str(other / "arm.xml")], 1, InvalidValueError, "2 models are called 'arm'"),
        ([], 0, InvalidValueError, "rounds = 0"),
    ):
        with pytest.raises(error, match=said):
            run_benchmark(models, rounds=rounds, progress=lambda *done: reported.append(done))
    assert not reported
