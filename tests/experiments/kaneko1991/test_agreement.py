"""The routes agree with each other and converge to the closed form."""

import numpy as np
import pytest

from experiments.kaneko1991.agreement import compare_routes
from experiments.kaneko1991.loop import displacement_history, random_turning_points
from experiments.kaneko1991.refinement import refine


def test_routes_agree_within_half_a_percent():
    found = compare_routes(histories=2)
    assert found.largest < 0.005
    assert 0.0 < found.largest_input < 0.01
    assert set(found.difference) >= {"outer loop", "minor loops", "2 random histories"}


def test_routes_converge_to_the_closed_form():
    found = refine()
    assert found.order["continuum"] == pytest.approx(2.0, abs=0.1)
    for name in ("sheath alone, EA × 100", "plugin in MuJoCo, EA × 100", "elements"):
        assert found.order[name] == pytest.approx(2.0, abs=0.25)
    # at the strain of a real tendon finite strain remains, and nothing is said about an order
    assert "plugin in MuJoCo" not in found.order
    assert found.error["plugin in MuJoCo"].max() < 0.005


def test_random_histories_repeat_and_have_a_range():
    assert random_turning_points(5) == random_turning_points(5)
    for points in random_turning_points(20):
        time, travel = displacement_history(points)
        assert travel[0] == 0.0
        assert np.all(np.diff(time) > 0.0)
        assert travel[-1] == pytest.approx(points[-1])
        assert np.ptp(travel) > 0.8e-3
