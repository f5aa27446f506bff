"""Simulations that fail in the proof alone: a verdict is reached, from those that do not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pytest

from tendon_mj.lab.diagnosis import CATALOGUE, diagnose
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Series, Simulator
from tests.lab.diagnosis.toy import COLUMNS, bench_recording, measured_by

FRICTION = "sheath.constant_friction"
OWN = 5e-4  # step of the model [s]
FEW = [CATALOGUE["constant_friction"]]


@pytest.fixture(scope="module")
def recording() -> Recording:
    """Of a rig with the effect, which is named where no simulation fails."""
    time = np.arange(0.0, 2.0, 0.01)
    drive = 8e-4 * np.sin(7.6 * time) + 2e-4 * np.sin(21.4 * time)
    blank = bench_recording("bench", time, drive, 0.05, list(COLUMNS))
    made = measured_by(Simulator, blank, {FRICTION: 3.0}, np.random.default_rng(0))
    assert diagnose([made], catalogue=FEW).verdict == "named"
    return made


@pytest.mark.parametrize(
    ("low", "high", "verdict"),
    [
        (0.0, 1.0, "unknown"),
        (0.9 * OWN, 1.1 * OWN, "unknown"),
        (1.1 * OWN, 1.0, "named"),  # in shorter steps
    ],
)
def test_a_model_that_fails_in_the_held_out_tail_alone_has_a_verdict(
    low: float, high: float, verdict: str, recording: Recording
) -> None:
    """It fails with the effect in all steps, or in those between low and high [s]."""
    failed = []

    class Failing(Simulator):
        def __call__(self, parameter_sets: Sequence[Mapping[str, float]]) -> list[list[Series]]:
            answers = super().__call__(parameter_sets)
            (schedule,), (recording,) = self._schedules, self.recordings
            seen = schedule.samples == recording.time.size
            for given, (series,) in zip(parameter_sets, answers, strict=True):
                if seen and given.get(FRICTION) and low < schedule.clock.timestep < high:
                    failed.append(given)
                    series.update({c: np.full_like(s, np.nan) for c, s in series.items()})
            return answers

    found = diagnose([recording], simulator=Failing, catalogue=FEW)
    assert failed
    assert found.verdict == verdict
    assert found.result()["closest" if verdict == "unknown" else "effects"] == ["constant_friction"]
