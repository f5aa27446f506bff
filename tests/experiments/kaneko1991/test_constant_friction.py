"""Laws of tension-independent friction (Fig. 5)."""

import dataclasses

import numpy as np
import pytest

from experiments.kaneko1991 import figure_5, routes
from experiments.kaneko1991.figure_5 import CONSTANT_FRICTION, measure_departure
from experiments.kaneko1991.loop import predict_loop, sliding_branches, tension_sine
from experiments.kaneko1991.paper_tendon import PaperTendon
from tendon_mj.errors import InvalidValueError
from tests.refusals import refusing

SPRUNG = figure_5.TENDON
RUBBING = dataclasses.replace(SPRUNG, constant_friction=CONSTANT_FRICTION)


@pytest.mark.parametrize("drive", ["tension", "displacement"])
def test_constant_friction_is_a_shift_of_the_tension(drive):
    _, load = tension_sine(0.4, 19.0, 20.0, 1.25, 400)
    exact = routes.closed_form(RUBBING, load, "tension")
    history = load if drive == "tension" else exact.input_displacement
    sheath = routes.sheath_alone(RUBBING, history, drive, 64)
    grid = routes.continuum(RUBBING, history, drive)
    without = routes.closed_form(SPRUNG, load, "tension").output_tension
    span = np.ptp(exact.output_tension)
    assert np.abs(grid.output_tension - exact.output_tension).max() < 1e-4 * span
    assert np.abs(sheath.output_tension - exact.output_tension).max() < 0.005 * span
    assert np.abs(without - exact.output_tension).max() > 0.02 * span


def test_constant_friction_leaves_the_slopes_and_opens_the_loop():
    both = [predict_loop(tendon, 20.0) for tendon in (SPRUNG, RUBBING)]
    assert both[0].slope_pulling == both[1].slope_pulling
    assert both[0].slope_loosening == both[1].slope_loosening
    wider = both[1].backlash / both[0].backlash
    assert wider == pytest.approx(1.0 + RUBBING.tension_offset / 20.0)


def test_constant_friction_moves_a_branch_by_the_same_everywhere():
    _, load = tension_sine(0.4, 19.0, 20.0, 2.25, 800)
    exact = [routes.closed_form(tendon, load, "tension") for tendon in (SPRUNG, RUBBING)]
    gone = measure_departure((SPRUNG, RUBBING), exact)
    over_load = (gone.tension_pulling, gone.tension_loosening)
    slides = [
        sliding_branches(tendon, trace, 200)
        for tendon, trace in zip((SPRUNG, RUBBING), exact, strict=True)
    ]
    for side, wanted in enumerate(over_load):
        both = slides[0][side] & slides[1][side]
        moved = exact[1].output_tension[both] - exact[0].output_tension[both]
        assert moved == pytest.approx(wanted, rel=1e-9)
    for side, wanted in enumerate((gone.travel_pulling, gone.travel_loosening)):
        ends = [
            (trace.input_displacement[which[side]], trace.output_tension[which[side]])
            for trace, which in zip(exact, slides, strict=True)
        ]
        line = np.polyfit(*ends[0], 1)
        assert ends[1][1] - np.polyval(line, ends[1][0]) == pytest.approx(wanted, rel=1e-6)
    assert gone.lower_flat_with[1] < 0.5e-3 < exact[1].input_displacement.max()


def test_constant_friction_needs_a_bend_to_be_shared_over():
    straight = PaperTendon(friction=0.0, constant_friction=1.0)
    with refusing(InvalidValueError, "friction × bend > 0"):
        routes.closed_form(straight, np.array([20.0, 21.0]), "tension")
