"""Play is named where it is; noise of a driven column is neither play nor an error of a model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tendon_mj.lab.diagnosis import CATALOGUE, diagnose
from tendon_mj.lab.diagnosis.data import noise_of_drives
from tendon_mj.lab.recordings import Measured
from tendon_mj.lab.replay import Simulator
from tests.lab.replay.test_play import RADIUS, TIME, arm, motion

NOISE = {"arm_rad": 1e-3, "one_N": 0.2}
PLACE = 2e-5  # noise of the drives [m]


def measured(path, effects, drive_noise=0.0, seed=0):
    """A training and a held-out recording of an arm with effects."""
    random, time = np.random.default_rng(seed), TIME
    made = []
    for k, turns in enumerate(([0, 0, 1, -1, 0.4, 0.6], [0, 0, -0.8, 0.9, 0.1, 0.5])):
        drive = RADIUS * 0.5 * np.interp(time, TIME[-1] * np.linspace(0.0, 1.0, 6), turns)
        plan = replace(motion(path, drive), name=f"r{k}")
        plan = replace(
            plan, measured={c: Measured(m.sensor, NOISE[c]) for c, m in plan.measured.items()}
        )
        ((series,),) = Simulator([plan])([effects])
        columns = {c: series[c] + random.normal(0.0, NOISE[c], time.size) for c in plan.measured}
        shaken = random.normal(0.0, drive_noise, time.size)
        columns |= {"one_m": drive + shaken, "two_m": -drive - shaken}
        made.append(replace(plan, columns=columns))
    return made


@pytest.mark.parametrize(
    ("effect", "values"),
    [
        ("output_play", {"one_sheath.output_play": 0.03, "two_sheath.output_play": 0.03}),
        ("backlash", {"one_sheath.backlash": 9e-4, "two_sheath.backlash": 9e-4}),
    ],
)
def test_play_at_the_output_is_told_from_that_of_the_drum(tmp_path, effect, values):
    few = [CATALOGUE[name] for name in ("output_play", "backlash")]
    train, held_out = measured(arm(tmp_path), values)
    found = diagnose([train], [held_out], catalogue=few)
    assert (found.verdict, found.effects) == ("named", [effect])
    for name, value in values.items():
        assert found.parameters[name].value == pytest.approx(value, rel=0.03)


def test_noise_of_a_driven_column_is_no_play(tmp_path):
    train, held_out = measured(arm(tmp_path), {}, PLACE)
    found = diagnose([train], [held_out], catalogue=[CATALOGUE["backlash"]])
    assert (found.verdict, found.effects) == ("nothing missing", [])


def test_steps_of_a_driven_column_count_by_what_they_move(tmp_path):
    """Of eleven bits; the rig follows the motion, the model what is known of it."""
    (made,) = measured(arm(tmp_path), {})[:1]
    step = RADIUS / 2**11
    flipping = np.random.default_rng(1).normal(0.0, 0.2 * step, TIME.size)
    read = step * np.rint((made.columns["one_m"] + flipping) / step)
    coarse = replace(made, columns={**made.columns, "one_m": read, "two_m": -read})
    (levels,) = noise_of_drives([coarse], Simulator([coarse]))
    ((exact,),), ((series,),) = Simulator([made])([{}]), Simulator([coarse])([{}])
    error = series["one_N"] - exact["one_N"]
    assert np.sqrt(np.mean(error**2)) == pytest.approx(
        np.sqrt(np.mean(levels["one_N"] ** 2)), rel=0.5
    )
    rest = slice(2, 18)
    assert np.ptp(series["one_N"][rest]) == pytest.approx(0.0, abs=1e-6)


def test_noise_of_a_driven_column_counts_where_it_moves_a_reading(tmp_path):
    path = arm(tmp_path)
    made = measured(path, {}, PLACE)[:1]
    (levels,) = noise_of_drives(made, Simulator(made))
    rest = slice(2, 18)  # the model is pulled to and fro, the rig was not
    ((series,),) = Simulator(made)([{}])
    assert np.std(series["one_N"][rest]) / np.mean(levels["one_N"][rest]) == pytest.approx(
        1.0, abs=0.5
    )
    exact = measured(path, {})[:1]
    assert noise_of_drives(exact, Simulator(exact)) == ({},)
