"""Changes over time: planted ones are found where they are, and nothing where nothing changed."""

from dataclasses import replace
from datetime import datetime, timedelta

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tendon_mj.lab.fleet.changes import daily_deviations, find_change, suspects, templates
from tendon_mj.lab.fleet.observation import Number, NumberSeries, Observation, explanation, one_out
from tendon_mj.lab.fleet.result import (
    larger_misfits,
    odd_day,
    remaining,
    rig_differences,
    spread_between,
)

DAYS = 10
DATES = [datetime(2026, 3, 1) + timedelta(days=k) for k in range(DAYS)]
NUMBERS = tuple(
    Number(f"e.{name}", name if k > 1 else "", "-", 0.1) for k, name in enumerate("abcd")
)
DAILY = 0.3  # probes, from day to day


def rig(seed, planted=None, first=5, change=0.0, course="step"):
    """What a linear rig says whose first two numbers are fitted to all recordings."""
    rng = np.random.default_rng(seed)
    shapes = np.random.default_rng(0).normal(size=(200, len(NUMBERS)))
    residuals = []
    for k in range(DAYS):
        share = float(k >= first)
        if course == "ramp":
            share = min(max((k - first + 1) / (DAYS - first), 0.0), 1.0)
        numbers = rng.normal(0.0, DAILY, len(NUMBERS))
        if planted is not None:
            numbers[planted] += share * change
        residuals.append(-shapes @ numbers + rng.normal(size=200))
    shared = 2
    jacobian, rows = shapes[:, :shared], np.array(residuals)
    fit = np.linalg.lstsq(np.tile(jacobian, (DAYS, 1)), rows.ravel(), rcond=None)[0]
    rows = rows - jacobian @ fit
    return Observation(
        numbers=NUMBERS,
        shared=shared,
        terms=np.zeros(shared),
        values=np.zeros(shared),
        errors=np.zeros(shared),
        square=(rows**2).mean(axis=1),
        samples=np.full(DAYS, 200.0),
        normal=np.array([shapes.T @ shapes] * DAYS),
        gradient=rows @ shapes,
    )


FLEET = [rig(100 + k) for k in range(20)]


@settings(max_examples=40)
@given(
    planted=st.integers(0, len(NUMBERS) - 1),
    first=st.integers(2, DAYS - 2),
    sign=st.sampled_from([-1.0, 1.0]),
    seed=st.integers(0, 1000),
)
def test_a_planted_step_is_found_in_its_number_within_a_day(planted, first, sign, seed):
    changed = rig(seed, planted, first, sign * 12.0 * DAILY)
    spreads = daily_deviations([*FLEET, changed])
    best, *_ = suspects(changed, DATES, spreads)
    assert best.index == planted
    assert abs(best.template.first - first) <= 1  # a step near the end looks like a ramp
    assert best.change == pytest.approx(sign * 12.0 * DAILY, abs=4.0 * DAILY)


@settings(max_examples=60)
@given(seed=st.integers(2000, 10**6))
def test_what_differs_from_day_to_day_is_no_change(seed):
    same = rig(seed)
    assert not suspects(same, DATES, daily_deviations([*FLEET, same]))


def test_reproducibility_is_that_of_the_days_whatever_a_few_rigs_do():
    wild = [rig(500 + k, 0, 5, 100.0) for k in range(4)]
    for number, spread in daily_deviations([*FLEET, *wild]).items():
        assert spread == pytest.approx(0.1 * DAILY, rel=0.5), number


def test_few_recordings_have_no_template():
    assert not templates(DATES[:3])
    assert {t.course for t in templates(DATES[:4])} == {"step"}
    for template in templates(DATES):
        assert template.weights[template.first - 1] == 0.0 < template.weights[template.first]
        assert template.weights.max() == 1.0


