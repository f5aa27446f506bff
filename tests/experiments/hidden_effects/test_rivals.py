"""Laws of the rivals: what is planted is recovered, and their results are scored."""

import dataclasses
import json
from typing import ClassVar

import numpy as np
import pytest

from experiments.hidden_effects.case_folder import Case, solve_suite
from experiments.hidden_effects.excitation import LOWEST, loops
from experiments.hidden_effects.rivals import black_box, stepwise
from experiments.hidden_effects.rivals.black_box import drive_history
from experiments.hidden_effects.rivals.term_fit import fit_terms
from experiments.hidden_effects.verdicts import judge
from tendon_mj.lab.diagnosis import Term
from tendon_mj.lab.recordings import Uncertain, write_recording
from tendon_mj.lab.replay import replay_recording
from tests.lab.recorded import recorded

NOISE = 0.05
TIME = np.arange(0.0, 2.0, 0.005)


class Lines:
    """Recordings that hold straight lines, one slope and a zero of its own for each."""

    base: ClassVar = {"line.slope": 0.0, "line.zero": 0.0}
    x = np.linspace(-1.0, 1.0, 20)
    owner = np.repeat(["a", "b"], x.size)

    def __init__(self, slope, a, b):
        self.measured = self.simulate({"line.slope": slope, "line.zero @ a": a, "line.zero @ b": b})

    def simulate(self, values):
        values = {**self.base, **values}
        own = [values.get(f"line.zero @ {name}", values["line.zero"]) for name in "ab"]
        return np.concatenate([values["line.slope"] * self.x + zero for zero in own])

    def residuals(self, sets):
        return np.array([self.simulate(values) - self.measured for values in sets])


def test_shared_terms_and_those_of_a_recording_are_recovered_together():
    rig = Lines(slope=3.0, a=0.5, b=-0.25)
    zeros = [Term((f"line.zero @ {name}",), "", 0.0, -8.0, 8.0, 0.5, spread=100.0) for name in "ab"]
    slope = Term(("line.slope",), "", 0.0, -10.0, 10.0, 0.1)
    fit = fit_terms(rig, (slope, *zeros), [0.0, 0.0, 0.0], {})
    assert fit.values == pytest.approx([3.0, 0.5, -0.25], rel=1e-3)
    assert fit.cost == pytest.approx(0.0, abs=1e-4)


def bench(name, seed):
    """A recording of the bench with viscous friction that its model lacks, and noise."""
    rng = np.random.default_rng(seed)
    bare = recorded(
        TIME,
        {"input_displacement_m": ("reel", 1e-3 * np.sin(2.0 * np.pi * (1.0 + seed) * TIME))},
        {"input_tension_N": ("input_tension", NOISE)},
        name=name,
        uncertain={"sheath.friction": Uncertain(0.15, 0.05, 0.4)},
    )
    clean = replay_recording(bare, parameters={"sheath.viscous_friction": 100.0})
    noisy = clean.columns["input_tension_N"] + rng.normal(0.0, NOISE, TIME.size)
    return dataclasses.replace(bare, columns={**bare.columns, "input_tension_N": noisy})


def test_stepwise_selection_finds_a_planted_effect_first():
    few = ("viscous_friction", "backlash", "sensor_gain", "stiffening")
    others = [name for name in stepwise.CATALOGUE if name not in few]
    case = Case(name="planted", train=[bench("one", 0)], held_out=[bench("two", 1)], exclude=others)
    result = stepwise.solve(case)
    assert (result["verdict"], result["effects"][0]) == ("named", "viscous_friction")
    assert result["parameters"]["sheath.viscous_friction"]["value"] == pytest.approx(100.0, rel=0.1)
    assert result["gap"]["held_out"]["after"] < 1.5


def played(name, seed):
    """A recording in which the reading is the drive behind a play, and noise."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, 8.0, 0.004)
    drive = loops(rng, time)
    behind = drive_history(time, drive, -LOWEST)[:, -6]
    pull = 1e4 * behind + rng.normal(0.0, NOISE, time.size)
    return recorded(
        time,
        {"input_displacement_m": ("reel", drive)},
        {"input_tension_N": ("input_tension", NOISE, pull)},
        name=name,
    )


def test_regression_on_histories_learns_a_play_and_writes_what_the_scorer_reads(tmp_path):
    folder = tmp_path / "suite" / "case_0001"
    folder.mkdir(parents=True)
    for k, name in enumerate(("train_1", "train_2", "train_3", "held_out_1")):
        write_recording(played(name, k), folder / name)
    (folder / "case.json").write_text('{"exclude": []}')
    (tmp_path / "keys.json").write_text(json.dumps({"cases": {"case_0001": {}}}))
    solve_suite(black_box.solve, tmp_path / "suite", tmp_path, cases=0, processes=1, again=False)
    (judged,) = judge(tmp_path, tmp_path)
    span = np.ptp(played("held_out_1", 3).columns["input_tension_N"]) / NOISE
    assert judged.verdict == "prediction only"
    assert judged.left < 0.05 * span
