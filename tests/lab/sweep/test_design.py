"""Laws of what is varied in a sweep, and of what is said about its outputs."""

import numpy as np
import pytest

from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.lab.sweep.design import (
    Design,
    parse_axes,
    parse_outputs,
    share_of_variance,
    summarised,
)
from tests.refusals import refusing

KNOWN = ["flexor_sheath.friction", "extensor_sheath.friction", "mcp.damping", "gravity.z"]
SHEATHS = {"flexor_sheath": "flexor", "extensor_sheath": "extensor"}


def axes(*texts, draws=0):
    return parse_axes(texts, draws, KNOWN, SHEATHS)


def test_a_range_with_a_number_is_a_grid_and_a_list_is_itself():
    grid, given, five = axes("mcp.damping=0:1:3", "gravity.z=-9.81,0", "flexor.friction=0.1:0.3")
    assert grid.grid.tolist() == [0.0, 0.5, 1.0]
    assert given.grid.tolist() == [-9.81, 0.0]
    assert len(five.grid) == 5


def test_a_tendon_stands_for_its_sheath_and_a_star_for_any_text():
    tendon, *_ = axes("flexor.friction=0.1,0.2")
    both, *_ = axes("*.friction=0.1,0.2")
    assert tendon.targets == ("flexor_sheath.friction",)
    assert both.targets == ("extensor_sheath.friction", "flexor_sheath.friction")


@pytest.mark.parametrize(
    ("texts", "draws", "facts"),
    [
        (["flexor.fiction=0:1"], 0, ["did you mean 'flexor.friction'"]),
        (["flexor.mu=0:1"], 0, ["did you mean 'flexor.friction'"]),
        (["flexor_sheath.mu=0:1"], 0, ["did you mean 'flexor_sheath.friction'"]),
        (["*.fiction=0:1:3"], 0, ["--parameter *.fiction=0:1:3"]),
        (["mcp.damping=0:1:1e12"], 0, ["1e+12", "10000000"]),
        (["mcp.damping"], 0, ["name=low:high"]),
        (["mcp.damping=much"], 0, ["mcp.damping=much", "name=low:high"]),
        (["mcp.damping=1:0"], 0, ["mcp.damping=1:0", "low:high"]),
        (["mcp.damping=0:1:1"], 0, ["mcp.damping=0:1:1", "1 values"]),
        (["mcp.damping=0:inf"], 0, ["mcp.damping=0:inf", "finite"]),
        (["mcp.damping=0:1:2"], 5, ["--draws 5", "--parameter"]),
        (["*.friction=0:1", "flexor.friction=0:1"], 0, ["both set flexor_sheath.friction"]),
        ([], 0, ["--parameter"]),
    ],
)
def test_other_texts_are_not_axes(texts, draws, facts):
    with refusing((InvalidValueError, UnknownNameError), *facts):
        axes(*texts, draws=draws)


def test_a_design_has_every_combination_once_and_the_same_draws_for_each():
    varied = axes("mcp.damping=0:1:3", "flexor.friction=0.1:0.3", "gravity.z=-9.81,0", draws=7)
    design = Design(varied, 7, seed=1)
    values = design.values(0, design.rollouts)
    assert design.rollouts == 3 * 2 * 7
    assert len(np.unique(values, axis=0)) == design.rollouts
    drawn = values[:, 1].reshape(6, 7)
    assert (drawn == drawn[0]).all()
    assert (drawn >= 0.1).all()
    assert (drawn < 0.3).all()


def test_a_design_does_not_depend_on_how_it_is_cut_nor_first_draws_on_their_number():
    varied = axes("flexor.friction=0.1:0.3", "mcp.damping=0:1", draws=50)
    few, many = Design(varied, 50, seed=2), Design(varied, 90, seed=2)
    whole = few.values(0, 50)
    parts = np.concatenate([few.values(start, min(start + 7, 50)) for start in range(0, 50, 7)])
    assert (whole == parts).all()
    assert (whole == many.values(0, 50)).all()
    assert (Design(varied, 50, seed=3).values(0, 50) != whole).all()


