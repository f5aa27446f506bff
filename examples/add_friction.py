"""Add friction to the tendon of a model of your own, and see what arrives at its joint.

The model is a hinged link that a motor pulls by a tendon over three guides. Any MJCF file with a
spatial tendon takes its place: `mujoco.MjSpec.from_file("hand.xml")`.
"""

import mujoco

import tendon_mj

MODEL = """
<mujoco>
  <worldbody>
    <site name="motor" pos="-0.30 0 -0.05"/>
    <site name="forearm" pos="-0.20 0 0.02"/>
    <site name="wrist" pos="-0.10 0 -0.02"/>
    <site name="knuckle" pos="-0.02 0 -0.01"/>
    <body>
      <joint name="knuckle" axis="0 1 0" stiffness="0.5" damping="0.02"/>
      <geom type="capsule" size="0.01" fromto="0 0 0 0.05 0 0" contype="0" conaffinity="0"/>
      <site name="link" pos="0.02 0 -0.01"/>
    </body>
  </worldbody>
  <tendon>
    <spatial name="flexor">
      <site site="motor"/><site site="forearm"/><site site="wrist"/><site site="knuckle"/>
      <site site="link"/>
    </spatial>
  </tendon>
  <actuator><motor name="pull" tendon="flexor" ctrlrange="-20 0"/></actuator>
</mujoco>
"""


def flexion(friction):
    """Angle of the knuckle [deg] under a pull of 10 N, and the tension that arrives there [N]."""
    spec = mujoco.MjSpec.from_string(MODEL)
    tendon_mj.add_friction(spec, "flexor", friction=friction)
    model = spec.compile()
    data = mujoco.MjData(model)
    data.actuator("pull").ctrl = -10.0
    mujoco.mj_step(model, data, 1000)
    tension = tendon_mj.view_sheath(model, data, "flexor").tension[-1]
    return abs(float(data.joint("knuckle").qpos[0])) * 57.3, float(tension)


for friction in (0.0, 0.15, 0.3):
    angle, tension = flexion(friction)
    print(
        f"friction {friction:4.2f}: of a pull of 10 N {tension:5.2f} N arrive at the joint, which "
        f"bends by {angle:4.1f} deg"
    )
