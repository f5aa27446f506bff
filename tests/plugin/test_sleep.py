"""Bodies that a sheath moves may not fall asleep."""

import mujoco
import pytest

from tendon_mj import add_friction
from tests.plugin.rigs import refused

XML = """
<mujoco>
  <option gravity="0 0 0"><flag sleep="{flag}"/></option>
  <worldbody>
    <site name="a"/><site name="g" pos=".2 0 0"/>
    <body name="link" sleep="{policy}">
      <joint type="slide" axis="1 0 0" damping="1"/><geom size=".1" contype="0" conaffinity="0"/>
      <site name="b" pos=".3 .2 0"/>
    </body>
  </worldbody>
  <tendon><spatial name="flexor"><site site="a"/><site site="g"/><site site="b"/></spatial></tendon>
</mujoco>
"""


def compiled(flag, policy):
    spec = mujoco.MjSpec.from_string(XML.format(flag=flag, policy=policy))
    law = {"friction": 0.1, "axial_stiffness": 1e3, "pretension": 1.0}
    return add_friction(spec, "flexor", **law).compile()


@pytest.mark.parametrize("policy", ["allowed", "auto", "init"])
def test_a_body_that_may_fall_asleep_is_refused_with_the_remedy(policy):
    with refused("'flexor'", "'link'", 'sleep="never"', by=(ValueError, mujoco.FatalError)):
        mujoco.MjData(compiled("enable", policy))


@pytest.mark.parametrize(("flag", "policy"), [("enable", "never"), ("disable", "allowed")])
def test_one_that_stays_awake_is_not(flag, policy):
    model = compiled(flag, policy)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 50)
    assert data.sensor("input_tension").data[0] > 0.0
