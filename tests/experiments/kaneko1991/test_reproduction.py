"""What the reproduction of the paper rests on: that its routes agree, and what its numbers mean."""

import dataclasses
import json

import numpy as np
import pytest

from experiments.kaneko1991 import figure5 as paper_figure5
from experiments.kaneko1991 import mujoco_route as paper_mujoco
from experiments.kaneko1991 import routes as paper_routes
from experiments.kaneko1991 import stiction as paper_stiction
from experiments.kaneko1991.agreement import agree, follow, random_turns, refine
from experiments.kaneko1991.figure4 import figure_4a, sine
from experiments.kaneko1991.figure5 import CONSTANT_FRICTION
from experiments.kaneko1991.figure5 import RIG as SPRUNG
from experiments.kaneko1991.loop import branches, loop_numbers, theory_numbers
from experiments.kaneko1991.report import run_paper
from experiments.kaneko1991.rig import Rig
from tendon_mj.errors import InvalidValueError, TendonError

RIG = Rig(friction=0.15, output_stiffness=8e3)
RUBBING = SPRUNG.but(constant_friction=CONSTANT_FRICTION)


def test_routes_agree_within_half_a_percent():
    found = agree(histories=2)
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


@pytest.mark.parametrize("drive", ["tension", "displacement"])
def test_constant_friction_is_a_shift_of_the_tension(drive):
    _, load = sine(0.4, 19.0, 20.0, 1.25, 400)
    exact = paper_routes.closed_form(RUBBING, load, "tension")
    history = load if drive == "tension" else exact.input_displacement
    sheath = paper_routes.sheath_alone(RUBBING, history, drive, 64)
    grid = paper_routes.continuum(RUBBING, history, drive)
    without = paper_routes.closed_form(SPRUNG, load, "tension").output_tension
    span = np.ptp(exact.output_tension)
    assert np.abs(grid.output_tension - exact.output_tension).max() < 1e-4 * span
    assert np.abs(sheath.output_tension - exact.output_tension).max() < 0.005 * span
    assert np.abs(without - exact.output_tension).max() > 0.02 * span


def test_constant_friction_leaves_the_slopes_and_opens_the_loop():
    both = [theory_numbers(rig, 20.0) for rig in (SPRUNG, RUBBING)]
    assert both[0].slope_pulling == both[1].slope_pulling
    assert both[0].slope_loosening == both[1].slope_loosening
    wider = both[1].backlash / both[0].backlash
    assert wider == pytest.approx(1.0 + RUBBING.tension_offset / 20.0)


