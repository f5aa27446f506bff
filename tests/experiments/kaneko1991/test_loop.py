"""Measures of a loop, and Fig. 4 (a)."""

import dataclasses

import numpy as np
import pytest

from experiments.kaneko1991 import routes
from experiments.kaneko1991.figure_4a import simulate_figure_4a
from experiments.kaneko1991.loop import measure_loop, predict_loop, sliding_branches, tension_sine
from experiments.kaneko1991.paper_tendon import PaperTendon

TENDON = PaperTendon(friction=0.15, output_stiffness=8e3)


def test_a_loop_of_the_closed_form_shows_the_numbers_of_the_formulas():
    _, load = tension_sine(1.0, 15.0, 20.0, 2.25, 800)
    for tendon in (TENDON, dataclasses.replace(TENDON, constant_friction=0.5)):
        exact = routes.closed_form(tendon, load, "tension")
        found = dataclasses.astuple(measure_loop(tendon, exact, exact, 200))
        wanted = dataclasses.astuple(predict_loop(tendon, float(exact.output_tension.max())))
        assert found == pytest.approx(wanted, rel=1e-9)


def test_branches_lie_outside_the_backlash():
    _, load = tension_sine(1.0, 15.0, 20.0, 2.25, 800)
    exact = routes.closed_form(TENDON, load, "tension")
    pulling, loosening = sliding_branches(TENDON, exact, 200)
    assert not (pulling & loosening).any()
    assert pulling.sum() > 100
    assert loosening.sum() > 100
    assert np.all(np.gradient(exact.output_tension)[pulling] > 0.0)
    assert np.all(np.gradient(exact.output_tension)[loosening] < 0.0)


def test_figure_4a_has_the_slopes_of_the_apparent_stiffness():
    found = simulate_figure_4a()
    assert set(found.traces) == {
        "closed form",
        "continuum",
        "elements",
        "sheath alone",
        "plugin in MuJoCo",
        "elements in MuJoCo",
    }
    assert found.slope_error < 0.005
    assert found.largest < 0.005
    for route in ("closed form", "continuum", "elements"):
        assert found.nonlinearity[route] < 1e-6
    # Hooke's line knows no finite strain; take the strain away and the rest is on it
    assert found.nonlinearity["plugin in MuJoCo"] < 0.002
    assert found.nonlinearity["plugin in MuJoCo, EA × 10000"] < 1e-6