@pytest.mark.parametrize("course", ["step", "ramp"])
@pytest.mark.parametrize("first", [2, 4, 6])
def test_a_series_says_since_when_and_how(course, first):
    shares = np.array([float(k >= first) for k in range(DAYS)])
    if course == "ramp":
        shares = np.clip((np.arange(DAYS) - first + 1) / (DAYS - first), 0.0, 1.0)
    values = 3.0 + 2.0 * shares + 0.02 * np.random.default_rng(1).normal(size=DAYS)
    found = find_change(DATES, values, np.full(DAYS, 0.02))
    assert found.course == course
    assert found.since == DATES[first]
    assert found.last_same == DATES[first - 1]
    assert [found.before, found.after] == pytest.approx([3.0, 5.0], abs=0.06)
    assert found.significance > 30.0


@pytest.mark.parametrize("odd", range(DAYS))
def test_one_odd_day_is_no_change(odd):
    values = np.ones(DAYS)
    values[odd] = 9.0
    assert find_change(DATES, values, np.full(DAYS, 0.1)).significance < 5.0


def test_a_change_whose_direction_one_day_decides_is_none():
    values = np.where(np.arange(DAYS) >= DAYS - 2, -0.55, 0.0)
    values[-2] = 2.0
    assert find_change(DATES, values, np.full(DAYS, 0.1)).significance == 0.0


def test_a_change_on_every_day_is_as_significant_as_its_standard_error_says():
    values = np.where(np.arange(DAYS) >= DAYS // 2, 1.0, 0.0)
    found = find_change(DATES, values, np.full(DAYS, 0.2))
    assert found.error == pytest.approx(0.2 * np.sqrt(4 / DAYS))
    assert found.significance == pytest.approx(1.0 / found.error)


def test_a_planted_change_that_is_undone_is_found():
    same = rig(7)
    shapes = np.random.default_rng(0).normal(size=(200, len(NUMBERS)))
    moved = np.where([4 <= k < 6 for k in range(DAYS)], 10.0 * DAILY, 0.0)
    gradient = same.gradient - moved[:, None] * (shapes.T @ shapes[:, 2])
    best, *_ = suspects(replace(same, gradient=gradient), DATES, daily_deviations(FLEET))
    assert best.index == 2
    assert np.flatnonzero(best.template.weights).tolist() == [4, 5]


@pytest.mark.parametrize("third", [0.15, 0.20, 0.10])
@pytest.mark.parametrize(("first", "back"), [(2, 6), (4, 6), (2, 8), (5, 8)])
def test_a_rig_that_was_repaired_has_the_values_that_it_had(first, back, third):
    days = np.arange(DAYS)
    values = np.where(days < first, 0.15, np.where(days < back, 0.25, third))
    values = values + 0.002 * np.random.default_rng(1).normal(size=DAYS)
    found = find_change(DATES, values, np.full(DAYS, 0.002))
    assert found.course == "there and back"
    assert [found.last_same, found.since] == [DATES[first - 1], DATES[first]]
    assert found.until == DATES[back - 1]
    told = [found.before, found.between, found.after]
    assert told == pytest.approx([0.15, 0.25, third], abs=0.006)
    assert found.significance > 20.0


def test_a_number_of_many_values_has_no_single_change():
    values = 0.1 * np.array([1.0, 1.0, 3.0, 1.5, 4.0, 2.0, 3.0, 5.0, 2.5, 4.0])
    found = find_change(DATES, values, np.full(DAYS, 0.002))
    assert found.course == "varying"
    assert [found.before, found.after] == [values[0], values[-1]]
    assert found.significance > 5.0


@pytest.mark.parametrize("odd", [0, 3, 5, 6, 9])
def test_one_odd_day_does_not_hide_a_step_nor_move_its_values(odd):
    values = np.where(np.arange(DAYS) >= 5, 0.25, 0.15)
    values[odd] = 0.6
    found = find_change(DATES, values, np.full(DAYS, 0.002))
    assert found.course == "step"
    assert found.apart == DATES[odd]
    assert [found.before, found.after] == pytest.approx([0.15, 0.25])


def test_a_growth_that_is_not_straight_is_a_growth():
    days = np.arange(DAYS) - 2.0
    values = np.where(days > 0.0, (np.maximum(days, 0.0) / 7.0) ** 1.3, 0.0)
    found = find_change(DATES, values, np.full(DAYS, 0.001))
    assert found.course == "ramp"
    assert found.apart is None


def test_a_number_is_told_within_its_range():
    values = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.3, 0.8, 1.2, 1.7, 2.1])
    free = find_change(DATES, values, np.full(DAYS, 0.05))
    assert free.before < 0.0
    told = find_change(DATES, values, np.full(DAYS, 0.05), (0.0, 2.0))
    assert free.after > 2.0
    assert told == replace(free, before=0.0, after=2.0)


