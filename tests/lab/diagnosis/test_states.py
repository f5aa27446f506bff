"""Rigs in several states: what is known differs, and something was set anew for each recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pytest

from tendon_mj.errors import InvalidValueError, RecordingError, UnknownNameError
from tendon_mj.lab.diagnosis import (
    CATALOGUE,
    Diagnosis,
    Fit,
    Problem,
    Term,
    diagnose,
    fit,
    session_terms,
    uncertain_terms,
)
from tendon_mj.lab.diagnosis.data import by_recording
from tendon_mj.lab.diagnosis.effects.binding import (
    ParameterSpecification,
    on_sheaths,
    written_parameters,
)
from tendon_mj.lab.diagnosis.reproducibility import bar, reproducibility
from tendon_mj.lab.diagnosis.statistics import cross_validate
from tendon_mj.lab.parameter_names import name_in_session, recording_of, values_for
from tendon_mj.lab.recordings import Measured, Recording, Session, Uncertain
from tendon_mj.lab.replay import Parameter, Simulates
from tendon_mj.typing import FloatArray
from tests.lab.diagnosis.toy import problem_of, system
from tests.lab.recorded import recorded
from tests.refusals import refusing

COLUMN, NOISE = "tension_N", 0.05
EFFECTS = ("backlash", "constant_friction", "stiffening")
BENDS = (0.0, 1.0, 2.0, 3.0)


class Rig(Simulates):
    """Tension = (μ bend + Σ effects × shape) and a zero that is set anew for each recording."""

    sessions = True

    def __init__(self, recordings: Sequence[Recording]) -> None:
        self.recordings = list(recordings)
        self.parameters = {
            "sheath.friction": Parameter(0.2, "-", "joint"),
            "sheath.bend": Parameter(1.0, "rad", "joint"),
            "gauge.offset": Parameter(0.0, "N", "sensor"),
        } | {f"sheath.{name}": Parameter(0.0, "-", "joint") for name in EFFECTS}

    def __call__(self, sets: Sequence[Mapping[str, float]]) -> list[list[dict[str, FloatArray]]]:
        """Series for every set and recording; a value for another recording is a mistake."""
        known = {"", *(recording.name for recording in self.recordings)}
        assert {recording_of(name) for values in sets for name in values} <= known
        return [[{COLUMN: self._tension(values, r)} for r in self.recordings] for values in sets]

    def _tension(self, values: Mapping[str, float], recording: Recording) -> FloatArray:
        known = {**recording.known, **{n: s.value for n, s in recording.session.items()}}
        told = {n: p.value for n, p in self.parameters.items()} | known
        told |= values_for(recording.name, values)
        time, x = recording.time, recording.columns["reel_m"]
        tension = told["gauge.offset"] + told["sheath.friction"] * told["sheath.bend"] * 20.0 * x
        for k, name in enumerate(EFFECTS, 2):
            tension = tension + told[f"sheath.{name}"] * np.sin(2.0 * np.pi * 0.31 * k * time + k)
        return tension


CANDIDATES = [
    replace(
        CATALOGUE[name],
        binding=on_sheaths(ParameterSpecification(name, "-", -100.0, 100.0, 0.1)),
        non_smooth=False,
        changes="",
    )
    for name in EFFECTS
]


def record(
    name: str,
    bend: float,
    zero: float,
    truth: Mapping[str, float],
    strange: float = 0.0,
    seed: int = 0,
) -> Recording:
    """Six seconds in one state; ``strange`` is the amplitude of what no effect explains [N]."""
    time = np.arange(0.0, 6.0, 0.01)
    x = np.sin(2.0 * np.pi * 0.4 * time)
    blank = recorded(
        time,
        {"reel_m": ("reel", x)},
        {COLUMN: ("gauge", NOISE)},
        name=name,
        known={"sheath.bend": bend},
        uncertain={"sheath.friction": Uncertain(0.2, 0.05, 0.8)},
        session={"gauge.offset": Session(0.0, 0.3)},
    )
    random = np.random.default_rng([seed, round(10.0 * bend), len(name)])
    own = {**truth, "gauge.offset": zero}
    clean = Rig([blank])([own])[0][0][COLUMN]
    odd = strange * np.sin(2.0 * np.pi * 3.7 * time)
    series = clean + odd + random.normal(0.0, NOISE, time.size)
    return replace(blank, columns={**blank.columns, COLUMN: series})


ZEROS = (0.4, -0.3, 0.1, -0.5)
TRUTH = {"sheath.friction": 0.3, "sheath.backlash": 1.5}


def recordings(strange: float = 0.0, count: int = 4) -> list[Recording]:
    """One recording in each of several states."""
    states = list(zip(BENDS, ZEROS, strict=True))[:count]
    return [record(f"bend {k}", *state, TRUTH, strange) for k, state in enumerate(states)]


def errors_after(result: Diagnosis) -> list[float]:
    """Rms error of the final model in each simulated recording [N]."""
    rows = [(row.after.columns[COLUMN], row.measured.columns[COLUMN]) for row in result.simulate()]
    return [float(np.sqrt(np.mean((after - measured) ** 2))) for after, measured in rows]


def test_an_effect_is_found_across_states_and_what_was_set_anew_beside_it() -> None:
    result = diagnose(recordings(), simulator=Rig, catalogue=CANDIDATES)
    assert (result.verdict, result.effects) == ("named", ["backlash"])
    assert result.leaves_one_out
    assert result.parameters["sheath.backlash"].value == pytest.approx(1.5, abs=0.02)
    assert result.calibrated["sheath.friction"].value == pytest.approx(0.3, abs=0.01)
    spread = result.sessions["gauge.offset"]
    assert spread.values == pytest.approx(
        {f"bend {k}": zero for k, zero in enumerate(ZEROS)}, abs=0.02
    )
    assert spread.estimated == pytest.approx(float(np.sqrt(np.mean(np.square(ZEROS)))), abs=0.02)
    assert result.held_out.after == pytest.approx(1.0, abs=0.1)
    assert max(errors_after(result)) < 1.1 * NOISE


def test_held_out_recordings_are_given_zeros_of_their_own() -> None:
    given = recordings()
    result = diagnose(given[:3], given[3:], Rig, catalogue=CANDIDATES)
    assert result.verdict == "named"
    assert result.held_out.after == pytest.approx(1.0, abs=0.1)
    own = result.model[name_in_session("gauge.offset", "bend 3")]
    assert own == pytest.approx(ZEROS[3], abs=0.03)
    (error,) = errors_after(result)
    assert error < 1.1 * NOISE


def test_what_remains_beside_an_effect_is_said_and_the_effect_is_named() -> None:
    result = diagnose(recordings(strange=0.5), simulator=Rig, catalogue=CANDIDATES)
    assert (result.verdict, result.effects) == ("partly", ["backlash"])
    assert result.parameters["sheath.backlash"].value == pytest.approx(1.5, abs=0.1)
    assert "Nothing was found in the catalogue that explains what remains" in result.sentence


def test_where_nothing_explains_the_error_the_closest_is_not_proven() -> None:
    result = diagnose(
        [record(f"bend {k}", b, 0.0, {"sheath.backlash": 0.3}, 3.0) for k, b in enumerate(BENDS)],
        simulator=Rig,
        catalogue=CANDIDATES,
    )
    assert result.verdict == "unknown"
    assert not result.proven
    assert result.effects == []


def test_recordings_count_as_states_where_what_is_known_or_set_anew_differs() -> None:
    three = recordings(count=3)
    assert by_recording(three)
    assert not by_recording(three[:2])
    alike = [replace(r, known={"sheath.bend": 1.0}, session={}) for r in three]
    assert not by_recording(alike)
    assert by_recording([replace(alike[0], known={"sheath.bend": 2.0}), *alike[1:]])
    assert by_recording([replace(r, session=three[0].session) for r in alike])


def sessions_fit(seed: int) -> tuple[Problem, Fit, FloatArray]:
    """Problem of three states; the exact fit of noise by random columns; their matrix."""
    made = recordings(count=3)
    data = problem_of(Rig, made)
    random = np.random.default_rng(seed)
    size = data.blocks.size
    jacobian = np.zeros((size, 4))
    jacobian[:, 0] = random.normal(size=size)
    for k in range(3):
        rows = data.recording_of == k
        jacobian[rows, k + 1] = random.normal(size=int(rows.sum()))
    shared = Term(("sheath.friction",), "-", 0.0, -50.0, 50.0, 1.0)
    own = [
        Term((name_in_session("gauge.offset", r.name),), "N", 0.0, -50.0, 50.0, 1.0, spread=20.0)
        for r in made
    ]
    weights = np.diag([0.0, 0.05, 0.05, 0.05])
    noise = random.normal(size=size)
    solution = _solve(jacobian, noise, weights)
    bounds = np.array([[-50.0] * 4, [50.0] * 4])
    left = noise + jacobian @ solution
    terms = (shared, *own)
    fitted = Fit(terms, (), solution, left, np.zeros(size), jacobian, solution, bounds)
    return data, fitted, noise


def _solve(jacobian: FloatArray, noise: FloatArray, weights: FloatArray) -> FloatArray:
    rows = np.vstack([jacobian, weights])
    return np.linalg.lstsq(rows, -np.append(noise, np.zeros(len(weights))), rcond=None)[0]


def test_leaving_out_a_recording_is_a_refit_to_the_others_and_of_its_own_zero_to_it() -> None:
    data, fitted, noise = sessions_fit(1)
    result = cross_validate(data, fitted)
    assert len(result.chi2) == 3
    weights = np.diag([0.0, 0.05, 0.05, 0.05])
    for k in range(3):
        inside = data.recording_of == k
        others = [0, *(j + 1 for j in range(3) if j != k)]
        refit = np.zeros(4)
        refit[others] = _solve(
            fitted.jacobian[~inside][:, others], noise[~inside], weights[np.ix_(others, others)]
        )
        rest = noise[inside] + fitted.jacobian[inside][:, others] @ refit[others]
        own = fitted.jacobian[inside][:, [k + 1]]
        refit[k + 1] = _solve(own, rest, weights[np.ix_([k + 1], [k + 1])])[0]
        left = rest + own[:, 0] * refit[k + 1]
        assert result.chi2[k] == pytest.approx(float(left @ left), rel=1e-6)


def test_a_recordings_own_zero_is_fitted_to_it_by_the_values_of_another_fit_to_the_others() -> None:
    data, fitted, noise = sessions_fit(1)
    weights, inside = np.diag([0.0, 0.05, 0.05, 0.05]), data.recording_of == 1
    steep = fitted.jacobian.copy()
    steep[inside, 0] *= 1e3

    def refit(part: int) -> Fit:
        others = data.without(part).in_train
        solution = _solve(fitted.jacobian * others[:, None], noise * others, weights)
        return replace(fitted, scaled=solution, residual=noise + fitted.jacobian @ solution)

    refitted = cross_validate(data, replace(fitted, jacobian=steep), refit)
    assert refitted.chi2[1] == pytest.approx(cross_validate(data, fitted).chi2[1], rel=1e-6)


def test_an_expected_spread_holds_what_the_data_do_not_tell() -> None:
    """Of y = p + noise with n samples and p ~ N(0, s²) the best p is ȳ n s²/(n s² + σ²)."""
    made = [replace(recordings(count=1)[0], measured={COLUMN: Measured("gauge", 10.0)})]
    data = problem_of(Rig, made)
    name = name_in_session("gauge.offset", made[0].name)
    free = Term((name,), "N", 0.0, -9.0, 9.0, 0.1)
    got = [
        fit(data, {}, (term,), (), np.zeros(1), evaluations=20).values[0]
        for term in (free, replace(free, spread=0.4))
    ]
    n = data.blocks.size
    assert got[1] == pytest.approx(got[0] * n * 0.4**2 / (n * 0.4**2 + 10.0**2), rel=1e-3)


def test_reproducibility_is_that_of_repeats_and_none_where_no_state_was_repeated() -> None:
    zeros = (0.4, -0.4)
    repeats = [replace(record("first", 1.0, zero, TRUTH), name=f"z {zero}") for zero in zeros]
    data = problem_of(Rig, [*repeats, record("another state", 2.0, 0.0, TRUTH)])
    result = reproducibility(data, data.residuals([TRUTH])[0])
    assert result[COLUMN] == pytest.approx(0.8 / np.sqrt(2.0), rel=0.02)
    assert bar(data, result) == pytest.approx(np.hypot(1.0, result[COLUMN] / NOISE))
    alone = recordings(count=3)
    data = problem_of(Rig, alone)
    assert reproducibility(data, data.residuals([{}])[0]) == {COLUMN: 0.0}
    assert bar(data, {COLUMN: 0.0}) == pytest.approx(1.0)


@pytest.mark.parametrize("strange", [0.0, 2.0])
def test_neither_what_is_fitted_to_each_session_nor_an_error_of_all_is_scatter(
    strange: float,
) -> None:
    zeros = {"first": 0.4, "second": -0.4}
    repeats = [
        record(name, 1.0, zero, TRUTH, strange, seed=k)
        for k, (name, zero) in enumerate(zeros.items())
    ]
    data = problem_of(Rig, repeats)
    fitted = {name_in_session("gauge.offset", name): zero for name, zero in zeros.items()}
    result = reproducibility(data, data.residuals([{**TRUTH, **fitted}])[0])
    assert result == {COLUMN: 0.0}
    assert (bar(data, result) == 1.0).all()


def test_what_cannot_be_set_for_each_recording_is_refused() -> None:
    class Deaf(Rig):
        sessions = False

    with refusing(InvalidValueError, "'Deaf'", "'bend 0'"):
        diagnose(recordings(), simulator=Deaf, catalogue=CANDIDATES)
    twins = [replace(r, name="bend") for r in recordings()]
    with refusing(RecordingError, "'bend'", "two recordings"):
        diagnose(twins, simulator=Rig, catalogue=CANDIDATES)


def test_an_effect_that_changes_friction_is_no_candidate_without_any() -> None:
    changing = [effect for effect in CATALOGUE.values() if effect.changes]
    assert {effect.changes for effect in changing} == {"friction"}
    for effect in changing:
        names = written_parameters(effect.binding) | {"friction"}
        values = {f"s.{name}": 0.0 for name in names}
        candidate = effect.bind(system(values))[0]
        assert not candidate.acts_on({"s.friction": 0.0})
        assert candidate.acts_on({"s.friction": 0.1})


@pytest.mark.parametrize("reverse", [False, True])
def test_a_plain_name_goes_before_one_with_wildcards_in_any_order(reverse: bool) -> None:
    told = {"sheath.friction": Uncertain(0.2, 0.1, 0.4), "sheath.f*": Uncertain(0.15, 0.1, 0.18)}
    told = dict(reversed(told.items())) if reverse else told
    given = [replace(r, session={}, uncertain=told) for r in recordings()]
    problem = problem_of(Rig, given)
    (term,) = uncertain_terms(problem)
    assert (term.targets, term.high) == (("sheath.friction",), 0.4)


def test_two_names_that_speak_of_one_parameter_alike_are_refused() -> None:
    wide = Uncertain(0.2, 0.1, 0.4)
    for tables in (
        {"uncertain": {"sheath.f*": wide, "*.friction": wide}, "known": {}},
        {"uncertain": {"sheath.f*": wide}, "known": {"*.friction": 0.2}},
    ):
        given = [replace(r, session={}, **tables) for r in recordings()]  # type: ignore[arg-type]
        problem = problem_of(Rig, given)
        with refusing(InvalidValueError, "'sheath.friction' is meant by"):
            uncertain_terms(problem)


def test_what_was_set_anew_has_to_be_a_parameter() -> None:
    given = [replace(r, session={"nope.offset": Session(0.0, 1.0)}) for r in recordings()]
    with refusing(UnknownNameError, "nope.offset", "[session]"):
        session_terms(given, Rig(given))
