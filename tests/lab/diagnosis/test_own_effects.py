"""Effects and simulators of one's own: named, refined, written, without a change to the package."""

from __future__ import annotations

import pickle
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tendon_mj.errors import InvalidValueError, TendonError, UnknownNameError
from tendon_mj.lab.diagnosis import (
    CATALOGUE,
    Effect,
    ParameterSpecification,
    SystemDescription,
    diagnose,
    on_joints,
    on_sheaths,
)
from tendon_mj.lab.diagnosis.effects import by_identifier, check_bindings
from tendon_mj.lab.recordings import Measured, Recording
from tendon_mj.lab.replay import Kind, Parameter, Simulator, replay_recording
from tendon_mj.models import load_model
from tendon_mj.typing import FloatArray
from tests.lab.diagnosis.toy import COLUMNS, NOISE, WEIGHTS, Toy, recording, refused, waveform

SPECIFICATION = ParameterSpecification("wear", "1/m", 0.0, 100.0, 0.5)
WEAR = Effect(
    identifier="wear",
    name="friction that grows with the distance slid",
    equation="μ (1 + w s)",
    signature="loops widen with every stroke",
    source="a test",
    binding=on_sheaths(SPECIFICATION),
    next_experiment="a thousand strokes",
)


class Longer(Toy):
    """The toy rig with one more parameter, whose waveform is a fast oscillation."""

    parameter, kind = "sheath.wear", "live"

    def __init__(self, recordings: Sequence[Recording]) -> None:
        super().__init__(recordings)
        kind: Kind = self.kind  # type: ignore[assignment]
        self.parameters = {**self.parameters, self.parameter: Parameter(0.0, "SI", kind)}

    def _one(self, changed: Mapping[str, float], recording: Recording) -> dict[str, FloatArray]:
        toy = {name: value for name, value in changed.items() if name in WEIGHTS}
        more = changed.get(self.parameter, 0.0) * np.sin(9.0 * recording.time)
        return {column: series + more for column, series in super()._one(toy, recording).items()}


class Jointed(Longer):
    """The toy rig with a joint, which moves freely."""

    parameter, kind = "elbow.damping", "joint"
    prescribed = False

    def __init__(self, recordings: Sequence[Recording]) -> None:
        super().__init__(recordings)
        self.joints = {"elbow": self.prescribed}


class Prescribed(Jointed):
    """The toy rig with a joint whose motion a driven column prescribes."""

    prescribed = True


class Stepped(Toy):
    """The toy rig with an error, proportional to its step, that looks like less friction."""

    step, steps = 1.0, 1000

    def in_steps(self, factor: float) -> Stepped:
        other = type(self)(self.recordings)
        other.step = factor * self.step
        other.steps = round(1000.0 / other.step)
        return other

    def _one(self, changed: Mapping[str, float], recording: Recording) -> dict[str, FloatArray]:
        friction = changed.get("sheath.friction", 0.15)
        error = -0.01 * self.step * friction * waveform("sheath.friction", recording)
        shares = WEIGHTS["sheath.friction"][1]
        series = super()._one(changed, recording)
        return {c: s + w * error for (c, s), w in zip(series.items(), shares, strict=True)}


def measured(simulator: type[Toy], truth: Mapping[str, float]) -> list[Recording]:
    """Four recordings of a rig, three to learn from and one for the proof."""
    random, made = np.random.default_rng(7), []
    for blank in (recording(f"r{k}", k, {}) for k in range(4)):
        series = simulator([blank])([truth])[0][0]
        noisy = {c: s + random.normal(0.0, NOISE, s.size) for c, s in series.items()}
        made.append(replace(blank, columns=blank.columns | noisy))
    return made


@pytest.mark.parametrize("catalogue", [[WEAR], [*CATALOGUE.values(), WEAR], {"any key": WEAR}])
def test_an_effect_of_ones_own_is_named(catalogue: Sequence[Effect] | Mapping[str, Effect]) -> None:
    made = measured(Longer, {"sheath.wear": 2.0, "sheath.friction": 0.2})
    found = diagnose(made[:3], made[3:], Longer, catalogue=catalogue)
    assert found.effects == ["wear"]
    assert found.findings[0].name == WEAR.name
    assert found.parameters["sheath.wear"].value == pytest.approx(2.0, rel=0.02)
    assert found.catalogue["wear"] is WEAR
    assert WEAR.name in found.sentence


def test_without_it_what_it_explains_is_unknown() -> None:
    made = measured(Longer, {"sheath.wear": 2.0})
    found = diagnose(made[:3], made[3:], Longer)
    assert found.verdict == "unknown"
    excluded = diagnose(made[:3], made[3:], Longer, catalogue=[WEAR], exclude="wear")
    assert excluded.verdict == "unknown"
    assert excluded.result()["excluded"] == ["wear"]


def test_names_of_another_catalogue_are_not_excluded() -> None:
    made = measured(Longer, {})
    with refused(UnknownNameError, "'backlash'", "'wear'"):
        diagnose(made[:3], made[3:], Longer, catalogue=[WEAR], exclude=["backlash"])


