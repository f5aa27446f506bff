"""The workflow on a rig whose every answer is known beforehand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tendon_mj.errors import UnknownNameError
from tendon_mj.lab.diagnosis import CATALOGUE, Diagnosis, diagnose
from tendon_mj.lab.diagnosis.regimes import regimes
from tendon_mj.lab.recordings import Uncertain
from tendon_mj.lab.replay import Simulator
from tests.lab.diagnosis.toy import (
    COLUMNS,
    NOISE,
    Toy,
    bench_recording,
    measured_by,
    recording,
    rig,
)
from tests.refusals import refusing

COLUMN = next(iter(COLUMNS))
FRICTION = "sheath.friction"
JOINTS = ("joint_stiffness", "joint_damping", "joint_friction")
EFFECTS = {
    "constant_friction": {"sheath.constant_friction": 1.0},
    "backlash": {"sheath.backlash": 3e-5},
    "direction_asymmetry": {"sheath.direction_asymmetry": -0.1},
    "friction_drift": {"sheath.friction_drift": 0.05},
    "sensor_bias": {"output_tension.offset": -0.6},
}


def in_range(friction: float, guess: float, low: float, high: float, seed: int = 2) -> Diagnosis:
    """Diagnosis of a rig of that friction, which its recordings guess within a range."""
    train, held_out = (
        [replace(r, uncertain={FRICTION: Uncertain(guess, low, high)}) for r in made]
        for made in rig(seed, {FRICTION: friction})
    )
    return diagnose(train, held_out, Toy)


@pytest.mark.parametrize("effect", EFFECTS)
def test_an_effect_that_is_there_is_named_and_measured(effect: str) -> None:
    train, held_out = rig(1, {FRICTION: 0.2, **EFFECTS[effect]})
    diagnosis = diagnose(train, held_out, Toy)
    assert (diagnosis.verdict, diagnosis.effects) == ("named", [effect])
    assert diagnosis.held_out.reducible_closed > 0.95
    for name, value in EFFECTS[effect].items():
        got = diagnosis.parameters[name]
        assert got.low <= got.value <= got.high
        assert got.value == pytest.approx(value, rel=0.1)
    assert diagnosis.calibrated[FRICTION].value == pytest.approx(0.2, rel=0.05)


@pytest.mark.parametrize("seed", range(6))
def test_where_nothing_is_hidden_nothing_is_named(seed: int) -> None:
    diagnosis = diagnose(*rig(seed, {FRICTION: 0.23}), Toy)
    assert (diagnosis.verdict, diagnosis.effects) == ("nothing missing", [])


@pytest.mark.parametrize("guess", [0.05, 0.0500001, 0.149, 0.4])
def test_calibration_leaves_the_guess_wherever_it_is(guess: float) -> None:
    diagnosis = in_range(0.3, guess, 0.05, 0.4)
    assert diagnosis.verdict == "nothing missing"
    assert diagnosis.calibrated[FRICTION].value == pytest.approx(0.3, abs=2e-3)


@pytest.mark.parametrize("low", [0.01, 0.0, -1.0])
def test_in_a_range_of_decades_a_value_far_from_the_ends_stands_at_none(low: float) -> None:
    diagnosis = in_range(0.3, 0.15, low, 100.0)
    value = diagnosis.calibrated[FRICTION]
    assert value.value == pytest.approx(0.3, abs=2e-3)
    assert value.determined
    assert not value.at_end
    assert "stands at an end" not in diagnosis.sentence


@pytest.mark.parametrize("high", [3e4, 1e30])
def test_a_range_of_decades_turns_no_verdict(high: float) -> None:
    narrow, wide = (in_range(0.2, 0.15, 0.05, end, seed=1) for end in (0.4, high))
    assert narrow.verdict == wide.verdict == "nothing missing"
    values = [diagnosis.calibrated[FRICTION].value for diagnosis in (narrow, wide)]
    assert values[1] == pytest.approx(values[0], rel=1e-6)


def test_an_uncertain_value_at_the_end_of_its_range_is_warned_of() -> None:
    diagnosis = in_range(0.5, 0.15, 0.05, 0.4)
    assert not diagnosis.calibrated[FRICTION].determined
    assert "sheath.friction stands at an end of its range, 0.05 … 0.4" in diagnosis.sentence


def test_an_effect_that_only_the_held_out_data_show_is_not_nothing() -> None:
    train, _ = rig(1, {})
    _, held_out = rig(1, EFFECTS["constant_friction"])
    diagnosis = diagnose(train, held_out, Toy)
    assert diagnosis.verdict == "unknown"
    assert "On held-out data the calibrated model is off by" in diagnosis.sentence


def test_unknown_names_are_refused_with_the_nearest() -> None:
    train, held_out = rig(1, {})
    with refusing(UnknownNameError, "backlsh", "'backlash'"):
        diagnose(train, held_out, Toy, exclude=["backlsh"])
    uncertain = {"sheath.fricton": Uncertain(0.1, 0.0, 0.4)}
    with refusing(UnknownNameError, "sheath.fricton", "'sheath.friction'"):
        diagnose([replace(r, uncertain=uncertain) for r in train], (), Toy)


def test_a_probe_without_a_trace_for_a_slide_is_enlarged() -> None:
    random = np.random.default_rng(0)
    time = np.arange(0.0, 2.0, 0.02)
    made = []
    for k, rate in enumerate((1.0, 1.7, 1.1)):
        place = 1e-3 * np.sin(2.0 * np.pi * rate * time)
        blank = bench_recording(f"r{k}", time, place, NOISE, list(COLUMNS))
        made.append(measured_by(Simulator, blank, {"environment.stiffness": 1.2e4}, random))
    diagnosis = diagnose(made[:2], made[2:], exclude=[e for e in CATALOGUE if e not in JOINTS])
    assert diagnosis.effects == ["joint_stiffness"]
    assert diagnosis.parameters["environment.stiffness"].value == pytest.approx(1.2e4, rel=0.01)


@pytest.mark.parametrize("width", [2e-4, 1e-3])
def test_play_of_a_stiff_cable_is_named_before_a_delay_or_a_lag(width: float) -> None:
    random, stiff = np.random.default_rng(0), {"sheath.axial_stiffness": 3e4}
    time = np.arange(0.0, 1.5, 0.01)
    made = []
    for k, rate in enumerate((1.0, 1.6)):
        place = 3e-3 * np.sin(2.0 * np.pi * rate * time)
        blank = bench_recording(f"r{k}", time, place, NOISE, list(COLUMNS))
        truth = {**stiff, "sheath.backlash": width}
        made.append(measured_by(Simulator, replace(blank, known=stiff), truth, random))
    few = [CATALOGUE[name] for name in ("backlash", "command_delay", "sensor_lag")]
    diagnosis = diagnose(made[:1], made[1:], catalogue=few)
    assert (diagnosis.verdict, diagnosis.effects) == ("named", ["backlash"])
    assert diagnosis.parameters["sheath.backlash"].value == pytest.approx(width, rel=0.02)


def test_two_effects_are_both_named() -> None:
    truth = {"sheath.constant_friction": 1.0, "sheath.friction_drift": 0.06}
    diagnosis = diagnose(*rig(3, truth), Toy)
    assert set(diagnosis.effects) == {"constant_friction", "friction_drift"}


def test_an_error_that_nothing_in_the_catalogue_explains_is_unknown() -> None:
    diagnosis = diagnose(*rig(4, {}, extra=0.4), Toy)
    assert (diagnosis.verdict, diagnosis.effects) == ("unknown", [])


@pytest.mark.parametrize("extra", [0.0, 1.0])
def test_an_excluded_effect_is_not_named_and_stated_as_such(extra: float) -> None:
    diagnosis = diagnose(*rig(1, EFFECTS["friction_drift"], extra), Toy, exclude="friction_drift")
    assert diagnosis.verdict == "unknown"
    assert "friction_drift" not in (*diagnosis.effects, *diagnosis.closest)
    assert (
        "Nothing was found in the catalogue, without friction_drift, that explains"
        in diagnosis.sentence
    )
    assert diagnosis.result()["excluded"] == ["friction_drift"]


def test_without_a_hold_out_the_tails_prove_it() -> None:
    train, _ = rig(6, EFFECTS["constant_friction"])
    diagnosis = diagnose(train, (), Toy)
    assert diagnosis.effects == ["constant_friction"]
    assert diagnosis.held_out.reducible_closed > 0.9


def test_the_tail_that_proves_is_not_looked_at() -> None:
    train, _ = rig(6, {})
    columns = dict(train[0].columns)
    tail = train[0].time > 0.8 * train[0].time[-1]
    columns["output_tension_N"] = columns["output_tension_N"] + 5.0 * tail
    diagnosis = diagnose([replace(train[0], columns=columns), *train[1:]], (), Toy)
    assert diagnosis.held_out.before > 10.0
    assert diagnosis.located.sentence.endswith("nothing stands out.")


def test_the_result_is_plain() -> None:
    diagnosis = diagnose(*rig(1, EFFECTS["constant_friction"]), Toy)
    result = diagnosis.result()
    assert (result["verdict"], result["effects"]) == ("named", ["constant_friction"])
    entry = result["parameters"]["sheath.constant_friction"]
    assert entry["low"] < entry["value"] < entry["high"]
    for regime in {place["regime"] for place in result["where"]["regimes"]}:
        shares = [p for p in result["where"]["regimes"] if p["regime"] == regime]
        assert sum(p["excess"] for p in shares) == pytest.approx(1.0)
        assert sum(p["time"] for p in shares) == pytest.approx(1.0)


def test_the_error_of_lumping_is_not_missing_however_little_the_noise() -> None:
    noise, strange = 1e-3, 0.01  # N; the signals' range is 12 N
    made = [recording(f"r{k}", k, {FRICTION: 0.2}, strange, noise) for k in range(4)]
    diagnosis = diagnose(made[:2], made[2:], Toy)
    assert diagnosis.held_out.before > 5.0
    assert diagnosis.verdict == "nothing missing"
    assert "put down to the simulation itself" in diagnosis.sentence


def test_an_uncertain_number_without_a_trace_in_the_data_stays_where_it_was() -> None:
    stated = {"output_tension.offset": Uncertain(0.1, -1.0, 1.0)}
    made = [
        replace(r, measured={COLUMN: r.measured[COLUMN]}, uncertain=stated)
        for r in (recording("a", 1, {}), recording("b", 2, {}))
    ]
    diagnosis = diagnose(made[:1], made[1:], Toy)
    assert diagnosis.verdict == "nothing missing"
    value = diagnosis.calibrated["output_tension.offset"]
    assert (value.value, value.low, value.high) == (pytest.approx(0.1), -1.0, 1.0)
    assert not value.determined


def test_bins_of_a_regime_are_the_same_in_every_recording_and_have_units() -> None:
    small = recording("small", 1, {})
    columns = {c: 3.0 * v if c.endswith("_m") else v for c, v in small.columns.items()}
    of_small, of_large = regimes([small, replace(small, name="large", columns=columns)])
    assert [(r.name, r.labels) for r in of_small] == [(r.name, r.labels) for r in of_large]
    inner, outer = (next(r for r in rows if r.name == "posture") for rows in (of_small, of_large))
    assert outer.labels[0].endswith(" mm")
    assert inner.bins.min() > 0
    assert inner.bins.max() < 5
    assert (outer.bins.min(), outer.bins.max()) == (0, 5)


def test_noise_on_the_drive_turns_no_motion_around() -> None:
    clean = recording("clean", 1, {})
    place = clean.columns["input_displacement_m"]
    jitter = 2e-5 * np.random.default_rng(3).standard_normal(place.size)
    noisy = replace(clean, columns={**clean.columns, "input_displacement_m": place + jitter})
    of_clean, of_noisy = ({r.name: r for r in regimes([made])[0]} for made in (clean, noisy))
    for name, least in (("direction", 0.9), ("distance since reversal", 0.8)):
        agree = of_clean[name].bins == of_noisy[name].bins
        assert agree.mean() > least, name
