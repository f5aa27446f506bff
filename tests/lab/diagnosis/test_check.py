"""Which recordings are refused, and in what words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from tendon_mj.errors import InvalidValueError, RecordingError
from tendon_mj.lab.diagnosis import Problem, all_samples, diagnose, uncertain_terms
from tendon_mj.lab.diagnosis.check import make_simulator
from tendon_mj.lab.recordings import Recording, Uncertain, read_recording
from tendon_mj.lab.replay import Parameter, Simulates, Simulator
from tendon_mj.models import example_recording
from tendon_mj.typing import FloatArray
from tests.lab.diagnosis.toy import COLUMNS, Toy, recording, rig

COLUMN = next(iter(COLUMNS))


def test_a_tendon_that_never_reversed_gets_that_sentence() -> None:
    made = recording("one_way", 1, {})
    columns = dict(made.columns)
    columns["input_displacement_m"] = np.linspace(0.0, 1e-3, made.time.size)
    one_way = type(made)(
        name="one_way",
        model="bench",
        source="toy",
        time=made.time,
        columns=columns,
        drive=made.drive,
        measured=made.measured,
    )
    with pytest.raises(RecordingError, match="'one_way': the tendon never reversed"):
        diagnose([one_way], (), Toy)


def test_no_recording_is_refused() -> None:
    with pytest.raises(RecordingError, match="at least one recording"):
        diagnose([], (), Toy)


def test_jitter_is_no_reversal() -> None:
    made = recording("jitter", 1, {})
    jitter = 2e-6 * np.random.default_rng(1).standard_normal(made.time.size)
    way = np.linspace(0.0, 1e-3, made.time.size) + jitter
    with pytest.raises(RecordingError, match="'jitter': the tendon never reversed"):
        diagnose([replace(made, columns={**made.columns, "input_displacement_m": way})], (), Toy)


def test_proof_on_what_chose_is_refused() -> None:
    train, held_out = rig(1, {})
    with pytest.raises(RecordingError, match="among the training data"):
        diagnose(train, [*held_out, replace(train[0], name="copy")], Toy)


def later(made: Recording, first: int, last: int, name: str = "later") -> Recording:
    """Some of the samples, an hour later."""
    columns = {column: series[first:last] for column, series in made.columns.items()}
    return replace(made, name=name, time=made.time[first:last] + 3600.0, columns=columns)


def test_a_stretch_of_what_chose_proves_nothing_at_whatever_time() -> None:
    train, _ = rig(1, {})
    for stretch in (later(train[1], 0, 600), later(train[1], 50, 450)):
        with pytest.raises(RecordingError, match="'later': held out, and among the training data"):
            diagnose(train, [stretch], Toy)


def test_what_is_kept_for_the_proof_neither_reverses_nor_moves_the_rest() -> None:
    made = recording("late", 1, {})
    only_late = np.where(made.time < 5.0, made.time, 10.0 - made.time) * 1e-4
    columns = {**made.columns, "input_displacement_m": only_late}
    with pytest.raises(RecordingError, match=r"never reversed.* last quarter does not count"):
        diagnose([replace(made, columns=columns)], (), Toy)
    still = np.where(made.time < 5.0, 20.0, made.columns[COLUMN])
    columns = {**made.columns, COLUMN: still}
    with pytest.raises(RecordingError, match=f"'{COLUMN}': never moves.* last quarter"):
        diagnose([replace(made, columns=columns)], (), Toy)


def test_the_same_data_twice_is_refused() -> None:
    train, held_out = rig(1, {})
    copy = replace(train[0], name="copy")
    with pytest.raises(RecordingError, match=f"'copy': holds the same data as '{train[0].name}'"):
        diagnose([*train, copy], held_out, Toy)


def test_a_model_that_becomes_unstable_is_refused_with_the_range_of_the_drive() -> None:
    class Unstable(Toy):
        def _one(self, changed: Mapping[str, float], recording: Recording) -> dict[str, FloatArray]:
            return {c: s * np.nan for c, s in super()._one(changed, recording).items()}

    train, held_out = rig(1, {})
    with pytest.raises(RecordingError, match=r"unstable .*'input_displacement_m' from .* to "):
        diagnose(train, held_out, Unstable)
    stated = [replace(made, known={"sheath.axial_stiffness": 1e-29}) for made in train]
    with pytest.raises(RecordingError, match=r"with sheath.axial_stiffness = 1e-29.*; are the uni"):
        diagnose(stated, held_out, Unstable)
    many = {f"sheath.p{k}": float(k) for k in range(6)}
    stated = [replace(made, known=many) for made in train]
    with pytest.raises(RecordingError, match=r"sheath.p3 = 3 and \d values more; are the units"):
        diagnose(stated, held_out, Unstable)


class Short(Toy):
    """Simulator that forgets the last sample."""

    def _one(self, changed: Mapping[str, float], recording: Recording) -> dict[str, FloatArray]:
        return {c: s[:-1] for c, s in super()._one(changed, recording).items()}


class OneSensor(Toy):
    """Simulator that knows one sensor of two."""

    def _one(self, changed: Mapping[str, float], recording: Recording) -> dict[str, FloatArray]:
        return {COLUMN: super()._one(changed, recording)[COLUMN]}


class OneSet(Toy):
    """Simulator that answers the first set of parameters only."""

    def __call__(self, parameter_sets: Any) -> list[list[dict[str, FloatArray]]]:
        return super().__call__(parameter_sets[:1])


class OneRecording(Toy):
    """Simulator that answers the first recording only."""

    def __call__(self, parameter_sets: Any) -> list[list[dict[str, FloatArray]]]:
        return [answer[:1] for answer in super().__call__(parameter_sets)]


@pytest.mark.parametrize(
    ("simulator", "message"),
    [
        (Short, r"'Short', recording 'r0', column 'input_tension_N': .* \(599,\), .* \(600,\)"),
        (OneSensor, "'OneSensor', recording 'r0': answered 'input_tension_N', but 'output_ten"),
        (OneSet, r"'OneSet' answered 1 sets of parameters, not the \d+ it was asked for"),
        (OneRecording, r"'OneRecording' answered for 1 recordings, not for \d"),
    ],
)
def test_a_simulator_that_answers_otherwise_than_asked_is_refused(
    simulator: type[Simulates], message: str
) -> None:
    train, held_out = rig(1, {})
    with pytest.raises(InvalidValueError, match=message):
        diagnose(train, held_out, simulator)


@pytest.mark.parametrize("noise", [1e-29, 1e-14, 1e5, 1e29])
def test_noise_out_of_all_proportion_is_refused_with_the_range_of_its_column(noise: float) -> None:
    train, held_out = rig(1, {})
    measured = {**train[0].measured, COLUMN: replace(train[0].measured[COLUMN], noise=noise)}
    with pytest.raises(RecordingError, match=rf"'{COLUMN}': noise = .* times the range"):
        diagnose([replace(train[0], measured=measured), *train[1:]], held_out, Toy)


class Bare:
    """Simulator that is not derived from the protocol, and has but two of its members."""

    def __init__(self, recordings: object) -> None:
        self.parameters = {"sheath.friction": Parameter(0.15, "-", "live")}

    def __call__(self, parameter_sets: object) -> list[list[dict[str, FloatArray]]]:
        return []


class Mute(Simulates):
    """Simulator that forgets what simulates."""

    def __init__(self, recordings: object) -> None:
        self.parameters = {}


class Nameless(Simulates):
    """Simulator that forgets its parameters."""

    def __init__(self, recordings: object) -> None: ...

    def __call__(self, parameter_sets: object) -> list[list[dict[str, FloatArray]]]:
        return []


class Plain(Bare, Simulates):
    """Simulator whose parameters are what a test says."""

    given: object = None

    def __init__(self, recordings: object) -> None:
        self.parameters = self.given  # type: ignore[assignment]


class Unnamed(Plain):
    given = {"sheath.friction": 0.15}  # noqa: RUF012


@pytest.mark.parametrize(
    ("simulator", "message"),
    [
        (Bare, "'Bare' lacks 'joints', 'steps', 'in_steps'; derive it from tendon_mj.Simulates"),
        (Mute, "'Mute' lacks '__call__'; derive it from tendon_mj.Simulates"),
        (Nameless, "'Nameless' lacks 'parameters'; derive it from tendon_mj.Simulates"),
        (lambda recordings: None, "'NoneType' lacks 'parameters', '__call__', 'joints'"),
        (Plain, "'Plain': parameters = None must be a mapping"),
        (Unnamed, r"parameters\['sheath\.friction'\] = 0\.15 must be a tendon_mj\.Parameter"),
        (Toy([]), "'Toy' object is a simulator already; give what makes one"),
    ],
)
def test_a_simulator_that_lacks_a_member_is_refused_by_its_name(
    simulator: Any, message: str
) -> None:
    train, held_out = rig(1, {})
    with pytest.raises(InvalidValueError, match=message):
        diagnose(train, held_out, simulator)


@pytest.mark.parametrize("member", ["parameters", "__call__", "joints", "steps", "in_steps"])
def test_every_member_of_the_protocol_is_asked_for(member: str) -> None:
    assert hasattr(Simulates, member) or member in Simulates.__annotations__
    members = {"parameters", "__call__", "joints", "steps", "in_steps"} - {member}
    lacking = type("Lacking", (), {name: lambda *_: None for name in members})
    with pytest.raises(InvalidValueError, match=f"'Lacking' lacks '{member}'; derive"):
        make_simulator(lambda _: lacking(), [])  # type: ignore[arg-type]


def test_derived_from_the_protocol_a_simulator_needs_two_members() -> None:
    class Derived(Bare, Simulates):
        pass

    made = make_simulator(Derived, [])
    assert (dict(made.joints), made.steps, made.in_steps(2.0)) == ({}, 0, made)


def test_what_never_moves_is_refused_with_its_column() -> None:
    made = recording("still", 1, {})
    flat = replace(made, columns={**made.columns, "output_tension_N": np.full(made.time.size, 5.0)})
    with pytest.raises(RecordingError, match="'still', column 'output_tension_N': never moves"):
        diagnose([flat], (), Toy)


def test_a_handful_of_samples_is_refused() -> None:
    made = recording("short", 1, {})
    few = replace(made, time=made.time[::60], columns={c: v[::60] for c, v in made.columns.items()})
    with pytest.raises(RecordingError, match="10 samples"):
        diagnose([few], (), Toy)


@pytest.mark.parametrize("high", [0.02, 1.0, 1e3, 1e9])
def test_a_range_of_times_is_scaled_by_the_recording_at_most(high: float) -> None:
    recording = replace(
        read_recording(example_recording()),
        uncertain={"input_tension.lag": Uncertain(0.0, 0.0, high)},
    )
    simulate = Simulator([recording])
    (term,) = uncertain_terms(Problem([recording], simulate, all_samples([recording])))
    assert term.high == high
    assert term.probe == pytest.approx(0.05 * min(high, np.ptp(recording.time)))


def test_parameters_that_one_name_stands_for_keep_their_own_units() -> None:
    units = {"hinge.damping": "N m s/rad", "slide.damping": "N s/m"}
    made = SimpleNamespace(
        recordings=[
            replace(recording("r", 1, {}), uncertain={"*.damping": Uncertain(0.1, 0.0, 1.0, True)})
        ],
        simulate=SimpleNamespace(
            parameters={name: Parameter(0.1, unit, "joint") for name, unit in units.items()}
        ),
    )
    terms = uncertain_terms(cast(Problem, made))
    assert {term.targets[0]: term.unit for term in terms} == units
