"""Cylinders that turn with their tendon, against what they do in a simulation."""

import warnings

import mujoco
import numpy as np
import pytest

from tendon_mj import TendonWarning, add_friction, view_sheath
from tendon_mj.attach import attach_friction
from tendon_mj.attach.tendon_bend import idlers
from tendon_mj.cli import console, main
from tendon_mj.models import load_spec
from tests.refusals import silent
from tests.rigs import wraps_half_turns

RADIUS, DRY, DAMPING, FRICTION = 0.05, 0.02, 1e-3, 0.2
# a load that hangs on a rope over a wheel; a motor pulls at the other end
WELL = """
<mujoco>
  <option timestep="0.001" integrator="implicitfast"/>
  <worldbody>
    <site name="anchor" pos="-.05 0 0"/>{outside}
    <body name="wheel" pos="0 0 1">
      <joint name="axle" axis="0 1 0" {axle}/>
      <geom name="wheel" type="cylinder" size=".05 .01" euler="90 0 0" mass=".05" {geom}/>{inside}
    </body>
    <body name="load" pos=".05 0 .3">
      <joint name="lift" type="slide" axis="0 0 1" damping="5"/>
      <geom size=".03" mass="1"/><site name="hook" pos="0 0 .03"/>
    </body>
    <body pos="1 0 0"><joint name="far"/><geom size=".01"/></body>
  </worldbody>
  <tendon>
    <spatial name="rope"><site site="anchor"/><geom geom="wheel" sidesite="side"/>
      <site site="{end}"/></spatial>
    {tendon}
  </tendon>
  <equality>{equality}</equality>
  <actuator><motor name="pull" tendon="rope" ctrlrange="-60 0"/>{actuator}</actuator>
</mujoco>
"""
ABOVE = '<site name="side" pos="0 0 {}"/>'


def well(side="outside", **more):
    """On which body the side site is; more MJCF by its place."""
    parts = dict.fromkeys(
        ("outside", "inside", "axle", "geom", "tendon", "equality", "actuator"), ""
    ) | {"end": "hook"}
    parts[side] = ABOVE.format(1.08 if side == "outside" else 0.08)
    for name, text in more.items():
        parts[name] = text if name == "end" else parts[name] + text
    return WELL.format(**parts)


def lifted(text, force=-13.0, steps=700):
    """The rope after a while, and how much tension was lost over the wheel since half of it [N]."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", TendonWarning)
        spec = add_friction(mujoco.MjSpec.from_string(text), "rope", friction=FRICTION)
    model = spec.compile()
    data = mujoco.MjData(model)
    data.actuator("pull").ctrl = force
    rope, lost = view_sheath(model, data, "rope"), []
    for _ in range(steps):
        mujoco.mj_step(model, data)
        lost.append(float(rope.input_tension - rope.output_tension))
    return data, rope, np.mean(lost[steps // 2 :])


@wraps_half_turns
def test_only_the_bearing_s_torque_is_lost_over_an_idler_and_attach_says_so(tmp_path):
    text = well(axle=f'frictionloss="{DRY}" damping="{DAMPING}"')
    data, _, lost = lifted(text)
    turning = abs(data.joint("axle").qvel[0])
    assert RADIUS * turning == pytest.approx(data.joint("lift").qvel[0], rel=0.02), "no slip"
    assert lost == pytest.approx(DRY / RADIUS + DAMPING * turning / RADIUS, rel=0.1)
    (tmp_path / "well.xml").write_text(text)
    path = tmp_path / "well.xml"
    attached = attach_friction(
        load_spec(str(path)), path, "rope", tmp_path / "new.xml", friction=FRICTION
    )
    (row,), (limit,) = attached.rows, attached.limits
    assert limit.endswith("range: lift"), "the axle is swept, and the far joint moves nothing"
    assert [row.bend, row.most_bend] == pytest.approx([np.pi, np.pi], abs=1e-3)
    assert row.transmission == row.least_transmission == 1.0
    (said,) = row.idlers
    for word in (
        "rope",
        "'wheel'",
        "'axle'",
        f"{DRY / RADIUS:g} N",
        f"{DAMPING / RADIUS**2:g} N s",
    ):
        assert word in said
    with console.capture() as capture:
        given = ["attach", str(tmp_path / "well.xml"), "--tendon", "rope", "--friction", "0.2"]
        assert main([*given, "--out", str(tmp_path / "again.xml")]) == 0
    assert "%" not in capture.get().splitlines()[-1]


HELD = {
    "a range": {"axle": 'range="-90 90"'},
    "a spring": {"axle": 'stiffness="1"'},
    "a motor": {"actuator": '<motor joint="axle"/>'},
    "a coupling": {"equality": '<joint joint1="axle" joint2="far"/>'},
    "a fixed tendon": {"tendon": '<fixed><joint joint="axle" coef="1"/></fixed>'},
    "off the axis": {"geom": 'pos=".002 0 0"'},
    "tilted": {"axle": 'pos="0 0 0"', "geom": 'axisangle="1 0 0 80"'},
    "a rope that ends on it": {"inside": '<site name="rim" pos="0 0 -.05"/>', "end": "rim"},
    "another rope over it": {
        "outside": '<site name="other" pos=".05 0 0"/>',
        "tendon": '<spatial><site site="anchor"/><geom geom="wheel"/><site site="other"/>'
        "</spatial>",
    },
}


@pytest.mark.parametrize("held", HELD)
def test_a_cylinder_that_something_holds_is_no_idler(held):
    text = well(**HELD[held])
    if held == "tilted":
        text = text.replace('euler="90 0 0"', "")
    assert idlers(mujoco.MjModel.from_xml_string(well()))
    assert not idlers(mujoco.MjModel.from_xml_string(text))


@wraps_half_turns
def test_where_friction_turns_the_side_site_the_rope_comes_off_and_it_is_warned_of():
    with pytest.warns(TendonWarning, match=r"'side'.*'rope'.*'wheel'.*'axle'.*put the side site"):
        add_friction(mujoco.MjSpec.from_string(well("inside")), "*", friction=FRICTION)
    _, rope, _ = lifted(well("inside"))
    assert float(np.sum(rope.bend_angle)) == 0.0
    _, rope, _ = lifted(well())
    assert float(np.sum(rope.bend_angle)) == pytest.approx(np.pi, abs=0.01)


@pytest.mark.parametrize("text", [well(), well("inside", axle='range="-5 5"')])
def test_no_side_site_that_stays_is_warned_of(text):
    with silent():
        add_friction(mujoco.MjSpec.from_string(text), "rope", friction=FRICTION)
