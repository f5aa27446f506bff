"""Loops, agreement, static and constant friction of the reproduction, and its command."""

import contextlib
import dataclasses
import json

import numpy as np
import pytest

import experiments.kaneko1991.__main__ as program
from experiments.kaneko1991 import figure_4bc, figure_5, mujoco_routes, routes
from experiments.kaneko1991.__main__ import kaneko1991
from experiments.kaneko1991.agreement import compare_routes
from experiments.kaneko1991.figure_4a import simulate_figure_4a
from experiments.kaneko1991.figure_4bc import OVERDAMPED, measure_shift
from experiments.kaneko1991.figure_4bc import TENDON as TENDON_4BC
from experiments.kaneko1991.figure_5 import CONSTANT_FRICTION, measure_departure
from experiments.kaneko1991.loop import (
    measure_loop,
    predict_loop,
    sliding_branches,
    tension_sine,
)
from experiments.kaneko1991.paper_tendon import PaperTendon
from experiments.kaneko1991.refinement import refine

TENDON = PaperTendon(friction=0.15, output_stiffness=8e3)
SPRUNG = figure_5.TENDON
RUBBING = dataclasses.replace(SPRUNG, constant_friction=CONSTANT_FRICTION)


@pytest.mark.parametrize("tendon", [TENDON, dataclasses.replace(TENDON, constant_friction=0.5)])
def test_a_loop_of_the_closed_form_shows_the_numbers_of_the_formulas(tendon):
    """And its branches lie outside the backlash; constant friction opens it at the same slopes."""
    _, load = tension_sine(1.0, 15.0, 20.0, 2.25, 800)
    exact = routes.closed_form(tendon, load, "tension")
    wanted = predict_loop(tendon, float(exact.output_tension.max()))
    result = dataclasses.astuple(measure_loop(tendon, exact, exact, 200))
    assert result == pytest.approx(dataclasses.astuple(wanted), rel=1e-9)
    pulling, loosening = sliding_branches(tendon, exact, 200)
    assert not (pulling & loosening).any()
    assert min(pulling.sum(), loosening.sum()) > 100
    assert np.all(np.gradient(exact.output_tension)[pulling] > 0.0)
    assert np.all(np.gradient(exact.output_tension)[loosening] < 0.0)
    plain = predict_loop(TENDON, float(exact.output_tension.max()))
    assert (wanted.slope_pulling, wanted.slope_loosening) == (
        plain.slope_pulling,
        plain.slope_loosening,
    )
    wider = 1.0 + tendon.tension_offset / exact.output_tension.max()
    assert wanted.backlash / plain.backlash == pytest.approx(wider)


def test_figure_4a_has_the_slopes_of_the_apparent_stiffness():
    result = simulate_figure_4a()
    assert set(result.traces) == {
        "closed form",
        "continuum",
        "elements",
        "sheath alone",
        "plugin in MuJoCo",
        "elements in MuJoCo",
    }
    assert result.slope_error < 0.005
    assert result.largest < 0.005
    for route in ("closed form", "continuum", "elements"):
        assert result.nonlinearity[route] < 1e-6
    # Hooke's line knows no finite strain; take the strain away and the rest is on it
    assert result.nonlinearity["plugin in MuJoCo"] < 0.002
    assert result.nonlinearity["plugin in MuJoCo, EA × 10000"] < 1e-6


def test_routes_agree_within_half_a_percent():
    result = compare_routes(histories=2)
    assert result.largest < 0.005
    assert 0.0 < result.largest_input < 0.01
    assert set(result.difference) >= {"outer loop", "minor loops", "2 random histories"}


def test_routes_converge_to_the_closed_form():
    result = refine()
    assert result.order["continuum"] == pytest.approx(2.0, abs=0.1)
    for name in ("sheath alone, EA × 100", "plugin in MuJoCo, EA × 100", "elements"):
        assert result.order[name] == pytest.approx(2.0, abs=0.25)
    # at the strain of a real tendon finite strain remains, and nothing is said about an order
    assert "plugin in MuJoCo" not in result.order
    assert result.error["plugin in MuJoCo"].max() < 0.005


