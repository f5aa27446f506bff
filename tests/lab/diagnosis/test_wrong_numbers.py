"""Numbers of a model that are too high or too low: found, on the right element, as such."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from tendon_mj.lab.diagnosis import (
    Diagnosis,
    Problem,
    all_samples,
    candidates,
    describe_system,
    diagnose,
)
from tendon_mj.lab.recordings import Measured, Recording
from tendon_mj.lab.replay import Parameter, Simulator
from tendon_mj.typing import FloatArray
from tests.lab.diagnosis.toy import Toy, recording

PENDULUM = """
<mujoco>
  <option timestep="0.001"/>
  <worldbody>
    <body name="arm">
      <joint name="elbow" type="hinge" axis="0 1 0" damping="0.05" frictionloss="0.1"
             stiffness="0.8" springref="10" armature="0.02" solreffriction="0.002 1"/>
      <geom type="capsule" size="0.02" fromto="0 0 0 0 0 -0.3" mass="0.5"/>
    </body>
  </worldbody>
  <actuator>{actuator}</actuator>
  <sensor>
    <jointpos name="angle" joint="elbow"/>
    <jointactuatorfrc name="torque" joint="elbow"/>
  </sensor>
</mujoco>
"""
ACTUATORS = {
    "motor": '<motor name="motor" joint="elbow" gear="2"/>',
    "servo": '<position name="servo" joint="elbow" kp="30" kv="1.5"/>',
}
NOISE = {"angle_rad": Measured("angle", 5e-3), "torque_Nm": Measured("torque", 2e-2)}
TIME = np.arange(0.0, 3.0, 0.01)

# number, actuator that drives, effect that it is called, values of the rig
WRONG = [
    ("elbow.damping", "motor", "joint_damping", (0.02, 0.0)),
    ("elbow.frictionloss", "motor", "joint_friction", (0.03, 0.0)),
    ("elbow.stiffness", "motor", "joint_stiffness", (0.5,)),
    ("elbow.springref", "motor", "springref", (-0.05, 0.5)),
    ("elbow.armature", "motor", "armature", (0.01, 0.04)),
    ("arm.mass", "motor", "mass", (0.4, 0.65, 0.03)),
    ("motor.gear", "motor", "gear", (1.6, 2.5)),
    ("motor.command_offset", "motor", "command_offset", (-0.2, 0.2)),
    ("servo.kp", "servo", "kp", (20.0, 45.0)),
    ("servo.kv", "servo", "kv", (0.8, 2.5)),
]
WORDS = {
    "elbow.damping": "the damping of joint elbow is too high: ",
    "elbow.springref": "the rest position of the spring of joint elbow is wrong:",
    "arm.mass": "the mass of body arm is too",
    "servo.kp": "the gain of actuator servo is too",
}


def measured(actuator: str, truth: Mapping[str, float], folder: Path) -> list[Recording]:
    """Two recordings of a rig, one to learn from and one for the proof."""
    model = folder / f"{actuator}.xml"
    model.write_text(PENDULUM.format(actuator=ACTUATORS[actuator]))
    column, sensors = (
        ("drive_Nm", ["angle_rad"]) if actuator == "motor" else ("drive_rad", [*NOISE])
    )
    random, made = np.random.default_rng(5), []
    for k in range(2):
        phase = 2.0 * np.pi * ((0.4 + 0.1 * k) * TIME + (0.35 + 0.05 * k) * TIME**2)
        drive = np.sin(phase) * np.minimum(TIME / 0.3, 1.0) * (0.35 - 0.05 * k)
        blank = Recording(
            name=f"r{k}",
            model=str(model),
            source="made",
            time=TIME,
            columns={column: drive, **dict.fromkeys(sensors, 0.0 * TIME)},
            drive={column: actuator},
            measured={c: NOISE[c] for c in sensors},
        )
        (series,) = Simulator([blank])([truth])[0]
        noisy = {
            c: s + random.normal(0.0, NOISE[c].noise or 0.0, s.size) for c, s in series.items()
        }
        made.append(replace(blank, columns=blank.columns | noisy))
    return made


def diagnosed(actuator: str, truth: Mapping[str, float], folder: Path) -> Diagnosis:
    made = measured(actuator, truth, folder)
    return diagnose(made[:1], made[1:])


@pytest.mark.parametrize(
    ("number", "actuator", "effect", "value"),
    [(n, a, e, v) for n, a, e, values in WRONG for v in values],
)
def test_a_wrong_number_is_found_on_its_element_within_its_interval(
    number: str, actuator: str, effect: str, value: float, tmp_path: Path
) -> None:
    found = diagnosed(actuator, {number: value}, tmp_path)
    assert found.effects == [effect]
    assert found.verdict == "parameter"
    assert [f.kind for f in found.findings] == ["parameter"]
    assert list(found.parameters) == [number]
    assert found.parameters[number].low <= value <= found.parameters[number].high
    assert found.parameters[number].value == pytest.approx(value, rel=0.1, abs=2e-3)
    assert f"A parameter was wrong: {WORDS.get(number, '')}" in found.sentence


@pytest.mark.parametrize(
    ("number", "effect", "value", "words"),
    [
        ("elbow.damping", "joint_damping", 0.1, "damping"),
        ("elbow.frictionloss", "joint_friction", 0.2, "dry friction"),
        ("elbow.stiffness", "joint_stiffness", 1.2, "stiffness"),
    ],
)
def test_what_a_model_has_too_little_of_is_told_as_a_wrong_number(
    number: str, effect: str, value: float, words: str, tmp_path: Path
) -> None:
    found = diagnosed("motor", {number: value}, tmp_path)
    assert (found.verdict, found.effects) == ("named", [effect])
    assert found.parameters[number].low <= value <= found.parameters[number].high
    assert [f.kind for f in found.findings] == ["parameter"]
    assert found.sentence.startswith(
        f"A parameter was wrong: the {words} of joint elbow is too low: "
    )


def test_a_drive_that_acts_late_is_told_from_a_sensor_that_reports_late(tmp_path: Path) -> None:
    found = diagnosed("servo", {"servo.command_delay": 0.03}, tmp_path)
    assert (found.verdict, found.effects) == ("named", ["command_delay"])
    delay = found.parameters["servo.command_delay"]
    assert delay.low <= 0.03 <= delay.high
    late = diagnosed("servo", {"angle.delay": 0.03}, tmp_path)
    assert late.effects == ["sensor_delay"]


class TwoSheaths(Toy):
    """The toy rig with two sheaths more, of different radii at their output."""

    RADII: ClassVar = {"left.output_radius": 0.01, "right.output_radius": -0.02}

    def __init__(self, recordings: Sequence[Recording]) -> None:
        super().__init__(recordings)
        radii = {name: Parameter(value, "m", "live") for name, value in self.RADII.items()}
        self.parameters = {**self.parameters, **radii}

    def _one(self, changed: Mapping[str, float], recording: Recording) -> dict[str, FloatArray]:
        toy = {name: value for name, value in changed.items() if name not in self.RADII}
        radii = {**self.RADII, **changed}
        place = recording.columns["input_displacement_m"] / 1e-3
        left = 200.0 * radii["left.output_radius"] * np.cos(3.0 * place)
        right = 200.0 * radii["right.output_radius"] * np.cos(7.0 * place)
        return {c: s + left + right for c, s in super()._one(toy, recording).items()}


@pytest.mark.parametrize("factor", [0.7, 1.3])
def test_one_factor_is_wrong_of_all_that_have_different_values(factor: float) -> None:
    random, made = np.random.default_rng(2), []
    truth = {name: factor * value for name, value in TwoSheaths.RADII.items()}
    for blank in (recording(f"r{k}", k, {}) for k in range(2)):
        (series,) = TwoSheaths([blank])([truth])[0]
        noisy = {c: s + random.normal(0.0, 0.05, s.size) for c, s in series.items()}
        made.append(replace(blank, columns=blank.columns | noisy))
    found = diagnose(made[:1], made[1:], TwoSheaths)
    assert (found.verdict, found.effects) == ("parameter", ["moment_arm"])
    assert found.findings[0].where == "left, right"
    for name, value in truth.items():
        assert found.parameters[name].low <= value <= found.parameters[name].high
        assert found.parameters[name].value == pytest.approx(value, rel=0.02)
    assert f"{factor:g} times what the model says" in found.sentence


def test_no_two_candidates_write_the_same_numbers(tmp_path: Path) -> None:
    made = [measured(actuator, {}, tmp_path)[0] for actuator in ACTUATORS]
    for one in (*made, replace(recording("bench", 1, {}), uncertain={})):
        problem = Problem((one,), Simulator([one]), all_samples([one]))
        bound = candidates(describe_system(problem))
        assert len(bound) > 10
        assert len({candidate.targets for candidate in bound}) == len(bound)
