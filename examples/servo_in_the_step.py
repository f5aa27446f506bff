"""Control the tension at the far end of a sheath by a servo that runs inside the simulation step.

A motor winds in a tendon that pulls a spring. A torque that would be right without friction falls
short by what the sheath takes; the servo, which measures the output tension, does not.
"""

import mujoco
import numpy as np

import tendon_mj

WANTED, RADIUS = 30.0, 0.01  # tension at the output [N], radius of the spool [m]
PRETENSION, FRICTION = 10.0, 0.15


def rig(*, servo):
    """A motor, a sheath bent by half a turn, and a spring at its end."""
    spec = mujoco.MjSpec()
    motor = spec.worldbody.add_body(name="motor")
    joint = motor.add_joint(name="motor", type=mujoco.mjtJoint.mjJNT_HINGE)
    joint.armature, joint.damping[0] = 0.01, 1.0  # [kg m²], [N m s/rad]
    motor.add_geom(size=[0.01, 0, 0], mass=0.01, contype=0, conaffinity=0)
    points = tendon_mj.arc_points(length=0.4, bend=np.pi, guides=16)
    sites = tendon_mj.add_sites(spec, "guide", points)
    tendon_mj.add_tendon(spec, "tendon", sites)
    tendon_mj.add_friction(
        spec,
        "tendon",
        friction=FRICTION,
        axial_stiffness=5e3,
        pretension=PRETENSION,
        reel_joint="motor",
        reel_radius=RADIUS,
    )
    if servo:
        tendon_mj.add_servo(spec, "tendon", tension_gain=3.0, velocity_gain=1.0)
    else:
        torque = spec.add_actuator(name="servo", trntype=mujoco.mjtTrn.mjTRN_JOINT, target="motor")
        torque.set_to_motor()
    return spec.compile()


for servo in (False, True):
    model = rig(servo=servo)
    data = mujoco.MjData(model)
    data.actuator("servo").ctrl = WANTED if servo else WANTED * RADIUS
    mujoco.mj_step(model, data, round(4.0 / model.opt.timestep))
    reached = tendon_mj.view_sheath(model, data, "tendon").tension[-1]
    name = "servo on the output tension" if servo else "torque without feedback"
    print(f"{name}: {WANTED:g} N were wanted at the output, {float(reached):.2f} N are reached")
