"""A finger of two links with a flexor and an extensor, and whatever other tendons a test adds."""

import mujoco

FINGER = """
<mujoco>
  <default><geom type="box" size=".1 .02 .02" pos=".1 0 0" contype="0" conaffinity="0"/></default>
  <worldbody>
    <site name="a" pos="-.1 0 .04"/><site name="d" pos="-.1 0 -.04"/>
    <body>
      <joint name="mcp" axis="0 1 0" damping=".002"/><geom/>
      <site name="b" pos=".05 0 .03"/><site name="e" pos=".05 0 -.03"/>
      <body pos=".2 0 0">
        <joint name="pip" axis="0 1 0" damping=".002"/><geom/>
        <site name="c" pos=".05 0 .03"/><site name="f" pos=".05 0 -.03"/>
      </body>
    </body>
  </worldbody>
  <tendon>
    <spatial name="extensor" stiffness="400" springlength="0 .29">
      <site site="a"/><site site="b"/><site site="c"/>
    </spatial>
    <spatial name="flexor" stiffness="300">
      <site site="d"/><site site="e"/><site site="f"/>
    </spatial>
    {more}
  </tendon>
</mujoco>
"""
# A tendon that nothing pulls.
LIMP = '<spatial name="limp"><site site="a"/><site site="e"/><site site="c"/></spatial>'


def finger(more=""):
    """A spec of it, with ``more`` among its tendons."""
    return mujoco.MjSpec.from_string(FINGER.format(more=more))
