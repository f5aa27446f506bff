"""Effects on a model: where they bind, and a user's own, named without a change to the package."""

from __future__ import annotations

import pickle
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from tendon_mj.errors import InvalidValueError, TendonError
from tendon_mj.lab.diagnosis import CATALOGUE, Effect, candidates, diagnose
from tendon_mj.lab.diagnosis.effects import by_identifier, check_bindings
from tendon_mj.lab.diagnosis.effects.binding import (
    ParameterSpecification,
    frictionless_sheaths,
    on,
    on_gravity,
    on_inputs,
    on_joints,
    on_sensors,
    on_sheaths,
    together,
)
from tendon_mj.lab.diagnosis.effects.effect import Binding
from tendon_mj.lab.diagnosis.fitting import Fit
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Kind, Parameter, Simulator, replay_recording
from tendon_mj.models import load_model
from tendon_mj.typing import FloatArray
from tests.lab.diagnosis.toy import (
    COLUMNS,
    NOISE,
    Stepped,
    Toy,
    bench_recording,
    measured_by,
    recording,
    system,
)
from tests.refusals import refusing


def effect(binding: Binding, **more: object) -> Effect:
    return Effect("slack", "a slack", "x + s", "a lag", "a test", binding, **more)  # type: ignore[arg-type]


def where(*sheaths: str, known: frozenset[str] = frozenset()) -> list[str]:
    """Elements of every candidate for dry friction that the tension does not change."""
    rig = system({f"{sheath}.constant_friction": 0.0 for sheath in sheaths}, known=known)
    return [c.where for c in candidates(rig) if c.identifier == "constant_friction"]


def test_an_effect_of_the_sheath_is_on_all_of_them_or_on_one() -> None:
    assert where("left") == ["left"]
    assert where("left", "right") == ["left, right", "left", "right"]


def test_what_is_known_of_one_sheath_leaves_the_others() -> None:
    known = frozenset({"left.constant_friction"})
    assert where("left", "right", known=known) == ["right"]


def test_what_is_known_of_the_rig_is_overridden_only_where_the_effect_says_so() -> None:
    rig = system({"a.slack": 0.0}, known=frozenset({"a.slack"}))
    binding = on_sheaths(ParameterSpecification("slack", "m", 0.0, 1.0, 0.1))
    assert effect(binding).bind(rig) == []
    assert [c.where for c in effect(binding, overrides_known=True).bind(rig)] == ["a"]


SLACK = ParameterSpecification("slack", "m", -1.0, 1.0, 0.1)


@pytest.mark.parametrize(
    ("binding", "where"),
    [
        (on_sheaths(SLACK), ["ear, elbow, winch", "ear", "elbow", "winch"]),
        (on_sensors(SLACK), ["ear"]),
        (on_joints(SLACK), ["elbow"]),
        (on_inputs(SLACK), ["winch"]),
        (together(on_inputs(SLACK), on_joints(SLACK)), ["winch", "elbow"]),
        (on_gravity(ParameterSpecification("x", "m/s²", -1.0, 1.0, 0.1)), ["gravity"]),
        (on_joints(ParameterSpecification("none", "m", -1.0, 1.0, 0.1)), []),
    ],
)
def test_a_binding_finds_the_elements_of_its_kind(binding: Binding, where: list[str]) -> None:
    rig = system(
        {"elbow.slack": 0.0, "ear.slack": 0.0, "winch.slack": 0.0, "gravity.x": 0.0},
        spans={"ear": 4.0},
        inputs=("winch",),
        free_joints=("elbow",),
    )
    assert [elements for elements, _ in binding(rig)] == where


def test_what_one_column_drives_is_bound_together() -> None:
    alone = system({"a.slack": 0.0, "b.slack": 0.0, "c.slack": 0.0}, inputs=("a", "b", "c"))
    rig = replace(alone, columns=(("a", "c"),))
    assert [elements for elements, _ in on_inputs(SLACK)(rig)] == ["a, c", "b"]


def test_the_range_of_a_sensor_is_in_shares_of_its_span() -> None:
    rig = system({"ear.slack": 0.0}, spans={"ear": 4.0})
    ((_, (scaled,)),) = on_sensors(SLACK)(rig)
    ((_, (plain,)),) = on_sensors(SLACK, spans=False)(rig)
    assert (scaled.low, scaled.high, scaled.probe) == (-4.0, 4.0, 0.4)
    assert (plain.low, plain.high, plain.probe) == (-1.0, 1.0, 0.1)


