"""Elbows: the simulation by fronts of slip, its laws, and its agreement with the plugin."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from experiments.elbows.simulation import Elbow, simulate
from experiments.elbows.suite import make_case, summary
from tendon_mj import read_recording, replay_recording

RIG = Elbow(
    friction=0.15,
    bend=2.5,
    length=0.8,
    axial_stiffness=15e3,
    pretension=40.0,
    radius=0.03,
    drum_radius=0.025,
    mass=0.0,
    centre_of_mass=0.1,
    inertia=0.02,
    damping=0.05,
    dry_friction=0.0,
)


def test_without_a_load_the_drums_tensions_differ_by_the_losses_of_both_cables() -> None:
    """T_1/T_2 = e^(2μφ) while the joint turns, 1 of it on the way back, and between at rest."""
    time = np.arange(0.0, 20.0, 0.02)
    drum = np.radians(30.0) * np.sin(2.0 * np.pi * 0.05 * time)
    first, second, _ = simulate(RIG, drum, 0.02).T
    share = np.log(first / second) / (2.0 * RIG.friction * RIG.bend)
    turns = np.gradient(drum, time)
    slides = np.abs(turns) > 0.5 * np.abs(turns).max()
    slides[:100] = False
    assert share[slides] == pytest.approx(np.sign(turns[slides]), abs=0.03)
    assert np.abs(share[100:]).max() < 1.05  # what breaks loose swings a little


@pytest.mark.parametrize(("seed", "kind"), [(3, "elbow"), (4, "elbow"), (8, "elbow"), (4, "mount")])
def test_a_replay_with_the_true_numbers_leaves_little_but_the_noise(
    seed: int, kind: str, tmp_path: Path
) -> None:
    truth = make_case(tmp_path, seed, kind)
    recording = read_recording(tmp_path / "train.csv", tmp_path / "elbow.toml")
    parameters = {"elbow.frictionloss": truth["dry_friction"]} if truth["dry_friction"] else {}
    for cable in ("agonist_sheath", "antagonist_sheath"):
        for name in ("friction", "pretension"):
            parameters[f"{cable}.{name}"] = truth[name]
        if truth["hidden"] == "drum":
            parameters[f"{cable}.backlash"] = truth["drum_play"]
        if truth["hidden"] == "output":
            parameters[f"{cable}.output_play"] = truth["output_play"]
        if truth["hidden"] == "mount":
            parameters[f"{cable}.output_compliance"] = truth["output_compliance"]
    replayed = replay_recording(recording, parameters=parameters)
    for column, measured in recording.measured.items():
        read = recording.columns[column]
        beyond_noise = np.mean((replayed.columns[column] - read) ** 2) - measured.noise**2
        assert np.sqrt(max(0.0, beyond_noise)) < 3e-3 * np.ptp(read), column


def test_the_summary_counts_what_was_hidden_and_what_was_named() -> None:
    case = {
        "hidden": "drum",
        "effects": ["backlash"],
        "size_found": [1.05e-3, 1.0e-3, 1.1e-3],
        "drum_play": 1.01e-3,
        "friction": 0.1,
        "friction_found": [0.102, 0.095, 0.109],
    }
    wrong = {**case, "hidden": "nothing", "effects": ["creep"], "drum_play": 0.0}
    lines = summary([case, wrong]).splitlines()
    assert lines[0] == "backlash: 1 of 1 named first, 1 to 10 %, 1 in their interval"
    assert lines[1] == "nothing hidden: 0 of 1 without an effect; wrong names: ['creep']"
