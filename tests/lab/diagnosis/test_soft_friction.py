"""Dry friction of joints that MuJoCo lets creep at rest, and play with a flank that gives way."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from experiments.one_capstan import PLAY, build, noisy, record
from tendon_mj import replay_recording
from tendon_mj.lab.diagnosis import CATALOGUE, diagnose
from tendon_mj.lab.diagnosis.model_faults import warn_of_soft_friction
from tendon_mj.lab.replay import Simulator
from tests.lab.diagnosis.test_wrong_numbers import PENDULUM, measured
from tests.lab.diagnosis.toy import Toy, recording

STIFF = 'solreffriction="0.002 1" solimpfriction="0.999 0.9999 0.001 0.5 2"'


def simulator(folder: Path, friction: str) -> Simulator:
    one = measured("motor", {}, folder)[0]
    model = folder / "other.xml"
    text = PENDULUM.format(actuator='<motor name="motor" joint="elbow" gear="2"/>')
    model.write_text(text.replace('solreffriction="0.002 1"', friction))
    return Simulator([replace(one, model=str(model))])


@pytest.mark.parametrize("friction", ["", 'solreffriction="0.002 1"'])
def test_soft_friction_is_warned_of_with_what_makes_it_stiff(friction: str, tmp_path: Path) -> None:
    soft = simulator(tmp_path, friction)
    (warning,) = warn_of_soft_friction(soft, {"elbow.frictionloss": 0.1})
    assert warning.startswith("Joint elbow: ")
    assert STIFF in warning  # twice the time step
    assert warn_of_soft_friction(simulator(tmp_path, STIFF), {"elbow.frictionloss": 0.1}) == []


def test_friction_that_is_neither_there_nor_considered_is_not_warned_of(tmp_path: Path) -> None:
    soft, none = simulator(tmp_path, ""), {"elbow.frictionloss": 0.0, "elbow.damping": 0.1}
    assert warn_of_soft_friction(soft, none) == []
    assert len(warn_of_soft_friction(soft, none, {"elbow.frictionloss"})) == 1
    assert warn_of_soft_friction(Toy([recording("r", 0, {})]), {"elbow.frictionloss": 0.1}) == []


@pytest.mark.parametrize(("way", "warned"), [("soft spool", True), ("prescribed", False)])
def test_a_play_that_is_found_on_a_soft_flank_is_warned_of(
    way: str, warned: bool, tmp_path: Path
) -> None:
    path = tmp_path / "wrist.xml"
    path.write_text(build(way).to_xml())
    time = np.arange(0.0, 3.0, 0.02)
    made = record(
        "loops", time, 40.0 * np.sin(3.0 * time), np.zeros((time.size, 3)), way, str(path)
    )
    play = {f"{cable}_sheath.backlash": PLAY for cable in ("agonist", "antagonist")}
    shown = replay_recording(made, parameters=play)
    columns = np.array([shown.columns[c] for c in made.measured]) * [[1.0], [1.0], [180.0 / np.pi]]
    readings = noisy(columns.T, np.random.default_rng(1))
    found = diagnose(
        [record("loops", time, 40.0 * np.sin(3.0 * time), readings, way, str(path))],
        catalogue=[CATALOGUE["backlash"]],
    )
    assert found.effects == ["backlash"]
    said = [w for w in found.warnings if "flank" in w]
    assert [w.startswith("Joint 'spool': ") for w in said] == [True] * warned
