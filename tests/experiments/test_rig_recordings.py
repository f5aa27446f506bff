"""The recordings of the example rig are what their script makes, and differ from one another."""

from __future__ import annotations

import numpy as np
import pytest

from experiments import one_capstan
from experiments.make_rig_recordings import (
    NOISE_ANGLE,
    NOISE_TENSION,
    SEED,
    SPOOL,
    measure,
    sines,
    triangles,
)
from tendon_mj import example_rig, load_model, read_recording, replay_recording


@pytest.fixture(scope="module")
def shipped():
    folder = example_rig()
    return [
        read_recording(folder / f"{motion.__name__}.csv", folder / "rig.toml")
        for motion in (triangles, sines)
    ]


def test_the_script_makes_what_is_shipped_at_rest_at_first_with_the_stated_noise(shipped):
    random = np.random.default_rng(SEED)
    for motion, recording in zip((triangles, sines), shipped, strict=True):
        time, spool = motion()
        tension, lever = measure(time, spool, random)
        np.testing.assert_allclose(recording.time, time, atol=1e-9)
        np.testing.assert_allclose(np.degrees(recording.columns["spool_rad"]), spool, atol=0.006)
        np.testing.assert_allclose(recording.columns["cable_N"], tension, atol=2e-3)
        np.testing.assert_allclose(np.degrees(recording.columns["lever_rad"]), lever, atol=0.02)
        rest = recording.time < 0.5
        assert not recording.columns["spool_rad"][rest].any()
        assert np.std(recording.columns["cable_N"][rest]) == pytest.approx(NOISE_TENSION, rel=0.5)
        noise = np.degrees(np.std(recording.columns["lever_rad"][rest]))
        assert noise == pytest.approx(NOISE_ANGLE, rel=0.5)


def test_the_cause_is_what_the_model_lacks(shipped):
    """With the truth of the script the plugin's model leaves little more than the noise."""
    truth = {"sheath.friction": 0.10, "sheath.pretension": 15.6, "sheath.sheath_compliance": 6e-5}
    model = load_model(str(example_rig() / "rig.xml"))
    assert shipped[0].known["reel.command_scale"] == SPOOL
    for recording in shipped:
        noise = {"cable_N": NOISE_TENSION, "lever_rad": np.radians(NOISE_ANGLE)}
        for parameters, low, high in ((truth, 0.8, 1.4), ({}, 5.0, 50.0)):
            shown = replay_recording(recording, model, parameters=parameters)
            for column, level in noise.items():
                error = shown.columns[column] - recording.columns[column]
                assert low < np.sqrt(np.mean(error**2)) / level < high


@pytest.mark.parametrize("motion", [one_capstan.triangles, one_capstan.sines])
def test_the_wrist_s_recordings_are_those_of_its_simulation_with_noise(motion):
    name = {one_capstan.triangles: "wrist", one_capstan.sines: "wrist_sines"}[motion]
    shipped = np.loadtxt(example_rig() / f"{name}.csv", delimiter=",", skiprows=1)
    time, motor = motion()
    np.testing.assert_allclose(shipped[:, 0], 1e3 * time, atol=1e-6)
    np.testing.assert_allclose(shipped[:, 1], motor, atol=0.006)
    first = slice(0, 60)  # of which the simulation does not know what comes later
    readings = one_capstan.simulate(time[first], motor[first])
    noise = np.array([one_capstan.NOISE_TENSION] * 2 + [one_capstan.NOISE_ANGLE])
    off = (shipped[first, 2:] - readings) / noise
    assert np.all(np.abs(off) < 5.0)
    assert np.std(off, axis=0) == pytest.approx(1.0, rel=0.35)