def test_a_rig_differs_where_the_others_do_not():
    rng = np.random.default_rng(2)
    values = {f"rig_{k}": 5.0 + 0.2 * rng.normal() for k in range(30)} | {"odd": 7.0}
    errors = dict.fromkeys(values, 0.01)
    spread = spread_between(values, errors)
    assert spread.median == pytest.approx(5.0, abs=0.1)
    assert spread.between == pytest.approx(0.2, rel=0.4)
    assert set(rig_differences("e.a", values, errors, spread)) == {"odd"}
    few = {name: values[name] for name in ("rig_0", "rig_1", "odd")}
    assert not rig_differences("e.a", few, errors, spread_between(few, errors))


def test_a_rig_differs_whichever_recording_is_left_out_or_does_not():
    rng = np.random.default_rng(2)
    values = {f"rig_{k}": 5.0 + 0.2 * rng.normal() for k in range(30)}
    values |= {"odd day": 7.0, "turns": 7.0, "other": 7.0}
    errors = dict.fromkeys(values, 0.01)
    without = {"odd day": [7.1, 7.1, 5.1], "turns": [7.1, 3.0], "other": [7.1, 7.1, 6.9]}
    spread = spread_between(values, errors)
    assert set(rig_differences("e.a", values, errors, spread, without)) == {"other"}
    misfits = {f"rig_{k}": 1.1 + 0.01 * k for k in range(20)} | {"odd day": 6.0, "other": 6.0}
    without = {"odd day": [6.3, 1.2, 6.2], "other": [6.1, 5.8, 5.9]}
    assert set(larger_misfits(misfits, without)) == {"other"}


def test_a_rig_without_a_recording_is_what_a_fit_without_it_says():
    rng = np.random.default_rng(4)
    slopes, rows = rng.normal(size=(DAYS, 50, 2)), rng.normal(size=(DAYS, 50))
    rows[6] += slopes[6] @ [30.0, 0.0]  # an odd day
    fitted = np.linalg.lstsq(slopes.reshape(-1, 2), -rows.ravel(), rcond=None)[0]
    left = rows + slopes @ fitted
    observation = Observation(
        numbers=NUMBERS[:2],
        shared=2,
        terms=0.1 * fitted,
        values=0.1 * fitted,
        errors=np.zeros(2),
        square=(left**2).mean(axis=1),
        samples=np.full(DAYS, 50.0),
        normal=np.einsum("kmi,kmj->kij", slopes, slopes),
        gradient=np.einsum("kmi,km->ki", slopes, left),
    )
    values, misfits = one_out(observation)
    for k in range(DAYS):
        rest = np.arange(DAYS) != k
        own = np.linalg.lstsq(slopes[rest].reshape(-1, 2), -rows[rest].ravel(), rcond=None)[0]
        assert values[k] == pytest.approx(0.1 * own)  # a probe is 0.1
        residual = rows[rest] + slopes[rest] @ own
        assert misfits[k] == pytest.approx(np.sqrt(np.mean(residual**2)))
    assert np.abs(values[6]).max() < 0.05 < np.abs(values[:6, 0]).min()


def series(name, identifier, square):
    square = np.array(square)
    return NumberSeries(
        number=Number(name, identifier, "-", 0.1),
        parameter=name,
        unit="-",
        probe=0.1,
        values=np.ones(square.size),
        errors=np.ones(square.size),
        apart=np.ones(square.size),
        errors_apart=np.ones(square.size),
        square=square,
        range=np.array([0.0, 2.0]),
        others={},
    )


def test_of_explanations_alike_the_uncertain_parameter_is_named():
    bend = series("sheath.drawn_bend", "bend_angle", [1.0, 1.2, 0.9])
    friction = series("sheath.friction", "", [1.0 + 1e-6, 1.2 + 1e-6, 0.9 + 1e-6])
    first, rivals = explanation([bend, friction])
    assert first is friction
    assert rivals == [bend]


