"""The panel of a clip: charts in engineers' units and tendons' colours, legible for many."""

import dataclasses
import itertools

import mujoco
import numpy as np
import pytest
from matplotlib.colors import to_rgb

from tendon_mj import add_friction
from tendon_mj.lab.finger import lasting, press, simulate_finger
from tendon_mj.lab.frames import FrameRecorder
from tendon_mj.lab.motion import record_frames
from tendon_mj.lab.replay import control_unit
from tendon_mj.models import TENDON_COLOUR, load_model
from tendon_mj.plugin import UNDRAWN
from tendon_mj.show.render.offscreen import colour_limits, without_spikes
from tendon_mj.show.render.panel import (
    TENDON_PALETTE,
    Panel,
    charts,
    listed,
    tendon_colours,
)
from tendon_mj.show.style import BLUE, VERMILLION
from tests.rigs import block_and_tackle, compiled, rope

# Machado and others (2009): how linear red, green and blue look to dichromats
SEEN = {
    "all": np.eye(3),
    "protan": [[0.152, 1.053, -0.205], [0.115, 0.786, 0.099], [-0.004, -0.048, 1.052]],
    "deutan": [[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]],
    "tritan": [[1.256, -0.077, -0.179], [-0.078, 0.931, 0.148], [0.005, 0.691, 0.304]],
}
XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])


def pulled(count, rgba="0.5 0.5 0.5 1", name="tendon_{}", force=5.0):
    """A model of ``count`` tendons, each of which pulls a carriage, and frames of it."""
    names = [name.format(k) for k in range(count)]
    bodies = "".join(
        f'<site name="a{n}" pos="0 {k} 0"/><site name="b{n}" pos="1 {k} 0"/>'
        f'<body pos="1 {k} 1"><joint type="slide" axis="0 0 1" stiffness="90" damping="9"/>'
        f'<geom size=".1"/><site name="c{n}"/></body>'
        for k, n in enumerate(names)
    )
    tendons = "".join(
        f'<spatial name="{n}" rgba="{rgba}">'
        f'<site site="a{n}"/><site site="b{n}"/><site site="c{n}"/></spatial>'
        for n in names
    )
    motors = "".join(f'<motor tendon="{n}" gear="-1"/>' for n in names)
    spec = mujoco.MjSpec.from_string(
        f"<mujoco><worldbody>{bodies}</worldbody><tendon>{tendons}</tendon>"
        f"<actuator>{motors}</actuator></mujoco>"
    )
    add_friction(spec, "*", friction=0.1)
    model = spec.compile()
    return model, record_frames(model, lambda time: np.full(count, force), duration=0.2, fps=10)


def lab(colour, seen):
    """CIELAB coordinates of a colour as it is seen."""
    rgb = np.array(to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    x, y, z = np.cbrt(XYZ @ np.clip(seen @ linear, 1e-3, 1.0) / [0.9505, 1.0, 1.089])
    return np.array([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)])


@pytest.mark.parametrize("eyes", SEEN)
def test_the_colours_of_eight_tendons_are_told_apart_by_all_eyes(eyes):
    """2.3 is a difference that is just noticed."""
    seen = [lab(colour, np.array(SEEN[eyes])) for colour in TENDON_PALETTE]
    assert len(seen) == 8
    assert min(np.linalg.norm(a - b) for a, b in itertools.combinations(seen, 2)) > 5 * 2.3


@pytest.mark.parametrize("rgba", ["0.5 0.5 0.5 1", "1 0 0 1"])
def test_of_many_tendons_the_chart_has_the_first_few_in_colours_of_their_own(rgba):
    model, frames = pulled(16, rgba)
    backwards = dict(reversed(frames.cables.items()))
    frames = dataclasses.replace(frames, cables=backwards)
    tensions = next(chart for chart in charts(model, frames) if "tension" in chart.label)
    looks = [(line.colour, line.style) for line in tensions.lines]
    assert len(set(looks)) == len(looks) == 2 * len(listed(frames)), "two ends of each"
    assert listed(frames) == list(backwards)[: len(listed(frames))]
    assert tensions.left_out == 16 - len(listed(frames))


def test_a_colour_that_the_model_gives_one_tendon_alone_is_kept():
    model, _ = pulled(3)
    model.tendon_rgba[1] = [1.0, 0.0, 0.0, 1.0]
    assert list(tendon_colours(model).values())[1] == "#ff0000"


def overlap(one, other):
    wide = min(one.x1, other.x1) - max(one.x0, other.x0)
    high = min(one.y1, other.y1) - max(one.y0, other.y0)
    return wide > 0.5 and high > 0.5


