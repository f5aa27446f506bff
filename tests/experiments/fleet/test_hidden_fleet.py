"""Hidden fleets: what changes does so on its day, and the score counts what was found."""

import dataclasses
import json

import numpy as np
import pytest

from experiments.fleet.changing_rig import KINDS, RigChange, draw_change
from experiments.fleet.make_fleet import Plan, Settings, draw_drive, make_fleet, record
from experiments.fleet.pairs import Pair, summary, table
from experiments.fleet.score_fleet import score
from experiments.hidden_effects.references import ReferenceBench
from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.fleet import find_rigs
from tests.refusals import refusing


@pytest.mark.parametrize("kind", KINDS)
def test_a_change_begins_on_its_day_and_a_ramp_grows(kind):
    change = draw_change(kind, 12, np.random.default_rng(1))
    rig = ReferenceBench()
    assert all(change.applied(rig, k, 12) is rig for k in range(change.first))
    assert change.applied(rig, change.first, 12) != rig
    assert change.applied(rig, 11, 12) == KINDS[kind].apply(rig, change.size)
    ramp = RigChange("friction", 0.4, "ramp", 8)
    grown = [ramp.applied(rig, k, 12).friction / rig.friction for k in range(7, 12)]
    assert grown == pytest.approx([1.0, 1.1, 1.2, 1.3, 1.4])


def test_a_fleet_is_written_with_its_key(tmp_path):
    where = {"out": tmp_path / "fleet", "key": tmp_path / "key.json"}
    settings = Settings(**where, rigs=2, changing=1, recordings=8, processes=1)
    make_fleet(settings)
    rigs = {rig.name: rig for rig in find_rigs(settings.out)}
    key = json.loads(settings.key.read_text(encoding="utf-8"))
    assert [len(rig.dates) for rig in rigs.values()] == [8, 8]
    ((name, true),) = key.items()
    assert true["since"] == rigs[name].dates[true["first"]].isoformat()
    assert rigs[name].read().recordings[0].uncertain.keys() >= {"sheath.friction"}
    make_fleet(settings)  # goes on with what is there
    with refusing(InvalidValueError, '"seed": 1 | "seed": 2 | another --out'):
        make_fleet(dataclasses.replace(settings, seed=2))


def test_the_score_counts_what_was_found_named_and_dated():
    dates = ["2026-03-01T00:00:00", "2026-03-02T00:00:00", "2026-03-04T00:00:00"]

    def rig(name, parameter=None, since=None, rivals=(), verdict=None):
        changed = None
        if parameter:
            changed = {"parameter": parameter, "since": since, "before": 1.0, "after": 2.0}
            changed["rivals"] = [{"parameter": one} for one in rivals]
        verdict = verdict or ("changed" if changed else "consistent with the fleet")
        return {"rig": name, "dates": dates, "changed": changed, "verdict": verdict}

    true = {"kind": "friction", "course": "step", "size": 0.3, "since": dates[1]}
    key = {n: {**true, "parameter": "sheath.friction"} for n in "abc"}
    rigs = [
        rig("a", "sheath.friction", dates[2]),
        rig("b", "reel.delay", dates[1], ["sheath.friction"]),
        rig("c"),
        rig("d", "sheath.creep", dates[1]),
        rig("e", verdict="differs"),
        rig("f"),
    ]
    result = score(key, rigs)
    counts = ("found", "named", "named_first", "within_a_recording")
    assert [result[count] for count in counts] == [2, 2, 1, 2]
    assert result["false_alarms"] == ["d", "e"]


def test_the_two_states_of_a_pair_differ_by_the_change():
    rng = np.random.default_rng(1)
    drive = draw_drive(rng)[:50]
    change = RigChange("sensor_bias", 5.0, "step", 1)
    same = record(Plan((1,), (0, 1), None, drive))
    old, new = record(Plan((1,), (0, 1), change, drive))
    assert old == same[0]
    moved = new.columns["output_tension_N"] - same[1].columns["output_tension_N"]
    assert moved == pytest.approx(5.0, abs=0.01)  # readings are rounded


def test_a_pair_counts_as_named_by_what_changed_or_its_like_and_else_as_an_alarm():
    def pair(seed, kind, true, *found):
        return Pair(seed, kind, 0.0, true, found, 6.0, f"sentence {seed}")

    pairs = [
        pair(1, "friction", "sheath.friction", "reel.delay", "sheath.drawn_bend"),
        pair(2, "friction", "sheath.friction"),
        pair(3, "", "", "reel.delay"),
        pair(4, "", ""),
    ]
    assert summary(pairs) == [
        "1 of 2 changes named, 1 found",
        "1 of 2 rigs without a change called changed",
        "2 friction: sentence 2",
        "3 none: sentence 3",
    ]
    assert "| friction | 2 | 1 | 1 | 0 |" in table(pairs)
