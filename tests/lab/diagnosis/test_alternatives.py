"""Numbers that an effect of the catalogue may take over: their intervals, verdict and words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from tendon_mj.lab.diagnosis import CATALOGUE, Diagnosis, diagnose
from tendon_mj.lab.recordings import Recording, Uncertain
from tendon_mj.lab.replay import Parameter
from tendon_mj.typing import FloatArray
from tests.lab.diagnosis.toy import Added, measured_by
from tests.lab.recorded import recorded

FRICTION, PLAY = "sheath.friction", "sheath.backlash"
CONSTANT = "sheath.constant_friction"
ANGLE, TENSION = "joint_rad", "input_tension_N"
NOISE = {ANGLE: 0.002, TENSION: 0.05}
TRUE_FRICTION, TRUE_PLAY = 0.10, 4e-4


class Rig(Added):
    """A rig of which friction and play turn the joint alike, but for a share ``unlike``."""

    unlike = 0.005
    turns = 250.0  # friction that turns the joint as a play of 1 m does

    def __init__(self, recordings: Sequence[Recording]) -> None:
        super().__init__(recordings, {FRICTION: 0.15, PLAY: 0.0})

    def waveform(self, parameter: str, column: str, recording: Recording) -> FloatArray:
        place = recording.columns["input_displacement_m"] / 1e-3
        if column == TENSION:
            return 40.0 * np.sin(place) * (parameter == FRICTION)
        turn = np.sin(place) + self.unlike * np.sin(3.0 * place) * (parameter == PLAY)
        return turn * (1.0 if parameter == FRICTION else self.turns)


class Distinct(Rig):
    """A rig of which an angle shows friction and play apart."""

    unlike = 0.5


class Slight(Rig):
    """A rig that a play exactly as friction turns, and hardly: all 5 mm by 0.03 of it."""

    unlike, turns = 0.0, 6.0


class Less(Rig):
    """A rig that a play exactly as friction turns: all 5 mm by a seventh of it."""

    unlike, turns = 0.0, 3.0


class Least(Rig):
    """The same, by a thirtieth."""

    unlike, turns = 0.0, 0.7


class Twice(Rig):
    """A rig that constant friction turns as play does."""

    def __init__(self, recordings: Sequence[Recording]) -> None:
        super().__init__(recordings)
        self.parameters |= {CONSTANT: Parameter(0.0, "N", "live")}

    def waveform(self, parameter: str, column: str, recording: Recording) -> FloatArray:
        if parameter == CONSTANT:
            return 1e-3 * super().waveform(PLAY, column, recording)
        return super().waveform(parameter, column, recording)


def diagnosed(
    make: type[Rig] = Rig, play: float = TRUE_PLAY, columns: Sequence[str] = (ANGLE,)
) -> Diagnosis:
    random, made = np.random.default_rng(3), []
    for k in range(4):
        time = np.arange(0.0, 6.0, 0.01)
        place = 1e-3 * np.sin(2.0 * np.pi * (0.3 + 0.05 * k) * time + k)
        blank = recorded(
            time,
            {"input_displacement_m": ("reel", place)},
            {c: (c.rpartition("_")[0], NOISE[c]) for c in columns},
            name=f"r{k}",
            uncertain={FRICTION: Uncertain(0.15, 0.03, 0.4)},
        )
        truth = {FRICTION: TRUE_FRICTION, PLAY: play}
        made.append(measured_by(make, blank, truth, random))
    return diagnose(made[:3], made[3:], make)


def test_a_number_that_an_effect_too_alike_to_name_took_over_is_not_told() -> None:
    result = diagnosed()
    friction = result.calibrated[FRICTION]
    assert friction.value == pytest.approx(TRUE_FRICTION + 250.0 * TRUE_PLAY, rel=0.02)
    assert friction.low < TRUE_FRICTION < friction.high
    assert (result.verdict, result.effects) == ("undetermined", [])
    assert [alternative.identifier for alternative in result.alternatives] == ["backlash"]
    assert result.confidence == 0.5
    assert f"cannot tell {FRICTION} = 0.2" in result.sentence
    assert "load cell" in result.sentence


def test_of_effects_that_widen_an_interval_alike_one_is_stated() -> None:
    result = diagnosed(Twice)
    friction = result.calibrated[FRICTION]
    assert friction.low < TRUE_FRICTION < friction.high
    assert len(result.alternatives) == 1


def test_a_measured_force_tells_it() -> None:
    result = diagnosed(columns=(ANGLE, TENSION))
    assert (result.verdict, result.effects) == ("named", ["backlash"])
    assert result.alternatives == ()
    assert result.calibrated[FRICTION].low > 0.95 * TRUE_FRICTION
    assert result.calibrated[FRICTION].high < 1.05 * TRUE_FRICTION


def test_a_number_of_an_effect_in_whose_place_another_explains_as_much_may_be_as_before() -> None:
    result = diagnosed(Twice, columns=(ANGLE, TENSION))
    assert result.verdict == "named"
    (found,) = result.findings
    assert len(found.rivals) == 1
    number = result.parameters[found.parameter]
    assert number.low == number.before == 0.0 < number.high
    assert f"cannot tell {found.parameter} = " in result.sentence
    assert result.calibrated[FRICTION].high < 1.05 * TRUE_FRICTION


def test_an_effect_unlike_a_number_leaves_its_interval() -> None:
    result = diagnosed(Distinct, play=0.0)
    assert (result.verdict, result.alternatives) == ("nothing missing", ())
    friction = result.calibrated[FRICTION]
    assert friction.low < TRUE_FRICTION < friction.high
    assert friction.high - friction.low < 0.01 * TRUE_FRICTION


def test_an_effect_takes_over_no_more_than_its_range_asks_for() -> None:
    friction = diagnosed(Slight, play=0.0).calibrated[FRICTION]
    assert TRUE_FRICTION - friction.low == pytest.approx(0.03, abs=0.002)


class Unmoved(Rig):
    """A rig of which an angle shows hardly anything of its friction, and of its play nothing."""

    def waveform(self, parameter: str, column: str, recording: Recording) -> FloatArray:
        return 1e-4 * super().waveform(parameter, column, recording) * (parameter == FRICTION)


def test_an_effect_that_moves_a_number_by_less_widens_its_interval_and_is_not_told() -> None:
    result = diagnosed(Less, play=0.0)
    friction = result.calibrated[FRICTION]
    assert TRUE_FRICTION - friction.low == pytest.approx(0.015, abs=0.002)
    assert (result.verdict, result.alternatives) == ("nothing missing", ())
    assert "cannot tell" not in result.sentence
    assert diagnosed(Least, play=0.0).calibrated[FRICTION].low > 0.99 * TRUE_FRICTION


def test_a_number_of_which_the_data_tell_nothing_is_said_to_be_untold() -> None:
    result = diagnosed(Unmoved)
    friction = result.calibrated[FRICTION]
    assert (friction.low, friction.high) == (0.03, 0.4)
    assert (result.verdict, result.effects) == ("undetermined", [])
    assert f"cannot tell {FRICTION} = " in result.sentence
    assert "load cell" in result.sentence


def test_an_effect_that_was_excluded_takes_nothing_over() -> None:
    result = diagnosed()
    alone = diagnose(
        list(result.recordings), list(result.held_out_recordings), Rig, exclude=["backlash"]
    )
    assert (alone.verdict, alone.alternatives) == ("nothing missing", ())
    assert alone.calibrated[FRICTION].low > TRUE_FRICTION


class TwoDrums(Added):
    """A rig of two sheaths, of which the plays of both drums turn the joint alike."""

    def __init__(self, recordings: Sequence[Recording]) -> None:
        plays = {"one.backlash": 0.0, "two.backlash": 0.0}
        super().__init__(recordings, {"one.friction": 0.15, "two.friction": 0.15, **plays})

    def waveform(self, parameter: str, column: str, recording: Recording) -> FloatArray:
        place = recording.columns["input_displacement_m"] / 1e-3
        if parameter.endswith("friction"):
            return np.sin(place)
        return 250.0 * np.sign(np.cos(place)) * np.abs(np.sin(place))


def test_an_alternative_may_have_a_part_of_a_finding_only() -> None:
    random, made = np.random.default_rng(3), []
    for k in range(4):
        time = np.arange(0.0, 6.0, 0.01)
        place = 1e-3 * np.sin(2.0 * np.pi * (0.3 + 0.05 * k) * time + k)
        columns = {"input_displacement_m": ("reel", place)}
        blank = recorded(time, columns, {ANGLE: ("joint", NOISE[ANGLE])}, name=f"r{k}")
        truth = {"one.backlash": TRUE_PLAY, "two.backlash": TRUE_PLAY}
        made.append(measured_by(TwoDrums, blank, truth, random))
    play = [CATALOGUE["backlash"]]
    result = diagnose(made[:3], made[3:], TwoDrums, catalogue=play)
    both = [result.parameters[f"{sheath}.backlash"].value for sheath in ("one", "two")]
    assert sum(both) == pytest.approx(2.0 * TRUE_PLAY, rel=0.05)


class TwoFrictions(Added):
    """A rig of two sheaths, whose frictions and one play turn the joint each in its way."""

    alike = 1.0  # share of the play that is as the friction of its sheath

    def __init__(self, recordings: Sequence[Recording]) -> None:
        values = {"one.friction": 0.15, "two.friction": 0.15, "one.backlash": 0.0}
        super().__init__(recordings, values)

    def waveform(self, parameter: str, column: str, recording: Recording) -> FloatArray:
        place = recording.columns["input_displacement_m"] / 1e-3
        if parameter == "two.friction":
            return np.cos(2.0 * place)
        first = np.sin(3.0 * place)
        if parameter == "one.friction":
            return first
        return 250.0 * (self.alike * first + (1.0 - self.alike) * np.sin(5.0 * place))


class TwoFrictionsApart(TwoFrictions):
    """The same, where the play turns the joint as no friction does."""

    alike = 0.0


@pytest.mark.parametrize(
    ("make", "truth", "verdict"),
    [
        (TwoFrictions, {"one.friction": 0.2, "two.friction": 0.1}, "undetermined"),
        (TwoFrictions, {"one.friction": 0.15, "one.backlash": TRUE_PLAY}, "undetermined"),
        (TwoFrictionsApart, {"one.friction": 0.15, "one.backlash": TRUE_PLAY}, "named"),
    ],
)
def test_an_effect_on_one_sheath_is_not_named_where_its_own_number_explains_as_much(
    make: type[TwoFrictions], truth: dict[str, float], verdict: str
) -> None:
    random, made = np.random.default_rng(3), []
    shared = {"*.friction": Uncertain(0.15, 0.03, 0.4)}
    for k in range(4):
        time = np.arange(0.0, 6.0, 0.01)
        place = 1e-3 * np.sin(2.0 * np.pi * (0.3 + 0.05 * k) * time + k)
        columns = {"input_displacement_m": ("reel", place)}
        measured = {ANGLE: ("joint", NOISE[ANGLE])}
        blank = recorded(time, columns, measured, name=f"r{k}", uncertain=shared)
        made.append(measured_by(make, blank, truth, random))
    result = diagnose(made[:3], made[3:], make, catalogue=[CATALOGUE["backlash"]])
    assert (result.verdict, result.effects) == (verdict, ["backlash"])
    friction = result.calibrated["one.friction"]
    for value in (0.15, truth["one.friction"]) if verdict == "undetermined" else (0.15,):
        assert friction.low <= value <= friction.high
    value = result.calibrated["one.friction"].value
    words = f"cannot tell one.friction = {value:.3g} SI from {value + 0.1:.3g} SI with friction of"
    undecided = "Found, and not decided: missing: play between drive and tendon (one)"
    for told in (words, "on each of one and two. To decide, write each = true", undecided):
        assert (told in result.sentence) == (verdict == "undetermined")
    assert result.confidence == pytest.approx(0.5 if verdict == "undetermined" else 1.0, abs=0.05)
