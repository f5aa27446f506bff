"""A tendon over one guide, pulled by a motor whose control is the tension at the input."""

import mujoco
import numpy as np

import tendon_mj
from tendon_mj.show.live import LiveSimulation, Prepared
from tendon_mj.show.live.first_view import first_view

PULLED = """
<mujoco>
  <worldbody>
    <camera name="front" pos="0.5 -1.2 0.1" xyaxes="1 0 0 0 0 1" fovy="50"/>
    <site name="a"/><site name="b" pos="0.5 0 0.3"/>
    <body pos="1 0 0">
      <joint name="j" type="slide" axis="1 0 0" stiffness="2000" damping="50"/>
      <geom size="0.01" mass="1"/><site name="c"/>
    </body>
  </worldbody>
  <tendon><spatial name="t" width="0.005">
    <site site="a"/><site site="b"/><site site="c"/>
  </spatial></tendon>
  <actuator><motor name="pull" tendon="t" gear="-1"/></actuator>
</mujoco>
"""
TENSION = 10.0


def pulled(drive=lambda time: np.array([TENSION]), friction=0.3):
    """What is watched of a tendon that is pulled by 10 N, or by another drive."""
    spec = mujoco.MjSpec.from_string(PULLED)
    tendon_mj.add_friction(spec, "t", friction=friction)
    model = tendon_mj.show_tension(spec, 0.0, 20.0).compile()
    return Prepared(LiveSimulation(model, drive), first_view(model), 0.0, 20.0, "")