def test_an_effect_of_ones_own_that_binds_nowhere_is_warned_of_with_near_names() -> None:
    rig = SystemDescription(
        {"sheath.wear": 0.0, "elbow.damping": 0.1}, frozenset(), frozenset(), {}, (), ()
    )
    binding = on_sheaths(replace(SPECIFICATION, parameter="waer"))
    misspelt = replace(WEAR, identifier="misspelt", binding=binding)
    damping = ParameterSpecification("damping", "SI", 0.0, 1.0, 0.1)
    elsewhere = replace(WEAR, identifier="elsewhere", binding=on_joints(damping))
    with pytest.warns(RuntimeWarning, match="'misspelt' .*'waer'; did you mean 'wear'") as said:
        check_bindings(rig, (), by_identifier([*CATALOGUE.values(), WEAR, misspelt]))
    assert len(said) == 1
    with pytest.warns(RuntimeWarning, match=r"'elsewhere' .*no place among 'elbow\.damping'"):
        check_bindings(rig, (), by_identifier([WEAR, elsewhere]))
    check_bindings(rig, ["misspelt"], by_identifier([WEAR, misspelt]))


def test_a_catalogue_of_which_nothing_binds_is_refused() -> None:
    misspelt = replace(WEAR, binding=on_sheaths(replace(SPECIFICATION, parameter="waer")))
    made = measured(Longer, {})
    with refused(InvalidValueError, "'waer'", "did you mean 'wear'"):
        diagnose(made[:3], made[3:], Longer, catalogue=[misspelt])
    with refused(InvalidValueError, "'creep': unknown parameter 'creep'"):
        diagnose(made[:3], made[3:], Longer, catalogue=[CATALOGUE["creep"]])


@pytest.mark.parametrize(
    ("catalogue", "value"),
    [
        (WEAR, "'wear'"),
        ("backlash", "'backlash'"),
        (None, "None"),
        (["backlash"], "'backlash' must be a tendon_mj.Effect"),
        ({"wear": "wear"}, "'wear' must be a tendon_mj.Effect"),
        ([], "empty"),
        ([WEAR, replace(WEAR, name="another")], "two effects are called 'wear'"),
    ],
)
def test_other_things_than_a_catalogue_are_refused(catalogue: Any, value: str) -> None:
    with refused(InvalidValueError, "catalogue", value):
        diagnose([], catalogue=catalogue)


@pytest.mark.parametrize(("simulator", "effects"), [(Jointed, ["joint_damping"]), (Prescribed, [])])
def test_a_joint_is_blamed_unless_the_simulator_says_that_its_motion_is_prescribed(
    simulator: type[Toy], effects: list[str]
) -> None:
    made = measured(simulator, {"elbow.damping": 2.0})
    assert diagnose(made[:3], made[3:], simulator).effects == effects


def test_the_error_of_a_simulators_steps_is_taken_out() -> None:
    made = measured(Toy, {"sheath.friction": 0.2})
    refined = diagnose(made[:3], made[3:], Stepped).calibrated["sheath.friction"]
    exact = diagnose(made[:3], made[3:], Toy).calibrated["sheath.friction"]
    assert refined.value == pytest.approx(exact.value, abs=2e-4)
    assert 0.2 / 0.99 - refined.value > 1e-3  # to what it would be in the model's own steps


def test_simulations_of_ones_own_leave_the_stated_gap(tmp_path: Path) -> None:
    made = measured(Longer, {"sheath.wear": 2.0})
    found = diagnose(made[:3], made[3:], Longer, catalogue=[WEAR])
    ((recorded, before, after),) = found.simulate()
    assert recorded is made[3]
    for simulated, stated in ((before, found.held_out.before), (after, found.held_out.after)):
        errors = [(simulated.columns[c] - recorded.columns[c]) / NOISE for c in COLUMNS]
        assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(stated)
    with refused(TendonError, "sheath.wear"):  # no model of the package has it
        found.write_model(tmp_path / "model.xml")


INERTIA = Effect(
    identifier="rotor_inertia",
    name="inertia of a motor, reflected to its joint",
    equation="force = … + I q̈",
    signature="a lag that grows with the square of the frequency",
    source="MuJoCo, joint armature",
    binding=on_joints(ParameterSpecification("armature", "kg m² or kg", 0.0, 100.0, 0.1)),
)


def test_an_effect_on_a_parameter_of_mujoco_is_named_and_written(tmp_path: Path) -> None:
    random, time = np.random.default_rng(3), np.arange(0.0, 1.0, 0.005)
    made = []
    for k, rate in enumerate((30.0, 45.0)):
        place = 8e-4 * np.sin(rate * time) * np.minimum(time / 0.1, 1.0)
        columns = {"input_displacement_m": place, "output_tension_N": 0.0 * time}
        blank = Recording(
            name=f"r{k}",
            model="bench",
            source="made",
            time=time,
            columns=columns,
            drive={"input_displacement_m": "reel"},
            measured={"output_tension_N": Measured("output_tension", NOISE)},
        )
        column = replay_recording(blank, parameters={"environment.armature": 4.0}).columns[
            "output_tension_N"
        ]
        noisy = column + random.normal(0.0, NOISE, time.size)
        made.append(replace(blank, columns={**columns, "output_tension_N": noisy}))
    few = [CATALOGUE["sensor_bias"], CATALOGUE["backlash"], INERTIA]
    found = diagnose(made[:1], made[1:], Simulator, catalogue=few)
    assert found.effects == ["rotor_inertia"]
    assert found.parameters["environment.armature"].value == pytest.approx(4.0, rel=0.05)

    model = load_model(str(found.write_model(tmp_path / "model.xml")))
    ((_, _, after),) = found.simulate()
    again = replay_recording(made[1], model, described=False)
    np.testing.assert_allclose(
        again.columns["output_tension_N"], after.columns["output_tension_N"], atol=1e-9
    )
    sent = pickle.loads(pickle.dumps(found))
    assert sent.result() == found.result()
    assert sent.simulate()[0].after == after