@pytest.mark.parametrize("name", ["t{}", "triceps_long_{}", "right_little_finger_extensor_{}"])
@pytest.mark.parametrize("count", [2, 6, 20])
@pytest.mark.parametrize("size", [(326, 540), (436, 720)])
def test_a_legend_covers_neither_numbers_nor_curves_and_is_whole(count, name, size):
    model, frames = pulled(count, name=name)
    panel = Panel(model, frames, colour_limits(frames.cables), *size)
    figure = panel._plots[0][0].figure
    charted = [axes for axes, _ in panel._plots]
    for axes in charted:
        legend = axes.get_legend().get_window_extent()
        assert legend.x0 > -0.5
        assert legend.x1 < size[0] + 0.5, "not cut off"
        assert legend.y0 > axes.bbox.y1 - 1.0, "above its curves"
        for other in figure.axes:
            if other is not axes:
                axis = [other.bbox, *(t.get_window_extent() for t in other.get_xticklabels())]
                assert not any(overlap(legend, box) for box in axis)
    assert min(axes.bbox.height for axes in charted) > 40.0, "and leaves the curves their place"


@pytest.mark.parametrize("change", [{}, {"group": UNDRAWN}, {"points": np.full((2, 3, 3), np.nan)}])
def test_a_colour_bar_stands_beside_cables_that_have_a_path_alone(change):
    model, frames = pulled(1)
    cables = {name: dataclasses.replace(c, **change) for name, c in frames.cables.items()}
    frames = dataclasses.replace(frames, cables=cables)
    panel = Panel(model, frames, colour_limits(frames.cables), 436, 720)
    bars = len(panel._plots[0][0].figure.axes) - len(panel._plots)
    assert bars == (0 if change else 1)


def test_the_table_has_both_ends_of_a_tendon_with_friction_and_without(pressed):
    model, frames, twin = pressed
    panel = Panel(model, frames, colour_limits(frames.cables), 436, 720, twin)
    assert panel._rows[0][2] == ("with friction", "no friction")
    (cells,) = [cells for name, _, cells in panel._rows if name.strip() == "flexor"]
    pulled, free = ([end[-1] for end in cell] for cell in cells)
    assert pulled[1] < 0.7 * pulled[0]
    assert free[1] == pytest.approx(free[0], rel=1e-6)


def test_over_pulleys_a_clip_shows_the_ends_of_the_branch_that_friction_acts_on():
    spec = mujoco.MjSpec.from_string(block_and_tackle())
    add_friction(spec, "t", friction=0.2)
    model = spec.compile()
    frames = record_frames(model, lambda time: [-15.0], duration=0.2, fps=10)
    panel = Panel(model, frames, colour_limits(frames.cables), 436, 720)
    (cells,) = [cells for name, _, cells in panel._rows if name.strip() == "t, branch 1"]
    went_in, came_out = (end[-1] for end in cells[1])
    assert went_in == pytest.approx(15.0)
    assert came_out == pytest.approx(15.0 * np.exp(-0.2 * np.pi / 2.0), rel=0.02)
    (cable,) = frames.cables.values()
    drawn_end = cable.points[-1][cable.ends[1] + 1]
    assert drawn_end[0] == pytest.approx(0.0), "at the load, not at the last branch's site"


@pytest.mark.parametrize(
    ("force", "unit", "factor"), [(0.03, "mN", 1e3), (5.0, "N", 1.0), (6e4, "kN", 1e-3)]
)
def test_forces_have_few_digits_and_all_of_a_clip_are_in_one_unit(force, unit, factor):
    model, frames = pulled(1, force=force)
    scale = colour_limits(frames.cables)
    panel = Panel(model, frames, scale, 436, 720)
    tensions = next(chart for chart in charts(model, frames) if "tension" in chart.label)
    bar = panel._plots[0][0].figure.axes[0]
    ((first, last),) = [cells[1] for name, _, cells in panel._rows if "tendon_0" in name]
    assert tensions.label == panel._rows[0][0] == f"tension [{unit}]"
    assert bar.get_title("left") == f"tension along the tendon [{unit}]"
    assert bar.get_xlim()[1] == pytest.approx(factor * scale.vmax)
    assert first[-1] == tensions.lines[0].values[-1] == pytest.approx(factor * force, rel=0.2)
    assert last[-1] == tensions.lines[1].values[-1] < first[-1]


@pytest.fixture(scope="module")
def pressed():
    """Frames of the finger as it presses, with friction and without."""
    model, recorded = load_model("finger"), []
    for friction in (None, 0.0):
        recorder = FrameRecorder(fps=10)
        simulate_finger(lasting(press(), 2.0), model, friction=friction, recorder=recorder)
        recorded.append(recorder.frames())
    return model, *recorded


