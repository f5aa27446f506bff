"""Laws of a gear behind a reading and of a slip: planted, named, measured, and no other taken."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from itertools import chain
from pathlib import Path

import numpy as np
import pytest

from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.diagnosis import CATALOGUE, Candidate, Diagnosis, Term, diagnose, fit
from tendon_mj.lab.diagnosis.events import find_events
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Adjustable, patch_model, read_intervals, replay_recording
from tendon_mj.models import load_model
from tendon_mj.typing import FloatArray
from tests.lab.diagnosis.toy import Added, bench_recording, problem_of
from tests.refusals import refusing

NOISE = {"input_tension_N": 0.1, "output_tension_N": 0.1}
DRIVE = "input_displacement_m"
SLIP = {"reel.slip": -4e-4, "reel.slip_time": 0.603, "reel.slip_duration": 0.024}
# effects that might be taken for a gear or a slip, and the two
FEW = [
    CATALOGUE[name]
    for name in (
        *("gear_efficiency", "slip", "friction", "backlash", "creep", "constant_friction"),
        *("sensor_bias", "sensor_gain", "sensor_drift", "pretension"),
    )
]


def bench(name: str, turns: list[float], known: dict[str, float]) -> Recording:
    """The bench driven between turning points [mm], read with noise, with more than it says."""
    time = np.arange(0.0, 1.2, 0.01)
    corners = np.linspace(0.05, 1.2, len(turns))
    place = 1e-3 * np.interp(time, corners, turns)
    bare = bench_recording(name, time, place, 0.1, list(NOISE))
    clean = replay_recording(bare, parameters=known).columns
    random = np.random.default_rng(len(name))
    noisy = {c: clean[c] + random.normal(0.0, noise, time.size) for c, noise in NOISE.items()}
    return replace(bare, columns={DRIVE: place, **noisy})


UP_AND_DOWN, OTHER = [0.0, 1.0, -0.6, 0.9, 0.1, 0.8], [0.0, -0.7, 1.1, 0.2, 0.7, -0.3]


def diagnosed(
    common: dict[str, float],
    own: dict[str, float] | None = None,
    held_out: tuple[Recording, ...] | None = None,
) -> Diagnosis:
    """Diagnosis of two recordings, the second of which has something of its own."""
    train = [bench("first", UP_AND_DOWN, common), bench("second", OTHER, {**common, **(own or {})})]
    unseen = (bench("unseen", OTHER[::-1], common),) if held_out is None else held_out
    return diagnose(train, unseen, catalogue=FEW)


def test_a_gear_is_named_and_measured_and_the_model_has_it(tmp_path: Path) -> None:
    outcome = diagnosed({"input_tension.efficiency": 0.8})
    assert (outcome.verdict, outcome.effects) == ("named", ["gear_efficiency"])
    value = outcome.parameters["input_tension.efficiency"]
    assert value.low <= 0.8 <= value.high
    assert value.high - value.low < 0.02
    made = outcome.write_model(tmp_path / "model.xml")
    assert read_intervals(load_model(str(made)))["input_tension.efficiency"][1] < 0.85
    replayed = replay_recording(bench("third", UP_AND_DOWN, {}), load_model(str(made)))
    fitted = {name: value.value for name, value in outcome.parameters.items()}
    meant = replay_recording(bench("third", UP_AND_DOWN, {}), parameters=fitted)
    for column in NOISE:
        np.testing.assert_allclose(replayed.columns[column], meant.columns[column], rtol=1e-12)


@pytest.mark.parametrize("held_out", [None, ()], ids=["held out", "tails"])
def test_a_slip_is_named_with_its_size_its_time_and_its_recording(
    held_out: tuple[Recording, ...] | None, tmp_path: Path
) -> None:
    outcome = diagnosed({}, SLIP, held_out)
    assert (outcome.verdict, outcome.effects) == ("named", ["slip"])
    size, when, _ = values = [outcome.parameters[f"{name} @ second"] for name in SLIP]
    for value, truth in zip(values, SLIP.values(), strict=True):
        assert value.low <= truth <= value.high
    assert abs(size.value - SLIP["reel.slip"]) < 1e-5
    assert when.high - when.low <= 0.02
    assert abs(when.value - SLIP["reel.slip_time"]) < 0.002
    for word in ("µm", "let out", "0.6", "'second'", "reel"):
        assert word in outcome.findings[0].statement
    assert json.loads(json.dumps(outcome.result()))["parameters"]["reel.slip @ second"]
    text = outcome.write_model(tmp_path / "model.xml").read_text("utf-8")
    assert "slip" not in text.replace("slip_", "")
    shown = {row.measured.name for row in outcome.simulate()}
    assert "second" in shown


@pytest.mark.parametrize("shows", [1.0, 1e4])
def test_no_slip_larger_than_the_drive_moves_is_tried_and_one_that_fails_is_passed_over(
    shows: float,
) -> None:
    """A slip hardly shows on one rig, whose misfit is large, and breaks another."""
    time = np.arange(0.0, 4.0, 0.02)
    step = 30.0 * (time > 2.0)
    blank = bench_recording("r", time, 1e-3 * np.sin(time), 1.0, ["input_tension_N"])
    misfit = replace(blank, columns={**blank.columns, "input_tension_N": step})
    tried = []

    class Slipping(Added):
        sessions = True

        def waveform(self, parameter: str, column: str, recording: Recording) -> FloatArray:
            return np.full(time.size, shows)

        def _one(self, changed: Mapping[str, float], recording: Recording) -> dict[str, FloatArray]:
            size = changed.get("reel.slip @ r", 0.0)
            tried.append(abs(size))
            bears = size if abs(size) < 1e-3 else np.inf
            return super()._one({"reel.slip": bears}, recording)

    values = {"reel.slip": 0.0, "reel.command_scale": 1.0}
    problem = problem_of(lambda made: Slipping(made, values), [misfit])
    slip = Candidate(CATALOGUE["slip"], "reel", (Term(("reel.slip",), "m", 0.0, -1, 1, 1e-4),))
    fitted = fit(problem, {}, (), (), np.zeros(0))
    assert not find_events(problem, {}, fitted, [slip], set(), 0.01)
    assert 0.0 < max(tried) <= np.ptp(blank.columns[DRIVE])


def test_a_slip_in_a_recordings_known_replays_it() -> None:
    slipped = bench("second", OTHER, SLIP)
    stated = replay_recording(replace(slipped, known=SLIP))
    since, lasting = SLIP["reel.slip_time"], SLIP["reel.slip_duration"]
    share = np.clip((slipped.time - since) / lasting, 0.0, 1.0)
    moved = slipped.columns[DRIVE] + SLIP["reel.slip"] * share
    shifted = replay_recording(replace(slipped, columns={**slipped.columns, DRIVE: moved}))
    for column, noise in NOISE.items():
        assert np.std(slipped.columns[column] - stated.columns[column]) < 1.1 * noise
        difference = np.abs(stated.columns[column] - shifted.columns[column])
        ramp = np.searchsorted(slipped.time, since) + np.arange(-1, 20)  # whose corners differ
        assert np.delete(difference, ramp).max() < 0.1 * noise


def test_a_slip_is_of_no_model(tmp_path: Path) -> None:
    with refusing(InvalidValueError, "reel.slip", "[known]"):
        patch_model("bench", {"reel.slip": 1e-3}, tmp_path / "model.xml")


def test_only_what_takes_a_place_slips_and_only_what_bears_a_load_has_a_gear() -> None:
    names = Adjustable(load_model("joint")).names()
    slipping = [name for name in names if name.endswith(".slip")]
    geared = [name for name in names if name.endswith(".efficiency")]
    assert slipping == ["command.slip", "reel_1.slip", "reel_2.slip"]
    assert geared == ["input_tension_1.efficiency", "input_tension_2.efficiency"]


@pytest.mark.parametrize(
    ("common", "own", "right"),
    [
        ({"sheath.friction": 0.25}, {}, "friction"),
        ({"sheath.backlash": 2e-4}, {}, "backlash"),
        ({"input_tension.scale": 1.1}, {}, "sensor_gain"),
        ({"input_tension.drift": 0.5}, {}, "sensor_drift"),
        ({"sheath.creep": 0.4, "sheath.creep_time": 0.4}, {}, "creep"),
    ],
)
def test_neither_takes_the_place_of_another(
    common: dict[str, float], own: dict[str, float], right: str
) -> None:
    outcome = diagnosed(common, own)
    assert outcome.effects[:1] == [right]
    assert not {"gear_efficiency", "slip"} & {*outcome.effects, *chain(*outcome.indistinguishable)}


def test_a_step_of_one_readings_zero_is_no_slip() -> None:
    train = [bench("first", UP_AND_DOWN, {}), bench("second", OTHER, {})]
    stepped = train[1].columns["input_tension_N"] + 3.0 * (train[1].time > 0.6)
    train[1] = replace(train[1], columns={**train[1].columns, "input_tension_N": stepped})
    outcome = diagnose(train, [bench("unseen", OTHER[::-1], {})], catalogue=FEW)
    assert "slip" not in (*outcome.effects, *outcome.closest)


@pytest.mark.parametrize("size", [4e-4, -1e-3])
def test_another_zero_of_the_drive_from_the_start_is_no_slip(size: float) -> None:
    another = {"reel.slip": size, "reel.slip_time": -1.0, "reel.slip_duration": 0.0}
    assert "slip" not in diagnosed({}, another).effects


def test_with_nothing_hidden_nothing_is_named() -> None:
    outcome = diagnosed({})
    assert outcome.verdict == "nothing missing"
