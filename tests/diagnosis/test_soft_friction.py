"""Dry friction of joints that MuJoCo lets creep at rest."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from tendon_mj.diagnosis.result.soft_friction import warn_of_soft_friction
from tendon_mj.replay.simulator import Simulator
from tests.diagnosis.test_wrong_numbers import PENDULUM, measured
from tests.diagnosis.toy import Toy, recording

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
