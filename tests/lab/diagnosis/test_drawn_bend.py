"""A wrong bend of the drawn path is found where what each recording adds to it is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tendon_mj.lab.diagnosis import (
    CATALOGUE,
    Candidate,
    ParameterSpecification,
    Problem,
    SystemDescription,
    all_samples,
    describe_system,
    diagnose,
)
from tendon_mj.lab.diagnosis.wording import state_finding
from tendon_mj.lab.recordings import Measured, Recording, Uncertain
from tendon_mj.lab.replay import Parameter, Simulator

COLUMNS = ("input_tension_N", "output_tension_N")
DRAWN, EXTRA, FRICTION = "sheath.drawn_bend", "sheath.extra_bend", "sheath.friction"
NOISE, TRUE = 0.1, 2.6
EFFECTS = [CATALOGUE[name] for name in ("bend_angle", "friction", "creep")]


def record(extra: float, rate: float, known: dict[str, float]) -> Recording:
    """A second of a bench that bends by less than its model, in one posture."""
    time = np.round(np.arange(0.0, 1.0, 0.01), 6)
    blank = Recording(
        name=f"posture {extra:g} {rate:g}",
        model="bench",
        source="made",
        time=time,
        columns={
            "input_displacement_m": 8e-4 * np.sin(rate * time),
            **dict.fromkeys(COLUMNS, np.zeros(time.size)),
        },
        drive={"input_displacement_m": "reel"},
        measured={c: Measured(c.removesuffix("_N"), NOISE) for c in COLUMNS},
        known={EXTRA: extra, **known},
        uncertain={FRICTION: Uncertain(0.15, 0.05, 0.4)},
    )
    (series,) = Simulator([blank])([{DRAWN: TRUE, FRICTION: 0.2}])[0]
    random = np.random.default_rng(round(100.0 * rate))
    noisy = {c: v + random.normal(0.0, NOISE, time.size) for c, v in series.items()}
    return replace(blank, columns={**blank.columns, **noisy})


def postures(**known: float) -> list[Recording]:
    told = {f"sheath.{name}": value for name, value in known.items()}
    return [record(extra, rate, told) for extra in (0.0, 2.0) for rate in (7.0, 9.0)]


def test_a_wrong_drawn_bend_is_told_from_friction_by_two_known_postures() -> None:
    train, held_out = postures()[::2], postures()[1::2]
    found = diagnose(train, held_out, catalogue=EFFECTS)
    assert (found.verdict, found.effects) == ("parameter", ["bend_angle"])
    value = found.parameters[DRAWN]
    assert value.low <= TRUE <= value.high
    assert value.value == pytest.approx(TRUE, abs=0.05)
    assert found.calibrated[FRICTION].value == pytest.approx(0.2, abs=0.005)
    assert "the bend of sheath is too high: 1" in found.sentence
    assert ", not 180°" in found.sentence


def test_a_drawn_bend_that_is_known_is_not_blamed() -> None:
    given = postures(drawn_bend=np.pi)
    found = diagnose(given[::2], given[1::2], catalogue=EFFECTS)
    assert "bend_angle" not in found.effects
    assert DRAWN not in found.parameters


@pytest.mark.parametrize("extra", [0.0, 2.0])
def test_who_knows_one_bend_of_all_recordings_knows_the_drawn_one(extra: float) -> None:
    given = [recording for recording in postures() if recording.known[EXTRA] == extra]
    problem = Problem(tuple(given), Simulator(given), all_samples(given))
    assert DRAWN in describe_system(problem).known
    both = Problem(tuple(postures()), Simulator(postures()), all_samples(postures()))
    assert DRAWN not in describe_system(both).known


def test_a_fitted_extra_bend_leaves_no_drawn_one_to_find() -> None:
    given = [replace(r, known={}, uncertain={EXTRA: Uncertain(0.0, -1.0, 1.0)}) for r in postures()]
    problem = Problem(tuple(given), Simulator(given), all_samples(given))
    assert DRAWN in describe_system(problem).uncertain


def test_paths_that_bend_differently_are_wrong_by_as_much() -> None:
    values = {"a.drawn_bend": 1.0, "b.drawn_bend": 0.25}
    rig = SystemDescription(values, frozenset(), frozenset(), {}, (), ())
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
    return state_finding(CATALOGUE["bend_angle"], candidate, parameters, before, after)


def test_a_term_that_all_elements_share_does_nothing_at_its_inert_value() -> None:
    values = {"a.creep": 0.0, "b.creep": 0.2, "c.creep": 0.05}
    rig = SystemDescription(values, frozenset(), frozenset(), {}, (), ())
    term = ParameterSpecification("creep", "-", 0.0, 1.0, 0.1).term(("a", "b", "c"), rig)
    assert term is not None
    assert term.write(term.inert, values) == pytest.approx(values)
    for number in (term.low, term.high):
        written = term.write(number, values).values()
        assert min(written) >= 0.0
        assert max(written) <= 1.0 + 1e-12
