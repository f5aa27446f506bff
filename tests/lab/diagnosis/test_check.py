"""Recordings and simulators that are refused, with the place and the value."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from tendon_mj.errors import InvalidValueError, RecordingError
from tendon_mj.lab.diagnosis import Problem, diagnose, uncertain_terms
from tendon_mj.lab.recordings import Recording, Uncertain, read_recording, write_recording
from tendon_mj.lab.replay import Parameter, Simulates, Simulator
from tendon_mj.models import example_recording
from tendon_mj.typing import FloatArray
from tests.lab.diagnosis.toy import COLUMNS, Toy, problem_of, recording, rig
from tests.refusals import refusing

COLUMN = next(iter(COLUMNS))
DRIVE = "input_displacement_m"


def with_columns(made: Recording, **columns: FloatArray) -> Recording:
    return replace(made, columns={**made.columns, **columns})


@pytest.mark.parametrize("jitter", [0.0, 2e-6])
def test_a_tendon_that_never_reversed_but_for_jitter_gets_that_sentence(jitter: float) -> None:
    made = recording("one_way", 1, {})
    noise = jitter * np.random.default_rng(1).standard_normal(made.time.size)
    way = np.linspace(0.0, 1e-3, made.time.size) + noise
    with pytest.raises(RecordingError, match="'one_way': the tendon never reversed"):
        diagnose([with_columns(made, **{DRIVE: way})], (), Toy)


def test_recordings_are_given_as_themselves_or_by_paths_one_or_several(tmp_path: Path) -> None:
    (first, *_), (proof, *_) = rig(1, {"sheath.friction": 0.2})
    apart, paths = tmp_path / "rig.toml", list[Path]()
    for made in (first, proof):
        paths.append(write_recording(made, tmp_path / made.name))
        paths[-1].with_suffix(".toml").replace(apart)
    expected = diagnose([first], [proof], Toy).result()
    for train, held_out in ((paths[0], paths[1]), ([str(paths[0])], [proof]), (first, proof)):
        found = diagnose(train, held_out, Toy, description=apart).result()
        assert found["verdict"] == expected["verdict"]
        assert found["parameters"] == expected["parameters"]
    with refusing(RecordingError, "pass `description`"):
        diagnose(paths[0], (), Toy)


def test_unusable_recordings_are_refused_by_name() -> None:
    train, held_out = rig(1, {})
    made = train[0]
    copy = replace(made, name="copy")
    flat = with_columns(made, output_tension_N=np.full(made.time.size, 5.0))
    few = replace(made, time=made.time[::60], columns={c: v[::60] for c, v in made.columns.items()})
    for recordings, proof, facts in (
        ([], [], ["at least one recording"]),
        (train, [*held_out, copy], ["'copy'", "among the training data"]),
        ([*train, copy], held_out, ["'copy'", f"'{made.name}'"]),
        ([flat], [], [f"'{made.name}'", "'output_tension_N'", "never moves"]),
        ([few], [], [f"'{made.name}'", "10 samples"]),
    ):
        with refusing(RecordingError, *facts):
            diagnose(recordings, proof, Toy)


@pytest.mark.parametrize(("first", "last"), [(0, 600), (50, 450)])
def test_a_stretch_of_the_training_data_proves_nothing_at_whatever_time(
    first: int, last: int
) -> None:
    train, _ = rig(1, {})
    made = train[1]
    columns = {column: series[first:last] for column, series in made.columns.items()}
    later = replace(made, name="later", time=made.time[first:last] + 3600.0, columns=columns)
    with refusing(RecordingError, "'later'", "among the training data"):
        diagnose(train, [later], Toy)


def test_the_tail_that_is_kept_for_the_proof_neither_reverses_nor_moves_the_rest() -> None:
    made = recording("late", 1, {})
    only_late = np.where(made.time < 5.0, made.time, 10.0 - made.time) * 1e-4
    still = np.where(made.time < 5.0, 20.0, made.columns[COLUMN])
    for columns, fact in (({DRIVE: only_late}, "never reversed"), ({COLUMN: still}, "never moves")):
        with refusing(RecordingError, "'late'", fact, "last quarter"):
            diagnose([with_columns(made, **columns)], (), Toy)


class Unstable(Toy):
    def _one(self, changed: Mapping[str, float], recording: Recording) -> dict[str, FloatArray]:
        return {c: s * np.nan for c, s in super()._one(changed, recording).items()}


@pytest.mark.parametrize(
    ("known", "facts"),
    [
        ({}, ["unstable", f"'{DRIVE}' from"]),
        ({"sheath.axial_stiffness": 1e-29}, ["with sheath.axial_stiffness = 1e-29", "units"]),
        ({f"sheath.p{k}": float(k) for k in range(6)}, ["sheath.p3 = 3 and", "values more"]),
    ],
)
def test_a_model_that_becomes_unstable_is_refused_with_the_range_of_the_drive(
    known: dict[str, float], facts: list[str]
) -> None:
    train, held_out = rig(1, {})
    with refusing(RecordingError, *facts):
        diagnose([replace(made, known=known) for made in train], held_out, Unstable)


def odd(change: Callable[[Any], Any]) -> type[Toy]:
    """Simulator whose answers are changed."""
    answer = Toy.__call__
    return type("Odd", (Toy,), {"__call__": lambda self, sets: change(answer(self, sets))})


SHORT = odd(lambda sets: [[{c: s[:-1] for c, s in r.items()} for r in answer] for answer in sets])
ONE_SENSOR = odd(lambda sets: [[{COLUMN: r[COLUMN]} for r in answer] for answer in sets])
ONE_SET = odd(lambda sets: sets[:0])
ONE_RECORDING = odd(lambda sets: [answer[:1] for answer in sets])


class Bare:
    """Simulator that is not derived from the protocol, and has but two of its members."""

    parameters: object = {"sheath.friction": Parameter(0.15, "-", "live")}

    def __init__(self, recordings: object) -> None:
        pass

    def __call__(self, parameter_sets: object) -> list[list[dict[str, FloatArray]]]:
        return []


def with_parameters(given: object) -> Callable[[object], object]:
    """Maker of simulators that have these parameters."""
    return lambda _: type("Odd", (Bare, Simulates), {"parameters": given})([])


@pytest.mark.parametrize(
    ("simulator", "facts"),
    [
        (SHORT, ["'Odd'", "'r0'", "'input_tension_N'", "(599,)", "(600,)"]),
        (ONE_SENSOR, ["'Odd'", "'r0'", "'output_tension_N'", "nothing"]),
        (ONE_SET, ["'Odd' answered 0 of 1"]),
        (ONE_RECORDING, ["'Odd' answered for 1 of 3"]),
        (Bare, ["'Bare' lacks 'joints', 'steps', 'in_steps'", "tendon_mj.Simulates"]),
        (with_parameters(None), ["'Odd'", "parameters = None"]),
        (with_parameters({"a.b": 0.15}), ["'Odd'", "'a.b': 0.15", "tendon_mj.Parameter"]),
        (Toy([]), ["'Toy' object is a simulator already"]),
    ],
)
def test_a_simulator_that_lacks_a_member_or_an_answer_is_refused(
    simulator: Any, facts: list[str]
) -> None:
    train, held_out = rig(1, {})
    with refusing(InvalidValueError, *facts):
        diagnose(train, held_out, simulator)


@pytest.mark.parametrize("high", [0.02, 1.0, 1e3, 1e9])
def test_a_range_of_times_is_scaled_by_the_recording_at_most(high: float) -> None:
    made = replace(
        read_recording(example_recording()),
        uncertain={"input_tension.lag": Uncertain(0.0, 0.0, high)},
    )
    (term,) = uncertain_terms(problem_of(Simulator, [made]))
    assert term.high == high
    assert term.probe == pytest.approx(0.05 * min(high, np.ptp(made.time)))


def test_parameters_that_one_name_stands_for_keep_their_own_units() -> None:
    units = {"hinge.damping": "N m s/rad", "slide.damping": "N s/m"}
    given = replace(recording("r", 1, {}), uncertain={"*.damping": Uncertain(0.1, 0.0, 1.0, True)})
    parameters = {name: Parameter(0.1, unit, "joint") for name, unit in units.items()}
    made = SimpleNamespace(recordings=[given], simulate=SimpleNamespace(parameters=parameters))
    terms = uncertain_terms(cast(Problem, made))
    assert {term.targets[0]: term.unit for term in terms} == units
