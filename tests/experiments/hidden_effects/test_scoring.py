"""Laws of the score: what counts as a hit, a false name, a number rightly called wrong."""

import math

import pytest

from experiments.hidden_effects.statistics import confusion, table
from experiments.hidden_effects.verdicts import JudgedCase
from tendon_mj.lab.diagnosis import CATALOGUE

KEY = {
    "kind": "effect",
    "hidden": ["creep"],
    "target": 5.0,
    "reached": True,
    "parameters": {"sheath.creep": 0.2},
}
RESULT = {
    "verdict": "named",
    "effects": ["creep"],
    "indistinguishable": [],
    "confidence": 0.97,
    "parameters": {"sheath.creep": {"value": 0.21, "low": 0.19, "high": 0.23, "unit": "-"}},
    "gap": {"held_out": {"reducible_closed": 0.98}},
}


NOTHING = {"kind": "nothing", "hidden": []}
PAIR = {"kind": "pair", "hidden": ["creep", "sensor_lag"]}


def judged(key=None, **result):
    return JudgedCase("case", {**KEY, **(key or {})}, {**RESULT, **result}, 1.0)


def figures(*cases):
    return {quantity: figure for quantity, _, figure, _ in table(cases)}


def test_a_hit_counts_one_a_tie_a_half_and_a_wrong_name_nothing():
    assert judged().hit == 1.0
    assert judged(indistinguishable=[["creep", "stiffening"]]).hit == 0.5
    assert judged(effects=["stiffening"]).hit == 0.0
    assert judged(effects=["stiffening", "creep"]).hit == 0.0
    assert judged(effects=["stiffening", "creep"]).contains
    assert judged(verdict="unknown", effects=[]).hit == 0.0


def test_a_false_name_is_one_where_nothing_is_hidden():
    nothing = {"kind": "nothing", "hidden": []}
    assert judged(nothing).named_effect
    assert not judged(nothing, verdict="nothing missing", effects=[]).named_effect
    assert not judged(nothing, verdict="parameter", effects=["friction"]).named_effect


def test_errors_are_relative_and_intervals_cover_or_not():
    [(name, error, covered)] = judged().errors()
    assert (name, covered) == ("sheath.creep", True)
    assert error == pytest.approx(0.05)


def test_a_drawn_bend_counts_as_the_bend_that_the_key_states_beyond_it():
    """The bench is drawn with π rad; keys say what a rig has more."""
    key = {"kind": "parameter", "hidden": ["bend_angle"], "parameters": {"sheath.extra_bend": -0.5}}
    bend = {"value": 2.7, "low": 2.6, "high": 2.8, "unit": "rad"}
    one = judged(
        key, verdict="parameter", effects=["bend_angle"], parameters={"sheath.drawn_bend": bend}
    )
    assert one.right_number
    [(name, error, covered)] = one.errors()
    assert (name, covered) == ("sheath.extra_bend", True)
    assert error == pytest.approx((2.7 - math.pi + 0.5) / 0.5)
    wrong = {"sheath.drawn_bend": {**bend, "low": 2.65}}
    assert not judged(key, verdict="parameter", parameters=wrong).right_number


def test_the_table_and_the_matrix_count_every_case():
    cases = [judged(), judged(effects=["stiffening"]), judged({"kind": "nothing", "hidden": []})]
    rows = {quantity: (figure, count) for quantity, _, figure, count in table(cases)}
    assert rows["one effect, residual ≥ 5 noise: first (tie: half)"] == ("50.0 %", 2)
    assert rows["nothing hidden: false name"] == ("100.0 %", 1)
    _, matrix = confusion(cases)
    assert sum(sum(row.values()) for row in matrix.values()) == len(cases)


def test_a_name_in_part_counts_like_a_name():
    assert judged(verdict="partly").hit == 1.0
    nothing = {"kind": "nothing", "hidden": []}
    assert judged(nothing, verdict="partly").named_effect
    assert judged(verdict="unknown").extra == []


def test_a_number_falsely_called_wrong_is_a_false_name_and_takes_the_lead():
    case = judged(verdict="partly", effects=["friction", "creep"])
    assert (case.hit, case.leads) == (1.0, 0.0)
    assert (case.extra, case.false_names) == ([], ["friction"])
    assert judged(verdict="parameter", effects=["friction"]).false_names == ["friction"]
    assert judged(verdict="partly", effects=["creep", "friction"]).leads == 1.0


TOO_HIGH = {"kind": "too_high", "hidden": ["joint_damping"], "parameters": {"joint.damping": 19.0}}


def damping(low, high, **others):
    return {"joint.damping": {"value": 0.5 * (low + high), "low": low, "high": high}, **others}


def test_a_number_is_rightly_wrong_with_its_element_alone_and_the_truth_in_its_interval():
    def right(verdict="parameter", **parameters):
        result = {"verdict": verdict, "effects": ["joint_damping"], "parameters": parameters}
        return judged(TOO_HIGH, **result).right_number

    assert right(**damping(18.0, 20.0))
    assert not right(**damping(20.0, 21.0))
    assert not right("named", **damping(18.0, 20.0))
    assert not right(**{"other.damping": {"value": 19.0, "low": 18.0, "high": 20.0}})
    assert not right(**damping(18.0, 20.0, **{"joint.armature": {"value": 0, "low": 0, "high": 0}}))


