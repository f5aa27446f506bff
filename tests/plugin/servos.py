"""A small bench with a motor on which the servo's laws are tested."""

import mujoco
import numpy as np

from tendon_mj import add_friction, add_servo, add_sites, add_tendon, arc_points

RADIUS, INERTIA, SPRING = 0.01, 0.02, 20e3
PRETENSION = 20.0


def hand(
    friction=0.0,
    timestep=0.0005,
    integrator="Euler",
    radius=RADIUS,
    inertia=INERTIA,
    bend=2.0,
    guides=4,
    mass=0.05,
    **servo,
):
    """A motor with a spool pulls through a sheath on a slider that a spring holds."""
    spec = mujoco.MjSpec()
    spec.option.timestep = timestep
    spec.option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    spec.option.gravity = [0.0, 0.0, 0.0]
    points = arc_points(0.4, bend, guides)
    sites = add_sites(spec, "guide", points[:-1])
    heading = (points[-1] - points[-2]) / np.linalg.norm(points[-1] - points[-2])
    load = spec.worldbody.add_body(name="load", pos=points[-1])
    slide = load.add_joint(name="load", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=-heading)
    slide.stiffness[0], slide.springref = SPRING, -PRETENSION / SPRING
    slide.damping[0] = 2.0 * np.sqrt(SPRING * mass)
    load.add_geom(size=[0.01, 0.0, 0.0], mass=mass, contype=0, conaffinity=0)
    load.add_site(name="output")
    add_tendon(spec, "tendon", [*sites, "output"])
    motor = spec.worldbody.add_body(name="motor")
    joint = motor.add_joint(name="motor", type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0.0, 0.0, 1.0])
    joint.armature = inertia
    motor.add_geom(size=[0.01, 0.0, 0.0], mass=1e-6, contype=0, conaffinity=0)
    add_friction(
        spec,
        "tendon",
        friction=friction,
        axial_stiffness=10e3,
        pretension=PRETENSION,
        reel_joint="motor",
        reel_radius=radius,
    )
    add_servo(spec, "tendon", **({"tension_gain": 7.0, "velocity_gain": 1.0} | servo))
    return spec


def model(**values):
    return hand(**values).compile()


def stiffness():
    """K_t without friction [N/m]."""
    return 1.0 / (1.0 / SPRING + 0.4 / 10e3)


def respond(model, reference, data=None):
    """Columns time, T_out, T_in, θ, θ̇, actuator force, a row a step."""
    data = mujoco.MjData(model) if data is None else data
    rows = []
    for value in reference:
        data.ctrl[0] = value
        mujoco.mj_step(model, data)
        rows.append(
            (
                data.time - model.opt.timestep,
                data.sensor("output_tension").data[0],
                data.sensor("input_tension").data[0],
                data.joint("motor").qpos[0],
                data.joint("motor").qvel[0],
                data.actuator_force[0],
            )
        )
    return np.array(rows)
