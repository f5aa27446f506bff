"""Charts beside a clip: what they show, in which unit and colour."""

import mujoco
import numpy as np
import pytest

from tendon_mj.lab.finger import lasting, press, simulate_finger
from tendon_mj.lab.replay import FrameRecorder, control_unit, record_frames
from tendon_mj.models import TENDON_COLOUR, load_model
from tendon_mj.show import BLUE, VERMILLION
from tendon_mj.show.render.charts import charts, tendon_colours


@pytest.fixture(scope="module")
def pressed():
    """Frames of the finger as it presses, with friction and without."""
    model, found = load_model("finger"), []
    for friction in (None, 0.0):
        recorder = FrameRecorder(fps=10)
        simulate_finger(lasting(press(), 2.0), model, friction=friction, recorder=recorder)
        found.append(recorder.frames())
    return model, *found


def test_every_chart_has_a_unit(pressed):
    labels = [chart.label for chart in charts(*pressed)]
    assert labels == ["tip force [N]", "tension [N]", "joint angle [°]", "control [mN m]"]


def test_controls_of_one_chart_are_in_units_that_engineers_read():
    model = load_model("joint")
    frames = record_frames(model, [[1.0, 2e-3, 0.0]], duration=0.1, fps=20)
    frames.controls[0] = 0.0
    (controls,) = [chart for chart in charts(model, frames) if chart.label.startswith("control")]
    shown = {line.name: line.values[-1] for line in controls.lines}
    assert shown == pytest.approx({"command [°]": np.rad2deg(1.0), "reel_1 [mm]": 2.0})


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
    model = mujoco.MjModel.from_xml_string(f"""
    <mujoco>
      <worldbody>
        <site name="a" pos="0 0 1"/>
        <body><joint name="hinge"/><joint name="slide" type="slide"/><geom size=".1"/>
          <site name="b"/></body>
      </worldbody>
      <tendon>
        <spatial name="t" range="0 2"><site site="a"/><site site="b"/></spatial>
        <fixed name="coupled" range="0 2"><joint joint="hinge" coef="1"/></fixed>
      </tendon>
      <actuator>{actuator}</actuator>
    </mujoco>""")
    assert control_unit(model, 0) == unit
