"""Laws of static friction above dynamic friction (Fig. 4 (b), (c))."""

import dataclasses

import numpy as np
import pytest

from experiments.kaneko1991 import routes
from experiments.kaneko1991.figure_4bc import OVERDAMPED, TENDON, measure_shift
from experiments.kaneko1991.loop import tension_sine
from experiments.kaneko1991.paper_tendon import PaperTendon


def test_without_inertia_static_friction_holds_back_one_guide_at_most():
    sticky = PaperTendon(friction=0.1, static_friction=0.3)
    _, load = tension_sine(1.0, 15.0, 20.0, 1.25, 500)
    exact = routes.closed_form(sticky.without_static_excess(), load, "tension")
    shifts = []
    for guides in (8, 32, 128):
        found = routes.sheath_alone(sticky, load, "tension", guides)
        shifts.append(np.abs(found.output_tension - exact.output_tension).max())
        one = np.expm1(0.2 * np.pi / guides) * exact.output_tension.max()
        assert 0.0 < shifts[-1] <= one
    assert shifts[0] > 2.0 * shifts[1] > 4.0 * shifts[2]


def test_an_overdamped_tendon_shifts_by_one_element():
    dynamics = dataclasses.replace(OVERDAMPED, steps=(1e-5,))
    shift, _, _ = measure_shift(TENDON, dynamics, 0.5)
    _, load = tension_sine(0.5, 15.0, 20.0, 1.0, 500)
    level = TENDON.without_static_excess()
    out = routes.closed_form(level, load, "tension").output_tension
    one = np.expm1(0.2 * np.pi / dynamics.elements) * 35.0 * np.exp(-0.1 * np.pi) / np.ptp(out)
    assert shift.largest == pytest.approx(one, rel=0.15)
    assert np.ptp(shift.largest) < 1e-6  # every period alike
    fall = 0.5 - np.arcsin((35.0 * np.exp(-0.2 * np.pi) - 20.0) / 15.0) / (2.0 * np.pi)
    assert shift.phase == pytest.approx(fall, abs=0.05)  # where T_out begins to fall