def test_a_wrong_parameter_is_sought_about_the_model_s_own_value() -> None:
    share = ParameterSpecification("slack", "m", 0.5, 2.0, 0.1, relative=True)
    ((_, (term,)),) = on_joints(share)(system({"a.slack": -4.0}, free_joints=("a",)))
    assert (term.inert, term.low, term.high, term.probe) == (1.0, 0.5, 2.0, 0.1)
    assert term.write(term.inert, {}) == {"a.slack": -4.0}
    assert term.write(2.0, {"a.slack": 7.0}) == {"a.slack": -8.0}


def test_several_get_a_common_factor_whatever_their_values_and_those_of_none_are_left_out() -> None:
    share = ParameterSpecification("slack", "m", 0.5, 2.0, 0.1, relative=True)
    rig = system({"a.slack": 1.0, "b.slack": -2.0, "c.slack": 0.0})
    bound = dict(on_sheaths(share)(rig))
    assert list(bound) == ["a, b", "a", "b"]
    (common,) = bound["a, b"]
    assert common.write(1.5, {}) == {"a.slack": 1.5, "b.slack": -3.0}
    assert [where for where, _ in on_sheaths(share)(system({"a.slack": 1.0, "c.slack": 0.0}))] == [
        "a"
    ]
    assert on_sheaths(share)(system({"c.slack": 0.0})) == []


def test_the_range_takes_in_what_the_model_has() -> None:
    ((_, (term,)),) = on_joints(SLACK)(system({"a.slack": 3.0}, free_joints=("a",)))
    assert (term.inert, term.low, term.high) == (3.0, -1.0, 3.0)


def test_a_relative_target_follows_the_other_parameter() -> None:
    excess = ParameterSpecification("static", "-", 0.0, 3.0, 0.2, relative_to="dynamic")
    ((_, (term,)),) = on_joints(excess)(
        system({"a.static": 0.0, "a.dynamic": 0.2}, free_joints=("a",))
    )
    assert term.write(0.5, {"a.dynamic": 0.2}) == {"a.static": pytest.approx(0.3)}


@pytest.mark.parametrize(("friction", "count"), [(0.0, 1), (0.1, 0)])
def test_a_first_friction_is_sought_only_where_there_is_none(friction: float, count: int) -> None:
    specification = ParameterSpecification("friction", "-", 0.0, 1.0, 0.02)
    rig = system({"a.friction": friction})
    assert len(on(frictionless_sheaths, specification, shared=True)(rig)) == count


@pytest.mark.parametrize(
    ("change", "value"),
    [
        ({"high": -1.0}, "-1 … -1"),
        ({"probe": 0.0}, "probe = 0"),
        ({"starts": (0.0,)}, "start 0"),
        ({"starts": (2.0,)}, "start 2"),
    ],
)
def test_a_specification_that_no_fit_could_use_is_refused(
    change: dict[str, Any], value: str
) -> None:
    with refusing(InvalidValueError, "slack", value):
        replace(SLACK, **change)


def test_every_effect_of_the_catalogue_can_be_sent_to_a_process() -> None:
    rig = system({"a.backlash": 0.0, "a.friction": 0.1})
    sent = pickle.loads(pickle.dumps(CATALOGUE))
    assert sent.keys() == CATALOGUE.keys()
    assert candidates(rig, catalogue=sent) == candidates(rig)


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

    parameter, kind = "sheath.wear", cast(Kind, "live")

    def __init__(self, recordings: Sequence[Recording]) -> None:
        super().__init__(recordings)
        self.parameters = {**self.parameters, self.parameter: Parameter(0.0, "SI", self.kind)}

    def waveform(self, parameter: str, column: str, recording: Recording) -> FloatArray:
        if parameter == self.parameter:
            return np.sin(9.0 * recording.time)
        return super().waveform(parameter, column, recording)


class Jointed(Longer):
    """The toy rig with a joint, which moves freely."""

    parameter, kind, joints = "elbow.damping", "joint", {"elbow": False}


class Prescribed(Jointed):
    """The toy rig with a joint whose motion a driven column prescribes."""

    joints = {"elbow": True}  # noqa: RUF012


def measured(simulator: type[Toy], truth: Mapping[str, float]) -> list[Recording]:
    """Four recordings of a rig, three to learn from and one for the proof."""
    random = np.random.default_rng(7)
    blanks = (recording(f"r{k}", k, {}) for k in range(4))
    return [measured_by(simulator, blank, truth, random) for blank in blanks]


