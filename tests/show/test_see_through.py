"""Bodies around tendons are drawn translucent, and no others."""

import mujoco
import numpy as np
import pytest

from tendon_mj.models import model_digest
from tendon_mj.show.render.offscreen import Offscreen
from tendon_mj.show.render.surroundings import framing, to_show

RIG = """<mujoco><asset><material name="red" rgba="1 0 0 1"/></asset><worldbody>
  <site name="a" pos="-.5 0 0"/><site name="b" pos=".5 0 {end}"/>
  <geom name="post" type="box" size=".1 .1 .1" material="red"/>
  <geom name="tube" type="capsule" size=".05" fromto="-.4 0 0 .4 0 0" rgba="0 1 0 {tube}"/>
  <geom name="arm" type="capsule" size=".2" fromto="-.6 0 0 .6 0 0" group="{group}"/>
  <geom name="drum" type="cylinder" size=".3 .5" euler="90 0 0" pos="0 0 -.31"/></worldbody>
  <tendon><spatial name="t"><site site="a"/>{over}<site site="b"/></spatial></tendon>
</mujoco>"""


@pytest.mark.parametrize(
    ("changed", "names"),
    [
        ({}, ["tube"]),  # 80 % of the tendon is in it, 20 % in the post
        ({"group": 0}, ["tube", "arm"]),  # one in the other
        ({"tube": 0, "group": 0}, ["arm"]),  # what is not to be seen hides nothing
        ({"end": 3.0}, []),  # it soon leaves them all
        ({"tube": 0, "over": '<geom geom="drum"/>'}, []),  # wound around, not within
    ],
)
def test_what_a_tendon_runs_in_is_translucent(changed, names):
    values = {"end": 0.0, "tube": 1, "group": 4, "over": ""} | changed
    model = mujoco.MjModel.from_xml_string(RIG.format(**values))
    before = model_digest(model)
    shown = to_show(model)
    translucent = [model.geom(k).name for k in np.flatnonzero(shown.geom_rgba[:, 3] % 1.0)]
    assert translucent == names
    assert model_digest(model) == before


def test_a_translucent_body_keeps_the_colour_of_its_material():
    text = RIG.format(end=0.0, tube=0, group=4, over="").replace(".1 .1 .1", ".4 .1 .1")
    shown = to_show(mujoco.MjModel.from_xml_string(text))
    assert shown.geom("post").rgba[:3] == pytest.approx([1.0, 0.0, 0.0])
    assert 0.0 < shown.geom("post").rgba[3] < 1.0


def test_a_translucent_body_is_seen_before_nothing_else():
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><geom size='.1' rgba='1 0 0 .5'/></worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    with Offscreen(model, 64, 64, ground=False) as offscreen:
        picture = offscreen.draw(data, framing(model))
    assert (picture[0, 0] == 255).all()
    red, green, blue = picture[32, 32].astype(int)
    assert red > green + 50 > 100
    assert abs(green - blue) < 5
