"""Selection of effects: one law for each of its steps, on a rig that is linear."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from tendon_mj.lab.diagnosis import Selection, Term
from tendon_mj.lab.diagnosis.proof import without_undetermined
from tendon_mj.lab.diagnosis.search import descend
from tendon_mj.lab.diagnosis.selection import CONVERGED, eliminate_backward, select_effects
from tendon_mj.lab.diagnosis.statistics import SelectedEffect
from tendon_mj.lab.recordings import Recording
from tendon_mj.typing import FloatArray
from tests.lab.diagnosis.linear_rig import (
    BLOCKS,
    LinearRig,
    Shape,
    context,
    effect,
    named,
    select,
    selected,
)

A, B, C = (effect(name) for name in "abc")
W = effect("w")


def imitator(a: float, b: float, different: float) -> dict[str, Shape]:
    """Shapes of two effects, and of a third that nearly is their sum."""
    return {"a": {"a": 1.0}, "b": {"b": 1.0}, "c": {"a": a, "b": b, "d": different}}


def alone(power: float) -> set[str]:
    """Selection where a single effect takes that much off the reduced χ²."""
    return selected({"w": {"w": 1.0}}, {"w": np.sqrt(power)}, [W])


def test_the_calibrated_model_leaves_exactly_what_it_lacks() -> None:
    selection = select(context(imitator(1.0, 1.0, 0.1), {"a": 5.0, "b": 3.0}, []))
    assert selection.calibrated.excess == pytest.approx(34.0)
    assert selection.effects == ()


def test_an_early_choice_that_imitates_two_effects_is_swapped() -> None:
    """{c} leaves 2; {c, a} leaves 0.13, where nothing more is added; {a, b} leaves 0."""
    shapes, truth = imitator(1.0, 1.0, 0.12), {"a": 5.0, "b": 3.0}
    selection = select(context(shapes, truth, [A, B, C]))
    assert selection.first is not None
    assert selection.first.fitted[0].candidate == C
    assert {e.candidate for e in selection.effects} == {A, B}
    assert selection.final.excess == pytest.approx(0.0, abs=1e-3)


def test_the_second_best_choice_is_tried_where_the_best_leads_nowhere() -> None:
    """{c} leaves 1.5, to which neither a nor b alone adds anything; {a}, then {a, b} leaves 0."""
    shapes, truth = imitator(1.2, 0.8, 0.25), {"a": 6.0, "b": 4.0}
    assert selected(shapes, truth, [A, B, C]) == {"a", "b"}
    assert selected(shapes, truth, [A, C]) == {"c"}  # where it does not lead to the end either


def test_the_second_best_choice_is_tried_in_the_second_round_too() -> None:
    """{w}, then {w, c}, which leaves 1.5 as above; {w, a}, then {w, a, b} leaves 0."""
    shapes = {**imitator(1.2, 0.8, 0.25), "w": {"w": 1.0}}
    truth = {"a": 6.0, "b": 4.0, "w": 10.0}
    assert selected(shapes, truth, [A, B, C, W]) == {"a", "b", "w"}


def test_the_same_effect_at_another_place_is_fitted_from_the_values_of_the_chosen() -> None:
    """Where it leaves less from there, it is taken; another effect is not tried."""
    rig = context({"a": {"a": 1.0}, "b": {"a": 0.6, "b": 0.8}}, {"a": 3.0, "b": 4.0}, [])
    near, far = (replace(e, effect=A.effect, where=e.identifier) for e in (A, B))
    chosen, stopped = (
        rig.fit_model([e], [0.5], e, evaluations=n) for e, n in ((near, CONVERGED), (far, 0))
    )
    moved = rig.at_other_places(chosen, [chosen, stopped])
    assert moved.candidate == far
    assert moved.fit.values == pytest.approx([5.0])
    assert moved.excess == pytest.approx(0.0, abs=1e-6)
    other = rig.fit_model([B], [0.5], B, evaluations=0)
    assert rig.at_other_places(chosen, [chosen, other]) is chosen


class Rough(LinearRig):
    """A rig of which each response goes up and down on its way, as where friction sticks."""

    height, frequency = 0.5, 20.0

    def _one(self, changed: Mapping[str, float], recording: Recording) -> dict[str, FloatArray]:
        rough = {
            name: value + self.height * np.sin(self.frequency * value)
            for name, value in changed.items()
        }
        return super()._one(rough, recording)


class Rougher(Rough):
    height = 1.0


class Finer(Rough):
    height, frequency = 0.3, 60.0


@pytest.mark.parametrize(("make", "start"), [(Rough, 0.2), (Rougher, 0.2), (Finer, 1.0)])
def test_a_fit_that_roughness_stopped_descends_by_slopes_over_a_distance(
    make: type[Rough], start: float
) -> None:
    shapes = {"a": {"a": 1.0}, "b": {"b": 1.0}}
    rig = context(shapes, {"a": 5.0, "b": 3.0}, [])
    rig = replace(rig, problem=replace(rig.problem, simulate=make(rig.problem.recordings, shapes)))
    stopped = rig.fit_model([A, B], [start, start], B, evaluations=CONVERGED)
    assert stopped.excess > 1.0
    assert rig.optimise(stopped).excess < 0.01


class Turning(LinearRig):
    """A rig of which the responses to b and w are others where a acts."""

    def _one(self, changed: Mapping[str, float], recording: Recording) -> dict[str, FloatArray]:
        if changed.get("a", 0.0) < 1.0:
            changed = {**changed, "b": -changed.get("b", 0.0)}
        else:
            changed = {**changed, "w": 0.1 * changed.get("w", 0.0)}
        return super()._one(changed, recording)


@pytest.mark.parametrize("calibrated", [W.terms, ()])
def test_slopes_are_not_taken_from_a_model_that_responded_otherwise(
    calibrated: tuple[Term, ...],
) -> None:
    """Without a, only a negative b would explain anything, which no b in its range is."""
    shapes = {name: {name: 1.0} for name in "abw"}
    rig = context(shapes, {"a": 5.0, "b": 3.0}, [])
    problem = replace(rig.problem, simulate=Turning(rig.problem.recordings, shapes))
    positive = replace(B, terms=(replace(B.terms[0], low=0.0),))
    rig = replace(rig, problem=problem, candidates=(A, positive), calibrated=calibrated)
    start = rig.fit_model((), [0.5] * len(calibrated), evaluations=CONVERGED)
    chosen = select_effects(replace(rig, initial_excess=start.excess), start)
    assert {e.candidate for e in chosen.effects} == {A, positive}


def test_what_leaves_no_trace_is_tried_at_the_first_model_only() -> None:
    shapes = {"a": {"a": 1.0}, "b": {"b": 1.0}, "c": {"c": 1.0}, "w": {}}
    rig = context(shapes, {"a": 5.0, "b": 3.0}, [A, B, W])
    tried = []

    class Counting(LinearRig):
        def _one(self, changed: Mapping[str, float], recording: Recording) -> dict[str, FloatArray]:
            tried.append("w" in changed)
            return super()._one(changed, recording)

    problem = replace(rig.problem, simulate=Counting(rig.problem.recordings, shapes))
    rig = replace(rig, problem=problem, calibrated=C.terms)
    start = rig.fit_model((), (0.5,), evaluations=CONVERGED)
    rig.extend(start)
    tries = sum(tried)
    assert tries > 0
    chosen = select_effects(replace(rig, initial_excess=start.excess), start)
    assert {e.candidate for e in chosen.effects} == {A, B}
    assert rig.slopes_at(chosen.final, [W]) == {}
    assert sum(tried) == tries


def test_fits_respond_alike_where_terms_of_both_do() -> None:
    rig = context({name: {name: 1.0} for name in "abc"}, {"a": 5.0, "b": 3.0}, [])
    one, both, other = (rig.fit_model(e, [1.0] * len(e)).fit for e in ([A], [A, B], [C]))
    assert one.responds_like(both)
    assert both.responds_like(one)
    assert not one.responds_like(other)


def test_a_fit_of_a_linear_response_is_not_searched_further() -> None:
    rig = context({"a": {"a": 1.0}, "w": {"w": 1.0}}, {"a": 5.0, "w": 5.0}, [])
    ended = rig.fit_model([A], [1.0], A, evaluations=CONVERGED)
    assert descend(rig.problem, rig.base, ended.fit) is None


@pytest.mark.parametrize(("unknown", "tried"), [(1.95, True), (2.15, False)])
def test_the_second_best_choice_is_tried_where_less_than_a_tenth_remains(
    unknown: float, tried: bool
) -> None:
    """As above, beside an unknown error: {c} leaves 9.5 % of 55.8, or 10.8 % of 56.6."""
    truth = {"a": 6.0, "b": 4.0, "w": unknown}
    result = selected(imitator(1.2, 0.8, 0.25), truth, [A, B, C])
    assert result == ({"a", "b"} if tried else {"c"})


class Curved(LinearRig):
    """A rig to which a adds its shape times a |a/5|^0.3: a probe shows little of it."""

    def _one(self, changed: Mapping[str, float], recording: Recording) -> dict[str, FloatArray]:
        a = changed.get("a", 0.0)
        return super()._one({**changed, "a": a * abs(a / 5.0) ** 0.3}, recording)


def test_an_effect_of_which_screening_sees_little_is_fitted_if_no_first_one_explains_all() -> None:
    """By screening a explains a quarter of what c does, which leaves 1.5; fitted, a leaves 0."""
    shapes: dict[str, Shape] = {"a": {"a": 1.0}, "c": {"a": 1.0, "d": 0.25}}
    given = context(shapes, {"a": 5.0}, [A, C])
    rig = Curved(given.problem.recordings, shapes)
    selection = select(replace(given, problem=replace(given.problem, simulate=rig)))
    assert selection.first is not None
    of_c, of_a = selection.first.scores
    assert (of_c.candidate, of_a.candidate) == (C, A)
    assert of_a.explained < 0.3 * of_c.explained
    assert [e.candidate for e in selection.effects] == [A]


def test_an_effect_that_others_made_idle_is_eliminated() -> None:
    """{c}, then {c, a}, then {c, a, b}, in which c does nothing."""
    shapes, truth = imitator(1.0, 1.0, 0.3), {"a": 5.0, "b": 3.0}
    assert selected(shapes, truth, [A, B, C]) == {"a", "b"}


def test_a_tie_goes_to_a_wrong_parameter_before_a_missing_effect() -> None:
    """The parameter leaves 0.008 more than the effect."""
    shapes = {"a": {"a": 1.0}, "b": {"a": 1.0, "b": 0.03}}
    parameter = effect("b", "parameter")
    assert selected(shapes, {"a": 3.0}, [A, parameter]) == {"b"}
    shapes["b"] = {"a": 1.0, "b": 0.1}  # 0.09 more is no tie
    assert selected(shapes, {"a": 3.0}, [A, parameter]) == {"a"}


def test_a_tie_goes_to_fewer_terms() -> None:
    """The second term of b takes 0.008 off."""
    shapes = {"a": {"a": 1.0}, "b": {"a": 1.0}, "d": {"d": 1.0}}
    long = effect("b", shape="d")
    assert selected(shapes, {"a": 3.0, "d": 0.09}, [long, A]) == {"a"}
    assert selected(shapes, {"a": 3.0, "d": 0.5}, [long, A]) == {"b"}


@pytest.mark.parametrize(("opposed", "added"), [(6, False), (4, False), (2, True)])
def test_a_gain_that_may_be_chance_is_not_added(opposed: int, added: bool) -> None:
    """Of 20 blocks some have the opposite sign: gains of 0.4, 1.1 and 2.3 standard errors."""
    present = np.ones(2 * BLOCKS)
    present[:: 2 * BLOCKS // opposed][:opposed] = -1.0
    present[np.flatnonzero(present < 0.0)[opposed:]] = 1.0
    assert (selected({"w": {"w": 1.0}}, {"w": 3.0}, [W], present) == {"w"}) == added


def test_what_is_below_the_detection_limit_is_not_named() -> None:
    assert alone(0.15) == set()
    assert alone(0.3) == {"w"}


def test_an_effect_that_closes_less_than_a_sixtieth_of_the_error_is_not_added() -> None:
    """Beside an unknown error of 20 noise rms it takes 0.3 to be worth a name, or 0.013 rms."""
    shapes = {"w": {"w": 1.0}}
    assert selected(shapes, {"w": np.sqrt(0.5), "a": 20.0}, [W]) == set()
    assert selected(shapes, {"w": np.sqrt(0.5), "a": 1.0}, [W]) == {"w"}


def test_a_strength_at_the_end_of_its_range_is_not_selected() -> None:
    """Held at 4.9, a would leave 0.01; b leaves 0.25."""
    shapes = {"a": {"a": 1.0}, "b": {"a": 1.0, "b": 0.1}}
    assert selected(shapes, {"a": 5.0}, [A, B]) == {"a"}
    assert selected(shapes, {"a": 5.0}, [effect("a", most=4.9), B]) == {"b"}


def test_an_effect_that_ended_at_an_end_is_taken_out_beside_another() -> None:
    """Of 5 a and 3 b, b is held at 1; without it a leaves 9, and a alone stays."""
    selection_context = context(imitator(1.0, 1.0, 0.1), {"a": 5.0, "b": 3.0}, [])
    held = effect("b", most=1.0)
    calibrated = selection_context.fit_model((), ())
    final = selection_context.fit_model((A, held), (4.0, 0.5), evaluations=CONVERGED)
    both = tuple(SelectedEffect(e, (), 1.0) for e in (A, held))
    selection = Selection(calibrated, final, both, None)
    assert not final.fit.determines(held)
    fewer = without_undetermined(selection_context, selection)
    assert fewer.effects == both[:1]
    assert fewer.final.excess == pytest.approx(9.0)
    alone = replace(selection, effects=both[1:])
    assert without_undetermined(selection_context, alone) is alone


def test_at_most_three_effects_are_selected_the_largest_first() -> None:
    shapes = {name: {name: 1.0} for name in "abcd"}
    truth = {"a": 4.0, "b": 3.0, "c": 2.0, "d": 1.0}
    selection = select(context(shapes, truth, [effect(name) for name in "dcba"]))
    assert [e.candidate.identifier for e in selection.effects] == ["a", "b", "c"]
    assert selection.final.excess == pytest.approx(1.0, abs=0.01)


def test_a_simpler_effect_that_ties_but_is_not_worth_adding_hides_no_other() -> None:
    """The effect gains 0.207, the parameter that ties with it 0.196, and 0.2 is the limit."""
    shapes = {"a": {"a": 1.0}, "b": {"a": 1.0, "d": 0.25}}
    parameter = effect("b", "parameter")
    (chosen,) = select(context(shapes, {"a": 0.457}, [A, parameter])).effects
    assert chosen.candidate == A
    assert chosen.rivals == (parameter,)


def test_a_promising_fit_that_was_stopped_on_its_way_is_continued_before_selection_ends() -> None:
    """With no more than its start, a leaves 9 of 25; b explains nothing."""
    given = context({"a": {"a": 1.0}, "b": {"b": 1.0}}, {"a": 5.0}, [A, B])
    model = given.fit_model((), ())
    stopped = given.fit_model((A,), (2.0,), A, evaluations=1)
    useless = given.fit_model((B,), (0.0,), B, evaluations=1)
    assert stopped.excess > 8.0
    first, second = given.converged(model, [stopped, useless])
    assert first.excess == pytest.approx(0.0, abs=1e-3)
    assert second is useless


def test_what_an_elimination_leaves_is_a_fit_to_convergence() -> None:
    """Without b a fit that was stopped on its way leaves 0.01, and a = 5 leaves nothing."""
    given = context({"a": {"a": 1.0}, "b": {"b": 1.0}}, {"a": 5.0}, [A, B])
    model = given.fit_model((A, B), (5.0, 0.0), B, evaluations=CONVERGED)
    stopped = given.fit_model((A,), (4.9,), A, evaluations=1)
    given.reduced[model.fit, B] = stopped
    left = eliminate_backward(given, model)
    assert left.fit.effects == (A,)
    assert left.fit.values == pytest.approx([5.0], abs=1e-3)


def test_a_parameter_of_the_model_is_no_further_candidate() -> None:
    """Held at 0.05, a leaves 25, which the same with a wider range would explain."""
    narrow, wide = effect("a", most=0.05), replace(A, where="another")
    given = context({"a": {"a": 1.0}, "b": {"b": 1.0}}, {"a": 5.0, "b": 2.0}, [wide, B])
    result = given.extend(given.fit_model((narrow,), (0.04,)))
    assert [score.candidate for score in result.scores] == [B]


def test_a_second_best_choice_that_leads_to_less_is_not_kept() -> None:
    """{c} leaves 1.5, {again}, which writes c too and so excludes it, leaves 4."""
    shapes = {"c": {"a": 1.2, "b": 0.8, "d": 0.25}, "a": {"a": 1.2}}
    term = replace(C.terms[0], targets=("a", "c"))
    again = replace(C, effect=named("again"), terms=(term,))
    selection = select(context(shapes, {"a": 6.0, "b": 4.0}, [C, again]))
    assert selection.first is not None
    assert [m.candidate for m in selection.first.fitted] == [C, again]
    assert [e.candidate for e in selection.effects] == [C]


def test_an_effect_is_not_swapped_for_one_that_only_ties() -> None:
    """Alone c is worse than a, and beside b as good: a rival, though it is simpler."""
    shapes = {"a": {"a": 1.0}, "b": {"b": 1.0}, "c": {"a": 1.0, "b": -0.1, "d": 0.02}}
    wrong = effect("c", "parameter")
    selection = select(context(shapes, {"a": 5.0, "b": 3.0}, [A, B, wrong]))
    assert {e.candidate: e.rivals for e in selection.effects} == {A: (wrong,), B: ()}


def test_one_effect_on_many_elements_leaves_fits_for_others() -> None:
    """Five elements that explain the same, and another effect that explains nearly as much."""
    names = [f"a{k}" for k in range(5)]
    shapes: dict[str, Shape] = {name: {"a": 1.0} for name in names}
    shapes["b"] = {"a": 1.0, "b": 0.3}
    candidates = [replace(effect(n, where=n), effect=named("a")) for n in names] + [B]
    extended = context(shapes, {"a": 3.0}, candidates)
    result = extended.extend(extended.fit_model((), ()))
    assert sorted(m.candidate.identifier for m in result.fitted if m.candidate) == ["a"] * 3 + ["b"]
    assert len(result.scores) == 6


def test_two_effects_that_explain_the_same_are_rivals() -> None:
    shapes: dict[str, Shape] = {"a": {"a": 1.0}, "b": {"a": 1.0, "b": 0.01}, "c": {"c": 1.0}}
    (only,) = select(context(shapes, {"a": 3.0}, [A, B, C])).effects
    assert only.candidate == A
    assert only.rivals == (B,)
    assert only.confidence == pytest.approx(0.5, abs=0.02)