def test_plugin_repeats_the_static_friction_of_the_sheath_alone():
    sticky = PaperTendon(friction=0.1, static_friction=0.3)
    time, load = tension_sine(1.0, 15.0, 20.0, 1.25, 500)
    sheath = routes.sheath_alone(sticky, load, "tension", 20)
    plugin = mujoco_routes.plugin(sticky, time, sheath.input_displacement, 20)
    assert plugin.output_tension == pytest.approx(sheath.output_tension, rel=1e-9)
    assert plugin.input_tension == pytest.approx(sheath.input_tension, rel=1e-9)


def test_without_inertia_static_friction_holds_back_one_guide_at_most():
    sticky = PaperTendon(friction=0.1, static_friction=0.3)
    _, load = tension_sine(1.0, 15.0, 20.0, 1.25, 500)
    exact = routes.closed_form(sticky.without_static_excess(), load, "tension")
    shifts = []
    for guides in (8, 32, 128):
        result = routes.sheath_alone(sticky, load, "tension", guides)
        shifts.append(np.abs(result.output_tension - exact.output_tension).max())
        one = np.expm1(0.2 * np.pi / guides) * exact.output_tension.max()
        assert 0.0 < shifts[-1] <= one
    assert shifts[0] > 2.0 * shifts[1] > 4.0 * shifts[2]


def test_an_overdamped_tendon_shifts_by_one_element():
    dynamics = dataclasses.replace(OVERDAMPED, steps=(1e-5,))
    shift, _, _ = measure_shift(TENDON_4BC, dynamics, 0.5)
    _, load = tension_sine(0.5, 15.0, 20.0, 1.0, 500)
    level = TENDON_4BC.without_static_excess()
    out = routes.closed_form(level, load, "tension").output_tension
    one = np.expm1(0.2 * np.pi / dynamics.elements) * 35.0 * np.exp(-0.1 * np.pi) / np.ptp(out)
    assert shift.largest == pytest.approx(one, rel=0.15)
    assert np.ptp(shift.largest) < 1e-6  # every period alike
    fall = 0.5 - np.arcsin((35.0 * np.exp(-0.2 * np.pi) - 20.0) / 15.0) / (2.0 * np.pi)
    assert shift.phase == pytest.approx(fall, abs=0.05)  # where T_out begins to fall


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


@pytest.mark.long
def test_everything_is_written(tmp_path, monkeypatch):
    for name in ("HEAVY", "OVERDAMPED"):
        dynamics = getattr(figure_4bc, name)
        coarse = dataclasses.replace(dynamics, steps=(max(dynamics.steps),))
        monkeypatch.setattr(figure_4bc, name, coarse)
    told = set()
    recorder = contextlib.nullcontext(lambda what, done, total: told.add((what, done <= total)))
    monkeypatch.setattr(program, "progress_bar", lambda: recorder)
    kaneko1991(tmp_path, histories=2)
    assert told
    assert all(fits for _, fits in told)
    result = json.loads((tmp_path / "result.json").read_text("utf-8"))
    assert result["agreement"]["max_difference_of_range"] < 0.005
    assert result["figure_4a"]["slope_error"] < 0.005
    routes = {"closed form", "continuum", "sheath alone", "elements"}
    routes |= {"plugin in MuJoCo", "elements in MuJoCo"}
    assert set(result["seconds_per_simulated_second"]) == routes
    assert max(c["error"] for c in result["cost"]) <= 0.01
    widening = list(result["figure_5"]["widening_by_constant_friction"].values())
    assert widening == sorted(widening, reverse=True)
    pictures = {p.stem for p in tmp_path.glob("*.png")}
    assert pictures >= {f"figure_{name}" for name in ("4a", "4b", "4c", "5")}
    assert pictures >= {"agreement", "refinement", "stiction", "cost"}
    page = (tmp_path / "numbers.md").read_text("utf-8")
    assert "| elements in MuJoCo |" in page
    assert "nan" not in page
