"""Where effects may sit on a model."""

from __future__ import annotations

import pickle
from dataclasses import replace
from typing import Any

import pytest

from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.lab.diagnosis import (
    CATALOGUE,
    Effect,
    ParameterSpecification,
    SystemDescription,
    candidates,
    on_gravity,
    on_inputs,
    on_joints,
    on_sensors,
    on_sheaths,
    together,
)
from tendon_mj.lab.diagnosis.effects.binding import on_frictionless_sheaths
from tendon_mj.lab.diagnosis.effects.effect import Binding
from tests.lab.diagnosis.toy import refused


def system(
    values: dict[str, float],
    known: frozenset[str] = frozenset(),
    spans: dict[str, float] | None = None,
    inputs: tuple[str, ...] = (),
    free_joints: tuple[str, ...] = (),
) -> SystemDescription:
    return SystemDescription(values, known, frozenset(), spans or {}, inputs, free_joints)


def effect(binding: Binding, **more: object) -> Effect:
    return Effect("slack", "a slack", "x + s", "a lag", "a test", binding, **more)  # type: ignore[arg-type]


def on(*sheaths: str, known: frozenset[str] = frozenset()) -> list[str]:
    """Elements of every candidate for dry friction that the tension does not change."""
    rig = system({f"{sheath}.constant_friction": 0.0 for sheath in sheaths}, known)
    return [c.where for c in candidates(rig) if c.identifier == "constant_friction"]


def test_an_effect_of_the_sheath_is_on_all_of_them_or_on_one() -> None:
    assert on("left") == ["left"]
    assert on("left", "right") == ["left, right", "left", "right"]


def test_what_is_known_of_one_sheath_leaves_the_others() -> None:
    known = frozenset({"left.constant_friction"})
    assert on("left", "right", known=known) == ["right"]


def test_what_is_known_of_the_rig_is_overridden_only_where_the_effect_says_so() -> None:
    rig = system({"a.slack": 0.0}, frozenset({"a.slack"}))
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
    assert len(on_frictionless_sheaths(specification)(rig)) == count


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
    with refused(InvalidValueError, "slack", value):
        replace(SLACK, **change)


def test_an_effect_has_a_name_and_one_of_two_kinds() -> None:
    with refused(UnknownNameError, "'mising'", "'missing'"):
        effect(on_joints(SLACK), kind="mising")
    with refused(InvalidValueError, "'a slack'", "identifier"):
        replace(effect(on_joints(SLACK)), identifier=" ")


def test_every_effect_of_the_catalogue_can_be_sent_to_a_process() -> None:
    rig = system({"a.backlash": 0.0, "a.friction": 0.1})
    sent = pickle.loads(pickle.dumps(CATALOGUE))
    assert sent.keys() == CATALOGUE.keys()
    assert candidates(rig, catalogue=sent) == candidates(rig)
