"""Laws of plans: every combination once, and nothing hidden that its case cannot have."""

import pytest

from experiments.hidden_effects.hidden import with_imitators
from experiments.hidden_effects.plan import HIDDEN, REAL_KINDS, SINGLE_EFFECTS, plan_suite


def test_a_suite_holds_every_effect_at_every_strength_once():
    suite = plan_suite(3, ("effect",), (2.0, 5.0), (0.01,), 1, 0, 0)
    assert sorted((p.names[0], p.target) for p in suite) == sorted(
        (e, s) for e in SINGLE_EFFECTS for s in (2.0, 5.0)
    )
    assert len({p.seed for p in suite}) == len(suite)


def reality(*kinds):
    return plan_suite(3, kinds, (2.0, 5.0), (0.01, 0.002), 1, 8, 0)


def test_effects_are_hidden_among_sessions_and_above_remainders_once_each():
    for kind, least in (("session", set(HIDDEN) - {"sensor_bias"}), ("remainder", set(HIDDEN))):
        names = [p.names[0] for p in reality(kind) if p.names and p.rig == "bench"]
        assert sorted(names) == sorted(least)


def test_sessions_hide_nothing_that_they_set_anew_and_some_hide_nothing():
    plans = reality("session")
    assert all("sensor_bias" not in p.names for p in plans)
    assert sum(not p.names for p in plans) == 2
    assert 0 < sum(p.bends for p in plans) < len(plans)


def test_what_leaves_a_remainder_can_neither_be_named_nor_imitate_what_is_hidden():
    for plan in reality("remainder"):
        assert len(set(plan.small)) == 2
        for name in (*plan.names, *plan.small):
            others = {*plan.names, *plan.small} - {name}
            assert not with_imitators(name) & others
        assert plan.names[0] not in plan.exclude


@pytest.mark.parametrize("kind", REAL_KINDS)
def test_the_old_kinds_are_planned_as_if_there_were_no_others(kind):
    old = plan_suite(3, ("effect", "pair"), (5.0,), (0.01,), 1, 0, 4)
    both = plan_suite(3, ("effect", "pair", kind), (5.0,), (0.01,), 1, 0, 4)
    content = [
        {(p.names, p.target, p.noise) for p in plans if p.kind == "pair"} for plans in (old, both)
    ]
    assert content[0] == content[1]
