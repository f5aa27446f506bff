"""Numbers of a model that are too high or too low: found, on the right element, as such."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from tendon_mj.lab.diagnosis import (
    CATALOGUE,
    Candidate,
    Diagnosis,
    Problem,
    all_samples,
    candidates,
    describe_system,
    diagnose,
    written,
)
from tendon_mj.lab.diagnosis.effects.binding import ParameterSpecification
from tendon_mj.lab.diagnosis.wording import state_finding
from tendon_mj.lab.recordings import Recording, Uncertain
from tendon_mj.lab.replay import Parameter, Simulator
from tendon_mj.typing import FloatArray
from tests.lab.diagnosis.toy import Toy, bench_recording, measured_by, problem_of, recording, system
from tests.lab.recorded import recorded

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
NOISE = {"angle_rad": ("angle", 5e-3), "torque_Nm": ("torque", 2e-2)}
TIME = np.arange(0.0, 2.0, 0.01)

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
        read = {c: NOISE[c] for c in sensors}
        blank = recorded(TIME, {column: (actuator, drive)}, read, model, name=f"r{k}")
        made.append(measured_by(Simulator, blank, truth, random))
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
    result = diagnosed(actuator, {number: value}, tmp_path)
    assert result.effects == [effect]
    assert result.verdict == "parameter"
    assert [f.kind for f in result.findings] == ["parameter"]
    assert list(result.parameters) == [number]
    assert result.parameters[number].low <= value <= result.parameters[number].high
    assert result.parameters[number].value == pytest.approx(value, rel=0.1, abs=2e-3)
    assert f"A parameter was wrong: {WORDS.get(number, '')}" in result.sentence


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
    result = diagnosed("motor", {number: value}, tmp_path)
    assert (result.verdict, result.effects) == ("named", [effect])
    assert result.parameters[number].low <= value <= result.parameters[number].high
    assert [f.kind for f in result.findings] == ["parameter"]
    assert result.sentence.startswith(
        f"A parameter was wrong: the {words} of joint elbow is too low: "
    )


def test_a_drive_that_acts_late_is_told_from_a_sensor_that_reports_late(tmp_path: Path) -> None:
    result = diagnosed("servo", {"servo.command_delay": 0.03}, tmp_path)
    assert (result.verdict, result.effects) == ("named", ["command_delay"])
    delay = result.parameters["servo.command_delay"]
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

    def waveform(self, parameter: str, column: str, recording: Recording) -> FloatArray:
        if parameter not in self.RADII:
            return super().waveform(parameter, column, recording)
        waves = 3.0 if parameter == "left.output_radius" else 7.0
        return 200.0 * np.cos(waves * recording.columns["input_displacement_m"] / 1e-3)


@pytest.mark.parametrize("factor", [0.7, 1.3])
def test_one_factor_is_wrong_of_all_that_have_different_values(factor: float) -> None:
    random = np.random.default_rng(2)
    truth = {name: factor * value for name, value in TwoSheaths.RADII.items()}
    blanks = [recording(f"r{k}", k, {}) for k in range(2)]
    made = [measured_by(TwoSheaths, blank, truth, random) for blank in blanks]
    result = diagnose(made[:1], made[1:], TwoSheaths)
    assert (result.verdict, result.effects) == ("parameter", ["moment_arm"])
    assert result.findings[0].where == "left, right"
    for name, value in truth.items():
        assert result.parameters[name].low <= value <= result.parameters[name].high
        assert result.parameters[name].value == pytest.approx(value, rel=0.02)
    assert f"{factor:g} times what the model says" in result.sentence


def test_no_two_candidates_write_the_same_numbers(tmp_path: Path) -> None:
    made = [measured(actuator, {}, tmp_path)[0] for actuator in ACTUATORS]
    for one in (*made, replace(recording("bench", 1, {}), uncertain={})):
        problem = problem_of(Simulator, [one])
        bound = candidates(describe_system(problem))
        assert len(bound) > 10
        assert len({candidate.targets for candidate in bound}) == len(bound)


STIFFNESS, REST = 0.8, np.radians(10.0)  # of the pendulum's spring


def bound(springref: float, reference: float = 0.0) -> list[Candidate]:
    """Candidates for a wrong spring of a joint that rests there."""
    values, pose = {"a.stiffness": 2.0, "a.springref": springref}, {"a.springref": reference}
    rig = system(values, free_joints=("a",), reference=pose)
    return CATALOGUE["joint_spring"].bind(rig)


@pytest.mark.parametrize("reference", [0.0, 0.4])
@pytest.mark.parametrize("factor", [0.5, 1.0, 3.0])
def test_a_stiffer_spring_keeps_its_torque_in_the_reference_pose(
    factor: float, reference: float
) -> None:
    (candidate,) = bound(-0.3, reference)
    base = {"a.stiffness": 2.0, "a.springref": -0.3}
    result = written(candidate.terms, [factor, 1.0], base)
    assert result["a.stiffness"] == pytest.approx(2.0 * factor)
    torque = result["a.stiffness"] * (result["a.springref"] - reference)
    assert torque == pytest.approx(2.0 * (-0.3 - reference))


def test_a_spring_that_rests_in_the_reference_pose_has_one_number() -> None:
    assert bound(0.0) == bound(0.4, 0.4) == []


@pytest.mark.parametrize("factor", [0.75, 1.25])
@pytest.mark.parametrize("torque", [1.0, 1.1])  # of the model's, in the reference pose
def test_a_wrong_spring_is_found_with_its_rest_position(
    factor: float, torque: float, tmp_path: Path
) -> None:
    truth = {"elbow.stiffness": factor * STIFFNESS, "elbow.springref": REST * torque / factor}
    result = diagnosed("motor", truth, tmp_path)
    assert (result.verdict, result.effects) == ("parameter", ["joint_spring"])
    for name, value in truth.items():
        assert result.parameters[name].low <= value <= result.parameters[name].high
        assert result.parameters[name].value == pytest.approx(value, rel=0.03)
    assert "the stiffness of joint elbow is too" in result.sentence
    assert "the rest position of the spring of joint elbow is wrong" in result.sentence


def test_no_weight_is_more_than_that_of_any_attitude(tmp_path: Path) -> None:
    rig = system({"gravity.x": 0.0, "gravity.y": 0.0, "gravity.z": -9.81})
    for candidate in CATALOGUE["gravity_load"].bind(rig):
        (term,) = candidate.terms
        assert (term.low, term.high) == (-10.0, 10.0)
    turned = diagnosed("motor", {"gravity.x": 6.0}, tmp_path)
    assert (turned.verdict, turned.effects) == ("named", ["gravity_load"])
    assert turned.parameters["gravity.x"].value == pytest.approx(6.0, rel=0.02)


COLUMNS = ("input_tension_N", "output_tension_N")
DRAWN, EXTRA, FRICTION = "sheath.drawn_bend", "sheath.extra_bend", "sheath.friction"
BEND_NOISE, TRUE = 0.1, 2.6
EFFECTS = [CATALOGUE[name] for name in ("bend_angle", "friction", "creep")]


def record(extra: float, rate: float, known: dict[str, float]) -> Recording:
    """A second of a bench that bends by less than its model, in one posture."""
    time = np.round(np.arange(0.0, 1.0, 0.01), 6)
    blank = bench_recording(
        f"posture {extra:g} {rate:g}",
        time,
        8e-4 * np.sin(rate * time),
        BEND_NOISE,
        COLUMNS,
        known={EXTRA: extra, **known},
        uncertain={FRICTION: Uncertain(0.15, 0.05, 0.4)},
    )
    random = np.random.default_rng(round(100.0 * rate))
    return measured_by(Simulator, blank, {DRAWN: TRUE, FRICTION: 0.2}, random)


def postures(**known: float) -> list[Recording]:
    stated = {f"sheath.{name}": value for name, value in known.items()}
    return [record(extra, rate, stated) for extra in (0.0, 2.0) for rate in (7.0, 9.0)]


def test_a_wrong_drawn_bend_is_told_from_friction_by_two_known_postures() -> None:
    train, held_out = postures()[::2], postures()[1::2]
    result = diagnose(train, held_out, catalogue=EFFECTS)
    assert (result.verdict, result.effects) == ("parameter", ["bend_angle"])
    value = result.parameters[DRAWN]
    assert value.low <= TRUE <= value.high
    assert value.value == pytest.approx(TRUE, abs=0.05)
    assert result.calibrated[FRICTION].value == pytest.approx(0.2, abs=0.005)
    assert "the bend of sheath is too high: 1" in result.sentence
    assert ", not 180°" in result.sentence


def test_a_drawn_bend_that_is_known_is_not_blamed() -> None:
    given = postures(drawn_bend=np.pi)
    result = diagnose(given[::2], given[1::2], catalogue=EFFECTS)
    assert "bend_angle" not in result.effects
    assert DRAWN not in result.parameters


@pytest.mark.parametrize("extra", [0.0, 2.0])
def test_who_knows_one_bend_of_all_recordings_knows_the_drawn_one(extra: float) -> None:
    given = [recording for recording in postures() if recording.known[EXTRA] == extra]
    problem = problem_of(Simulator, given)
    assert DRAWN in describe_system(problem).known
    both = Problem(tuple(postures()), Simulator(postures()), all_samples(postures()))
    assert DRAWN not in describe_system(both).known


def test_a_fitted_extra_bend_leaves_no_drawn_one_to_find() -> None:
    given = [replace(r, known={}, uncertain={EXTRA: Uncertain(0.0, -1.0, 1.0)}) for r in postures()]
    problem = problem_of(Simulator, given)
    assert DRAWN in describe_system(problem).uncertain


def test_paths_that_bend_differently_are_wrong_by_as_much() -> None:
    values = {"a.drawn_bend": 1.0, "b.drawn_bend": 0.25}
    rig = system(values)
    both = CATALOGUE["bend_angle"].bind(rig)[0]
    (term,) = both.terms
    assert both.where == "a, b"
    assert term.write(term.inert, values) == values
    assert term.write(1.5, values) == {"a.drawn_bend": 1.5, "b.drawn_bend": 0.75}
    assert term.write(term.low, values) == {"a.drawn_bend": 0.75, "b.drawn_bend": 0.0}
    assert max(term.write(term.high, values).values()) == term.high == 15.0
    said = _statement(both, values, term.write(1.5, values))
    assert said == "the bend of a and b is too low: 28.6° more than the model says"


def _statement(candidate: Candidate, before: dict[str, float], after: dict[str, float]) -> str:
    parameters = {name: Parameter(value, "rad", "live") for name, value in before.items()}
    return state_finding(candidate, parameters, before, after)


def test_a_term_that_all_elements_share_does_nothing_at_its_inert_value() -> None:
    values = {"a.creep": 0.0, "b.creep": 0.2, "c.creep": 0.05}
    rig = system(values)
    term = ParameterSpecification("creep", "-", 0.0, 1.0, 0.1).term(("a", "b", "c"), rig)
    assert term is not None
    assert term.write(term.inert, values) == pytest.approx(values)
    for number in (term.low, term.high):
        written = term.write(number, values).values()
        assert min(written) >= 0.0
        assert max(written) <= 1.0 + 1e-12