def test_what_leaves_notably_more_in_every_recording_is_no_rival():
    play = series("sheath.backlash", "backlash", [1.0, 1.2, 0.9])
    friction = series("sheath.friction", "", [1.5, 1.8, 1.4])
    assert explanation([play, friction]) == (play, [])


def test_what_leaves_more_in_one_recording_alone_is_a_rival():
    play = series("sheath.backlash", "backlash", [1.0, 1.0, 1.0, 1.0])
    creep = series("sheath.creep", "creep", [0.9, 1.0, 1.0, 2.0])
    assert explanation([play, creep]) == (play, [creep])


AFTER = np.arange(DAYS) >= 5
SIGNS = (-1.0) ** np.arange(DAYS)
RAMP = np.clip((np.arange(DAYS) - 2.0) / 7.0, 0.0, 1.0)


def found_in(normal, gradient, shared=0):
    """Suspects among numbers of a standard deviation of 1, by (days, w, w) A and (days, w) b."""
    numbers = tuple(Number(f"e.{k}", f"{k}", "-", 1.0) for k in range(gradient.shape[1]))
    nothing, ones = np.zeros(shared), np.ones(DAYS)
    made = Observation(numbers, shared, nothing, nothing, nothing, ones, ones, normal, gradient)
    return suspects(made, DATES, {number.label: 1.0 for number in numbers})


def stepping(*sizes):
    """Suspects among numbers that step by so many standard errors."""
    gradient = -np.outer(AFTER, sizes) / np.sqrt(DAYS / 4.0)
    return found_in(np.tile(np.eye(len(sizes)), (DAYS, 1, 1)), gradient)


def parallel_but_for(share):
    """Suspects where what a number explains is that of a fitted one but for a share of it."""
    alike = np.sqrt(1.0 - share)
    normal = AFTER[:, None, None] * np.array([[1.0, alike], [alike, 1.0]])
    return found_in(normal, -1e-3 * np.outer(AFTER, [0.0, 1.0]), shared=1)


def course(values, deviation=1.0):
    return find_change(DATES, values, np.full(DAYS, deviation)).course


def left_by_a_step():
    """Sum of squares that the best step leaves of a ramp."""
    steps = [np.column_stack([np.ones(DAYS), np.arange(DAYS) >= k]) for k in range(2, DAYS - 1)]
    return min(float(np.linalg.lstsq(step, RAMP, rcond=None)[1][0]) for step in steps)


EDGES = {
    "a change": (stepping, 4.0, 6.0),
    "near the best": (lambda share: len(stepping(9.0, 9.0 * share**0.5)) == 2, 0.5, 0.7),
    "numbers": (lambda count: len(stepping(*[9.0] * count)) < count, 6, 7),
    "a direction of its own": (parallel_but_for, 0.7e-10, 1.4e-10),
    "a ramp": (lambda less: course(RAMP, (left_by_a_step() / less) ** 0.5) == "ramp", 7.0, 11.0),
    "scatter": (lambda rms: course(rms * SIGNS) == "varying", 2.7, 3.9),
    "a curve": (lambda rms: course(AFTER + rms * SIGNS, 1e-3) == "varying", 0.12, 0.2),
    "explains less": (
        lambda more: not explanation([series("a", "", [1.0] * 3), series("b", "", [more] * 3)])[1],
        1.007,
        1.013,
    ),
    "few recordings": (lambda n: odd_day(DATES[:n], [64.0, *[1.0] * (n - 1)], 1.1), 2, 3),
    "an odd day": (lambda s: odd_day(DATES, [9.0 * s / (1.0 - s), *[1.0] * 9], 0.1), 0.4, 0.6),
    "what remains": (lambda times: remaining(times, 1.0), 1.7, 2.4),
}


@pytest.mark.parametrize("what", EDGES)
def test_it_counts_from_a_threshold_on(what):
    counts, within, beyond = EDGES[what]
    assert not counts(within)
    assert counts(beyond)
