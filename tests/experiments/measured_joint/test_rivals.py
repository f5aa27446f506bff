"""Models without physics: each finds what it can represent, and keeps its own laws."""

from dataclasses import replace

import numpy as np
import pytest

from experiments.measured_joint import bouc_wen, history_network
from experiments.measured_joint.bouc_wen import fit_bouc_wen
from experiments.measured_joint.copied_curves import fit_continued_curves, fit_copied_curves
from experiments.measured_joint.history_network import fit_history_network
from experiments.measured_joint.prandtl_ishlinskii import fit_prandtl_ishlinskii, play
from experiments.measured_joint.prediction import error
from experiments.measured_joint.recording import COLUMNS, COMMAND, bend
from tests.experiments.measured_joint.synthetic import blank

BENDS = (0, 120, 240)


def made(degrees, law, samples=240):
    """A recording all of whose columns follow a law of the command and the bend."""
    recording = blank(degrees, samples)
    series = law(recording.columns[COMMAND], bend(recording))
    return replace(recording, columns={**recording.columns, **dict.fromkeys(COLUMNS, series)})


def worst(predict, recording):
    return max(error(recording, predict(recording)).rms.values())


def play_law(command, angle):
    return (1.0 - 0.1 * angle) * play(command, 0.3) + 0.2 * command + 0.05 * angle


@pytest.mark.parametrize("fit", [fit_copied_curves, fit_continued_curves])
def test_copied_curves_are_exact_where_curves_are_linear_in_the_bend(fit):
    predict = fit([made(b, play_law) for b in BENDS])
    for degrees in (0, 60, 120, 200):
        assert worst(predict, made(degrees, play_law)) < 1e-12


def test_beyond_the_given_bends_the_nearest_curve_is_kept_or_the_line_continued():
    given = [made(b, play_law) for b in (0, 120)]
    beyond = made(240, play_law)
    assert fit_copied_curves(given)(beyond)[COLUMNS[0]] == pytest.approx(
        given[1].columns[COLUMNS[0]]
    )
    assert worst(fit_continued_curves(given), beyond) < 1e-12


def test_play_follows_within_its_threshold_and_knows_no_rate():
    series = np.random.default_rng(0).normal(size=200).cumsum()
    played = play(series, 0.7)
    assert np.abs(played - series).max() <= 0.7 + 1e-12
    stretched = np.interp(np.linspace(0, 199, 996), np.arange(200), series)
    assert play(stretched, 0.7)[::5] == pytest.approx(played)


def test_prandtl_ishlinskii_finds_plays_between_its_own():
    predict = fit_prandtl_ishlinskii([made(b, play_law) for b in BENDS])
    assert worst(predict, made(60, play_law)) < 0.02


def test_the_hysteretic_variable_saturates_where_its_rate_vanishes():
    command = np.linspace(0.0, 20.0, 400)
    z = bouc_wen._hysteresis(command, 1.5, 0.5, 2.0)
    assert z[-1] == pytest.approx((1.0 / 2.0) ** 0.5, rel=1e-3)
    assert np.all(np.diff(z) >= -1e-12)


def test_bouc_wen_finds_itself(monkeypatch):
    monkeypatch.setattr(bouc_wen, "_GENERATIONS", 15)

    def law(command, angle):
        scaled = command / np.radians(60.0)
        return 0.2 * scaled + (1.0 - 0.1 * angle) * bouc_wen._hysteresis(scaled, 3.0, 1.0, 1.0)

    predict = fit_bouc_wen([made(b, law) for b in BENDS])
    assert worst(predict, made(60, law)) < 0.02


def test_the_network_learns_a_loop_of_which_the_command_alone_says_nothing(monkeypatch):
    monkeypatch.setattr(history_network, "_MEMBERS", 2)
    given = [made(b, play_law) for b in BENDS]
    unseen = made(60, play_law)
    spread = float(np.std(unseen.columns[COLUMNS[0]]))
    assert worst(fit_history_network(given), unseen) < 0.25 * spread


def test_seeds_repeat(monkeypatch):
    monkeypatch.setattr(history_network, "_MEMBERS", 1)
    given = [made(b, play_law, 60) for b in (0, 240)]
    first, again, other = (fit_history_network(given, s)(given[0]) for s in (1, 1, 2))
    assert np.array_equal(first[COLUMNS[0]], again[COLUMNS[0]])
    assert not np.array_equal(first[COLUMNS[0]], other[COLUMNS[0]])
