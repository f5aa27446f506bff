"""Two states of one rig: what changed between them, and what would have been found."""

from __future__ import annotations

import json
from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest

from tendon_mj.cli import main
from tendon_mj.errors import RecordingError
from tendon_mj.lab.fleet import compare_states
from tendon_mj.lab.fleet.changes import SIGNIFICANT
from tendon_mj.lab.fleet.observation import fit_series, observe
from tendon_mj.lab.recordings import Uncertain, read_recording
from tendon_mj.lab.replay import Simulator, load_recorded
from tests.lab.fleet.small_fleet import AFTER, BEFORE, CHANGED, FIRST, NOISE, SINCE, write_fleet


@pytest.fixture(scope="module")
def fleet(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("states") / "hands"
    write_fleet(folder, rigs=2)
    return folder


def day(fleet: Path, rig: str, k: int) -> Path:
    return fleet / rig / f"{FIRST + timedelta(days=k)}.csv"


def compared(fleet: Path, rig: str, old: list[int], new: list[int], **given: float):
    """The states of a rig on some days."""
    toml = fleet / "description.toml"
    states = [[read_recording(day(fleet, rig, k), toml) for k in days] for days in (old, new)]
    return compare_states(*states, load_recorded(states[0][0]), **given)


def test_the_number_that_changed_is_named_with_its_values(fleet: Path, tmp_path: Path) -> None:
    tables = [str(day(fleet, CHANGED, k)) for k in (0, SINCE)]
    options = ["--description", str(fleet / "description.toml"), "--out", str(tmp_path)]
    assert main(["changes", *tables, *options]) == 0
    found = json.loads((tmp_path / "result.json").read_text("utf-8"))
    changed = found
    assert changed["changed"]
    assert changed["parameter"] == "sheath.friction"
    assert [changed["before"], changed["after"]] == pytest.approx([BEFORE, AFTER], abs=0.01)
    assert {r["parameter"] for r in changed["rivals"]} == {"sheath.drawn_bend"}, "the product tells"
    assert found["left"] < 1.2 < found["misfit"]


def test_what_differs_from_day_to_day_is_no_change(fleet: Path) -> None:
    """Friction is drawn anew each day, by 1 %; of several days their scatter tells."""
    friction = "sheath.friction", "-"
    for old, new in (([0, 1, 2], [3, 4, 5]), ([0], [SINCE])):
        states = compared(fleet, "hand_1", old, new)
        assert not states.changed
        assert 0.0 < states.least[friction] < 0.2 * BEFORE
    exact = compared(fleet, "hand_1", [0], [SINCE], reproducibility=0.0)
    assert 0.0 < exact.least[friction] < 0.5 * states.least[friction]


def test_another_known_number_is_refused_and_no_change_says_what_is_nearest(fleet: Path) -> None:
    old, new = (
        read_recording(day(fleet, "hand_1", k), fleet / "description.toml") for k in (0, SINCE)
    )
    known = replace(new, known={**new.known, "sheath.axial_stiffness": 1e4})
    with pytest.raises(RecordingError, match=r"differ in \[known\] sheath.axial_stiffness"):
        compare_states([old], [known], load_recorded(old))
    said = compare_states([old], [new], load_recorded(old)).sentence
    assert "What explains most is sheath.friction" in said
    assert "of 5 that are asked" in said


@pytest.mark.parametrize(("noises", "changed"), [(1.5, False), (6.0, True)])
def test_a_zero_comes_back_to_within_the_noise_of_its_sensor(
    fleet: Path, noises: float, changed: bool
) -> None:
    """No share of an offset, which is 0, says so: 1.5 of 0.05 N are 8 standard errors of noise."""
    rig = [read_recording(day(fleet, "hand_1", k), fleet / "description.toml") for k in (0, SINCE)]
    columns = dict(rig[0].columns)
    columns["output_N"] = columns["output_N"] + noises * NOISE
    moved = replace(rig[0], columns=columns)
    states = compare_states([rig[0]], [moved], load_recorded(moved))
    assert states.changed == changed
    assert states.series.parameter == "output_tension.offset" or not changed


def test_what_another_number_may_explain_that_comes_back_is_no_change(fleet: Path) -> None:
    """Friction comes back to within 1.5 %; fitted alone, its constant part changes by far more."""
    old = read_recording(day(fleet, "hand_1", 0), fleet / "description.toml")
    friction, random, both = old.uncertain["sheath.friction"].value, np.random.default_rng(7), []
    for name, factor in (("old", 1.0), ("new", 1.015)):
        ((answer,),) = Simulator([old], threads=1)([{"sheath.friction": factor * friction}])
        noisy = {c: x + random.normal(0.0, NOISE, x.size) for c, x in answer.items()}
        both.append(replace(old, name=name, columns={**old.columns, **noisy}))
    model = load_recorded(old)
    seen = observe(both, model)
    constant = {n: [0.0, 0.0] for n in seen.numbers if n.identifier == "constant_friction"}
    for reproducibility, changed in ((0.01, False), (0.0, True)):
        (series,) = fit_series(both, model, seen.terms.tolist(), constant, reproducibility)
        error = float(np.hypot(*series.errors_apart))
        assert (abs(np.diff(series.apart)[0]) > SIGNIFICANT * error) == changed


def test_a_number_that_hardly_shows_is_none_that_changed(fleet: Path) -> None:
    """Its values come out far beyond its range, and with as large an error."""
    rig = [read_recording(day(fleet, "hand_1", 0), fleet / "description.toml")] * 2
    little = {**rig[0].uncertain, "sheath.axial_damping": Uncertain(0.0, 0.0, 0.01)}
    random, both = np.random.default_rng(1), []
    for one in rig:
        moved = {c: x + random.normal(0.0, NOISE, x.size) for c, x in one.columns.items()}
        columns = {**one.columns, **{c: moved[c] for c in one.measured}}
        both.append(replace(one, columns=columns, uncertain=little))
    states = compare_states([both[0]], [both[1]], load_recorded(both[0]))
    assert not states.changed, states.sentence
    assert "axial_damping" not in str(states.least), "a change of it within its range would not be"


def test_play_is_named_although_little_of_it_shows_to_first_order(fleet: Path) -> None:
    old = read_recording(day(fleet, "hand_1", 0), fleet / "description.toml")
    random, values = np.random.default_rng(5), {"sheath.backlash": 3e-4}
    ((answer,),) = Simulator([old], threads=1)([values])
    noisy = {c: x + random.normal(0.0, NOISE, x.size) for c, x in answer.items()}
    states = compare_states(
        [old], [replace(old, columns={**old.columns, **noisy})], load_recorded(old)
    )
    assert states.changed
    assert states.series.parameter == "sheath.backlash"
    assert states.after - states.before == pytest.approx(3e-4, rel=0.05)