def test_every_chart_has_a_unit(pressed):
    labels = [chart.label for chart in charts(*pressed)]
    assert labels == ["tip force [N]", "tension [N]", "joint angle [°]", "control [mN m]"]


def test_controls_of_one_chart_are_in_units_that_engineers_read():
    model = load_model("joint")
    frames = record_frames(model, lambda time: [1.0, 2e-3, 0.0], duration=0.1, fps=20)
    frames.controls[0] = 0.0
    (controls,) = [chart for chart in charts(model, frames) if chart.label.startswith("control")]
    shown = {line.name: line.values[-1] for line in controls.lines}
    assert shown == pytest.approx({"command [°]": np.rad2deg(1.0), "reel_1 [mm]": 2.0})


@pytest.mark.parametrize(("force", "unit"), [(0.03, "mN"), (0.7, "mN"), (5.0, "N"), (6e4, "kN")])
def test_a_control_that_is_a_force_is_in_the_unit_of_the_tensions(force, unit):
    """Also where it is smaller than these, as here in the last frames."""
    model, frames = pulled(1, force=force)
    frames.controls[:, 0] = np.linspace(0.0, 1e-3 * force, len(frames.time))
    tensions, _, controls = charts(model, frames)
    assert (tensions.label, controls.label) == (f"tension [{unit}]", f"control [{unit}]")
    factor = {"mN": 1e3, "N": 1.0, "kN": 1e-3}[unit]
    assert controls.lines[0].values[-1] == pytest.approx(factor * 1e-3 * force)


def test_the_twin_presses_harder_and_stands_beside_in_the_charts(pressed):
    force, _, angles, _ = charts(*pressed)
    assert force.twin[0].values.max() > 1.5 * force.lines[0].values.max()
    assert [line.name for line in angles.lines] == ["mcp", "pip", "dip"]
    assert len(angles.twin) == 3
    assert angles.lines[0].values.max() > 10.0  # degrees


def test_a_tendon_has_one_colour_in_the_model_the_clip_and_the_charts(pressed):
    model = pressed[0]
    colours = tendon_colours(model)
    assert colours == {"flexor_sheath": BLUE.lower(), "extensor_sheath": VERMILLION.lower()}
    for tendon, rgba in TENDON_COLOUR.items():
        np.testing.assert_allclose(model.tendon_rgba[model.tendon(tendon).id], rgba, atol=1e-3)
        geoms = model.geom_rgba[model.geom_bodyid == model.body(f"{tendon}_motor").id]
        assert np.abs(geoms - rgba).max(axis=1).min() < 1e-3, "the spool's pointer"
    joints = next(chart for chart in charts(*pressed) if "angle" in chart.label)
    assert not {line.colour.lower() for line in joints.lines} & set(colours.values())


@pytest.mark.parametrize(
    ("actuator", "unit"),
    [
        ('<motor joint="hinge"/>', "N m"),
        ('<motor joint="slide"/>', "N"),
        ('<motor tendon="t"/>', "N"),
        ('<position joint="hinge"/>', "rad"),
        ('<position joint="slide"/>', "m"),
        ('<position tendon="t"/>', "m"),
        ('<velocity joint="hinge" kv="1"/>', "rad/s"),
        ('<intvelocity joint="hinge" kp="1" actrange="-1 1"/>', "rad/s"),
        ('<general joint="hinge" gainprm="3" biasprm="0 -3 -1" biastype="affine"/>', "rad"),
        ('<general joint="slide" gainprm="3" biasprm="0 0 -3" biastype="affine"/>', "m/s"),
        ('<general joint="hinge" gainprm="1" biasprm="0 0 -0.1" biastype="affine"/>', "1"),
        ('<position tendon="coupled"/>', "1"),
        ('<motor tendon="coupled"/>', "1"),
        ('<muscle tendon="t"/>', "1"),
    ],
)
def test_a_controls_unit_is_that_of_its_actuator(actuator, unit):
    fixed = '<fixed name="coupled" range="0 2"><joint joint="hinge" coef="1"/></fixed>'
    joints = '<joint name="hinge"/><joint name="slide" type="slide"/>'
    text = rope(
        "a 0 0 1", "b", tendon='range="0 2"', joint=joints, tendons=fixed, actuator=actuator
    )
    model = compiled(text)
    assert control_unit(model, 0) == unit


def test_a_scale_leaves_a_spike_out_and_keeps_a_peak():
    tensions = np.full(1000, 80.0)
    tensions[500:520] = 120.0
    assert without_spikes(tensions) == 120.0
    tensions[:3] = 508.0
    assert without_spikes(tensions) == 120.0