def test_more_combinations_than_a_sweep_has_are_refused_before_any_is_drawn():
    drawn = axes("flexor.friction=0.1:0.3", draws=10**11)
    with refusing(InvalidValueError, "100000000000 rollouts"):
        Design(drawn, 10**11, seed=0)
    grids = axes("mcp.damping=0:1:1e6", "flexor.friction=0:1:1e7", "gravity.z=0:1:1e7")
    with refusing(InvalidValueError, "10000000", "100000000000000000000"):  # over 2^64
        Design(grids, 0, seed=0)


@pytest.mark.parametrize("scale", [1e-300, 1.0, 1e300])
@pytest.mark.parametrize("draws", [5, 8, 40, 400])
def test_shares_of_a_sweep_with_grids_and_draws_are_those_of_their_functions(draws, scale):
    varied = axes(
        "mcp.damping=0:1:3",
        "gravity.z=0:1:4",
        "flexor.friction=0:1",
        "extensor.friction=0:1",
        draws=draws,
    )
    a, inert, x, idle = Design(varied, draws, seed=4).values(0, 12 * draws).T
    by_grid, by_draw = scale * a**2, scale * (0.5 * x + 0.1)
    both = scale * (a + 2 * x)
    for values, among in ((a, 0), (inert, 0)):
        expected = float(values is a)
        assert share_of_variance(values, by_grid, among) == pytest.approx(expected, abs=1e-9)
        assert share_of_variance(values, by_draw, among) == pytest.approx(0.0, abs=1e-9)
    assert share_of_variance(x, by_draw, 2) == pytest.approx(1.0)
    assert share_of_variance(x, by_grid, 2) == pytest.approx(0.0, abs=1e-9)
    assert share_of_variance(idle, by_draw, 2) < 3.0 * draws**-0.5
    of_a, of_x = np.var(a), np.var(2 * x)
    assert share_of_variance(a, both, 0) == pytest.approx(of_a / (of_a + of_x))
    assert share_of_variance(x, both, 2) == pytest.approx(of_x / (of_a + of_x))
    # all that is drawn: whatever the function, it is the parameter's
    assert share_of_variance(x, np.sin(40 * x), 1) == pytest.approx(1.0)


def test_summaries_are_what_they_say():
    outputs = parse_outputs(
        ["force", "angle.final", "*.error"], {"force": "N", "angle": "rad"}, True
    )
    series = {"force": np.array([3.0, -4.0, 0.0]), "angle": np.array([1.0, 2.0, 3.0])}
    measured = {"force": np.array([3.0, -4.0, 3.0]), "angle": np.array([1.0, 2.0, 3.0])}
    summaries = dict(
        zip([o.name for o in outputs], summarised(outputs, series, measured), strict=True)
    )
    assert summaries == {
        "force.final": 0.0,
        "force.min": -4.0,
        "force.max": 3.0,
        "force.mean": pytest.approx(-1 / 3),
        "force.rms": pytest.approx(np.sqrt(25 / 3)),
        "force.error": pytest.approx(np.sqrt(3.0)),
        "angle.final": 3.0,
        "angle.error": 0.0,
    }


def test_a_name_that_looks_like_a_pattern_is_first_a_name():
    units = {"angle[0]": "rad", "angle0": "rad", "*": "N"}
    assert [o.name for o in parse_outputs(["angle[0].max"], units, False)] == ["angle[0].max"]
    assert {o.sensor for o in parse_outputs(["angle[0]"], units, False)} == {"angle[0]"}
    assert {o.sensor for o in parse_outputs(["*"], units, False)} == {"*"}
    assert len(parse_outputs(["angle*.max"], units, False)) == 2
    (axis,) = parse_axes(["*.damping=0,1"], 0, [*KNOWN, "*.damping"], SHEATHS)
    assert axis.targets == ("*.damping",)


def test_an_output_that_is_not_there_is_refused_with_the_nearest():
    with refusing(UnknownNameError, "did you mean 'force'"):
        parse_outputs(["farce"], {"force": "N"}, False)
    with refusing(UnknownNameError, "force.error"):
        parse_outputs(["force.error"], {"force": "N"}, False)  # nothing is measured
    with refusing(InvalidValueError, "sensor"):
        parse_outputs([], {}, False)