@pytest.mark.parametrize("catalogue", [[WEAR], [*CATALOGUE.values(), WEAR], {"any key": WEAR}])
def test_an_effect_of_ones_own_is_named(catalogue: Sequence[Effect] | Mapping[str, Effect]) -> None:
    made = measured(Longer, {"sheath.wear": 2.0, "sheath.friction": 0.2})
    outcome = diagnose(made[:3], made[3:], Longer, catalogue=catalogue)
    assert outcome.effects == ["wear"]
    assert outcome.findings[0].name == WEAR.name
    assert outcome.parameters["sheath.wear"].value == pytest.approx(2.0, rel=0.02)
    assert outcome.catalogue["wear"] is WEAR
    assert WEAR.name in outcome.sentence


def test_an_effect_of_ones_own_that_binds_nowhere_is_warned_of_with_near_names() -> None:
    rig = system({"sheath.wear": 0.0, "elbow.damping": 0.1})
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
    with refusing(InvalidValueError, "'waer'", "did you mean 'wear'"):
        diagnose(made[:3], made[3:], Longer, catalogue=[misspelt])
    with refusing(InvalidValueError, "'creep': unknown parameter 'creep'"):
        diagnose(made[:3], made[3:], Longer, catalogue=[CATALOGUE["creep"]])
    with refusing(InvalidValueError, "catalogue", "empty"):
        diagnose(made[:3], made[3:], Longer, catalogue=[])


@pytest.mark.parametrize(
    ("catalogue", "value"),
    [
        (["backlash"], "'backlash' must be a tendon_mj.Effect"),
        ({"wear": "wear"}, "'wear' must be a tendon_mj.Effect"),
        ([WEAR, replace(WEAR, name="another")], "two effects are called 'wear'"),
    ],
)
def test_other_things_than_a_catalogue_are_refused(catalogue: Any, value: str) -> None:
    with refusing(InvalidValueError, "catalogue", value):
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
    outcome = diagnose(made[:3], made[3:], Longer, catalogue=[WEAR])
    ((recorded, before, after),) = outcome.simulate()
    assert recorded is made[3]
    for simulated, stated in ((before, outcome.held_out.before), (after, outcome.held_out.after)):
        errors = [(simulated.columns[c] - recorded.columns[c]) / NOISE for c in COLUMNS]
        assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(stated)
    with refusing(TendonError, "sheath.wear"):  # no model of the package has it
        outcome.write_model(tmp_path / "model.xml")


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
        blank = bench_recording(f"r{k}", time, place, NOISE, ["output_tension_N"])
        made.append(measured_by(Simulator, blank, {"environment.armature": 4.0}, random))
    few = [CATALOGUE["sensor_bias"], CATALOGUE["backlash"], INERTIA]
    outcome = diagnose(made[:1], made[1:], Simulator, catalogue=few)
    assert outcome.effects == ["rotor_inertia"]
    assert outcome.parameters["environment.armature"].value == pytest.approx(4.0, rel=0.05)

    model = load_model(str(outcome.write_model(tmp_path / "model.xml")))
    ((_, _, after),) = outcome.simulate()
    again = replay_recording(made[1], model, described=False)
    np.testing.assert_allclose(
        again.columns["output_tension_N"], after.columns["output_tension_N"], atol=1e-9
    )
    sent = pickle.loads(pickle.dumps(outcome))
    assert sent.result() == outcome.result()
    assert sent.simulate()[0].after == after


@pytest.mark.parametrize(("time", "determined"), [(0.1, False), (0.8, True), (30.0, True)])
def test_creep_in_no_time_is_not_determined_as_it_is_a_softer_cable(
    time: float, determined: bool
) -> None:
    rig = system({"s.creep": 0.0, "s.creep_time": 0.0, "s.axial_stiffness": 6e3})
    (creep,) = (c for c in candidates(rig) if c.identifier == "creep")
    ends = np.array([[t.scaled(t.low), t.scaled(t.high)] for t in creep.terms]).T
    at = np.array([t.scaled(x) for t, x in zip(creep.terms, (0.3, time), strict=True)])
    fit = SimpleNamespace(
        free=np.array([True, time == 0.8]),
        terms_of=lambda _: slice(0, 2),
        scaled=at,
        bounds=ends,
    )
    assert Fit.determines(cast(Fit, fit), creep) == determined