def test_constant_friction_moves_a_branch_by_the_same_everywhere():
    _, load = sine(0.4, 19.0, 20.0, 2.25, 800)
    exact = [paper_routes.closed_form(rig, load, "tension") for rig in (SPRUNG, RUBBING)]
    gone = paper_figure5.departure((SPRUNG, RUBBING), exact)
    over_load = (gone.tension_pulling, gone.tension_loosening)
    slides = [
        branches(rig, trace, 200) for rig, trace in zip((SPRUNG, RUBBING), exact, strict=True)
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
    straight = Rig(friction=0.0, constant_friction=1.0)
    with pytest.raises(InvalidValueError, match="friction × bend > 0"):
        paper_routes.closed_form(straight, np.array([20.0, 21.0]), "tension")


def test_a_loop_of_the_closed_form_shows_the_numbers_of_the_formulas():
    _, load = sine(1.0, 15.0, 20.0, 2.25, 800)
    for rig in (RIG, RIG.but(constant_friction=0.5)):
        exact = paper_routes.closed_form(rig, load, "tension")
        found = dataclasses.astuple(loop_numbers(rig, exact, exact, 200))
        wanted = dataclasses.astuple(theory_numbers(rig, float(exact.output_tension.max())))
        assert found == pytest.approx(wanted, rel=1e-9)


def test_branches_lie_outside_the_backlash():
    _, load = sine(1.0, 15.0, 20.0, 2.25, 800)
    exact = paper_routes.closed_form(RIG, load, "tension")
    pulling, loosening = branches(RIG, exact, 200)
    assert not (pulling & loosening).any()
    assert pulling.sum() > 100
    assert loosening.sum() > 100
    assert np.all(np.gradient(exact.output_tension)[pulling] > 0.0)
    assert np.all(np.gradient(exact.output_tension)[loosening] < 0.0)


def test_figure_4a_has_the_slopes_of_the_apparent_stiffness():
    found = figure_4a()
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
        assert found.straight[route] < 1e-6
    # Hooke's line knows no finite strain; take the strain away and the rest is on it
    assert found.straight["plugin in MuJoCo"] < 0.002
    assert found.straight["plugin in MuJoCo, EA × 10000"] < 1e-6


def test_without_inertia_static_friction_holds_back_one_guide_at_most():
    sticky = Rig(friction=0.1, static_friction=0.3)
    _, load = sine(1.0, 15.0, 20.0, 1.25, 500)
    exact = paper_routes.closed_form(sticky.but(static_friction=None), load, "tension")
    shifts = []
    for guides in (8, 32, 128):
        found = paper_routes.sheath_alone(sticky, load, "tension", guides)
        shifts.append(np.abs(found.output_tension - exact.output_tension).max())
        one = np.expm1(0.2 * np.pi / guides) * exact.output_tension.max()
        assert 0.0 < shifts[-1] <= one
    assert shifts[0] > 2.0 * shifts[1] > 4.0 * shifts[2]


def test_an_overdamped_tendon_shifts_by_one_element():
    tendon = dataclasses.replace(paper_stiction.OVERDAMPED, steps=(1e-5,))
    shift, _, _ = paper_stiction.measure_shift(paper_stiction.RIG, tendon, 0.5)
    _, load = sine(0.5, 15.0, 20.0, 1.0, 500)
    level = paper_stiction.RIG.but(static_friction=None)
    out = paper_routes.closed_form(level, load, "tension").output_tension
    one = np.expm1(0.2 * np.pi / tendon.elements) * 35.0 * np.exp(-0.1 * np.pi) / np.ptp(out)
    assert shift.largest == pytest.approx(one, rel=0.15)
    assert np.ptp(shift.largest) < 1e-6  # every period alike
    fall = 0.5 - np.arcsin((35.0 * np.exp(-0.2 * np.pi) - 20.0) / 15.0) / (2.0 * np.pi)
    assert shift.phase == pytest.approx(fall, abs=0.05)  # where T_out begins to fall


def test_plugin_repeats_the_stiction_of_the_sheath_alone():
    sticky = Rig(friction=0.1, static_friction=0.3)
    time, load = sine(1.0, 15.0, 20.0, 1.25, 500)
    sheath = paper_routes.sheath_alone(sticky, load, "tension", 20)
    plugin = paper_mujoco.plugin(sticky, time, sheath.input_displacement, 20)
    assert plugin.output_tension == pytest.approx(sheath.output_tension, rel=1e-9)
    assert plugin.input_tension == pytest.approx(sheath.input_tension, rel=1e-9)


def test_what_cannot_be_done_is_refused_before_anything_is_computed(tmp_path):
    def nothing(what, done, total):
        raise AssertionError(what)

    with pytest.raises(InvalidValueError, match="histories = -1"):
        run_paper(tmp_path / "new", nothing, -1)
    assert not (tmp_path / "new").exists()
    (tmp_path / "file").write_text("")
    with pytest.raises(InvalidValueError, match="is a file"):
        run_paper(tmp_path / "file", nothing)


def test_random_histories_repeat_and_have_a_range():
    assert random_turns(5) == random_turns(5)
    for turns in random_turns(20):
        time, travel = follow(turns)
        assert travel[0] == 0.0
        assert np.all(np.diff(time) > 0.0)
        assert travel[-1] == pytest.approx(turns[-1])
        assert np.ptp(travel) > 0.8e-3


def test_a_simulation_that_blows_up_is_refused():
    model = paper_mujoco.plugin_model(RIG, 64, 5e-3)
    reel = 1e-3 * np.sin(np.arange(2000) * 0.1)
    with pytest.raises(TendonError, match="became unstable"):
        paper_mujoco.rollout_named_sensors(model, reel)


def test_the_whole_is_written(tmp_path, monkeypatch):
    for name in ("HEAVY", "OVERDAMPED"):
        tendon = getattr(paper_stiction, name)
        coarse = dataclasses.replace(tendon, steps=(max(tendon.steps),))
        monkeypatch.setattr(paper_stiction, name, coarse)
        monkeypatch.setattr(f"experiments.kaneko1991.loop_figures.{name}", coarse, raising=False)
    seen = set()
    result = run_paper(tmp_path, lambda what, done, total: seen.add((what, done <= total)), 2)
    assert all(fits for _, fits in seen)
    assert json.loads(json.dumps(result, allow_nan=False))
    assert result["agreement"]["max_difference_of_range"] < 0.005
    assert result["figure_4a"]["slope_error"] < 0.005
    assert set(result["seconds_per_simulated_second"]) == {
        "closed form",
        "continuum",
        "sheath alone",
        "plugin in MuJoCo",
        "elements",
        "elements in MuJoCo",
    }
    assert max(c["error"] for c in result["cost"]) <= 0.01
    widening = list(result["figure_5"]["widening_by_constant_friction"].values())
    assert widening == sorted(widening, reverse=True)
    pictures = {p.name for p in tmp_path.glob("*.png")}
    assert pictures >= {f"figure_{name}.png" for name in ("4a", "4b", "4c", "5")}
    page = (tmp_path / "numbers.md").read_text("utf-8")
    assert "| elements in MuJoCo |" in page
    assert "nan" not in page