def test_a_number_is_not_rightly_wrong_beside_one_that_is_not():
    effects = ["joint_damping", "friction"]
    case = judged(TOO_HIGH, verdict="parameter", effects=effects, parameters=damping(18.0, 20.0))
    assert case.false_names == ["friction"]
    assert not case.right_number


def test_two_rivals_are_a_tie_and_more_are_named_wrongly():
    tie = judged(effects=["stiffening"], indistinguishable=[["stiffening", "creep", "backlash"]])
    assert (tie.contains, tie.hit, tie.false_names) == (True, 0.5, [])
    group = ["stiffening", "creep", "backlash", "sensor_lag"]
    wide = judged(effects=["stiffening"], indistinguishable=[group])
    assert (wide.contains, wide.hit, wide.ties) == (False, 0.0, [])
    assert wide.false_names == ["stiffening", "backlash", "sensor_lag"]
    assert judged(indistinguishable=[group[:2]]).hit == 0.5
    assert judged(indistinguishable=[group]).false_names == ["stiffening", "backlash", "sensor_lag"]


def test_rivals_of_a_name_count_over_all_groups_and_groups_without_a_name_do_not():
    rivals = ["creep", "backlash", "sensor_lag"]
    pairs = judged(effects=["stiffening"], indistinguishable=[["stiffening", r] for r in rivals])
    assert not pairs.contains
    assert pairs.false_names == ["stiffening", "backlash", "sensor_lag"]
    apart = judged(effects=["stiffening"], indistinguishable=[["creep", "backlash"]])
    assert (apart.contains, apart.false_names) == (False, ["stiffening"])
    assert not judged(verdict="unknown", effects=[], indistinguishable=[["creep"]]).contains


def test_a_verdict_that_lists_everything_contains_nothing():
    for listed in (
        {"effects": list(CATALOGUE)},
        {"effects": ["creep"], "indistinguishable": [list(CATALOGUE)]},
    ):
        found = figures(judged(PAIR, **listed))
        assert found["two effects: both named"] == "0.0 %"
        assert found["two effects: something named that is not there"] == "100.0 %"
    assert not judged(effects=list(CATALOGUE)).contains
    ties = [["creep", "stiffening", "backlash"], ["sensor_delay", "sensor_lag"]]
    found = figures(judged(PAIR, effects=["creep", "sensor_delay"], indistinguishable=ties))
    assert found["two effects: both named"] == "100.0 %"
    assert found["two effects: something named that is not there"] == "0.0 %"


def test_a_number_falsely_called_wrong_is_a_false_name_and_no_abstention():
    wrong = {"verdict": "parameter", "effects": ["friction"], "parameters": {}}
    assert figures(judged(NOTHING, **wrong))["nothing hidden: false name"] == "100.0 %"
    found = figures(judged(**wrong))
    assert found["one effect: something named that is not there"] == "100.0 %"
    assert found["one effect: abstained"] == "0.0 %"
    assert judged({"kind": "outside"}, **wrong).confident
    another = {"kind": "parameter", "hidden": ["pretension"]}
    quantity = "wrong parameter: something named that is not there"
    assert figures(judged(another, **wrong))[quantity] == "100.0 %"
    assert figures(judged({**another, "hidden": ["friction"]}, **wrong))[quantity] == "0.0 %"


def test_a_case_without_a_result_is_right_in_no_figure():
    kinds = ("effect", "pair", "parameter", "outside", "too_high", "session", "remainder")
    hidden = [["creep", "sensor_lag"] if kind == "pair" else ["creep"] for kind in kinds]
    cases = [
        JudgedCase(kind, {**KEY, "kind": kind, "hidden": names}, None, None, missing=True)
        for kind, names in zip(kinds, hidden, strict=True)
    ]
    rows = table([*cases, judged(NOTHING, verdict="nothing missing", effects=[])])
    wanted = {q: figure for q, wanted, figure, count in rows if wanted.startswith("≥") and count}
    assert len(wanted) == 7
    assert set(wanted.values()) == {"0.0 %"}
    found = {quantity: figure for quantity, _, figure, _ in rows}
    assert found["cases without a result, which count as failed"] == "7"
    assert found["failed"] == "87.5 %"


def test_what_a_tool_states_of_itself_says_so_and_what_it_does_not_is_a_dash():
    case = JudgedCase("case", KEY, {**RESULT, "gap": None, "parameters": None}, None)
    found = {quantity: figure for quantity, figure in figures(case).items() if "stated" in quantity}
    assert set(found.values()) == {"–"}
    assert len(found) == 3
    stated = {"held_out": {"after": 1.2, "reducible_closed": 0.9}}
    found = figures(judged(gap=stated))
    assert found["error left on held-out data, as stated, median / worst decile [noise]"] == (
        "1.20 / 1.20"
    )


def test_of_a_tool_that_only_predicts_no_rate_of_names_is_stated():
    rows = {row[0]: row[2] for row in table([judged(verdict="prediction only", effects=[])])}
    assert not any("effect" in quantity for quantity in rows)
    assert "failed" in rows
