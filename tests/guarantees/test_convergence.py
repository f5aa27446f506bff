"""The motion of a finger converges with the step as without friction."""

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction

LINKS = (0.045, 0.030, 0.020)  # [m]
MASSES = (0.10, 0.06, 0.03)  # [kg]
STEPS = (5e-3, 2.5e-3, 1e-3, 5e-4)


def finger(step):
    """Three joints between a flexor and an extensor, which motors pull."""
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.option.timestep, spec.option.gravity = step, np.zeros(3)
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    routes = {side: [] for side in (-1, 1)}

    def lead(body, place):
        for side, route in routes.items():
            name = f"s{side}_{len(route)}"
            body.add_site(name=name, pos=[place, 0.0, 0.009 * side])
            route.append(name)

    body, end = spec.worldbody, 0.0
    lead(body, -0.08)
    lead(body, -0.01)
    for length, mass in zip(LINKS, MASSES, strict=True):
        body = body.add_body(pos=[end, 0.0, 0.0])
        joint = body.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0.0, 1.0, 0.0])
        joint.damping[0] = joint.stiffness[0] = 0.02
        joint.limited, joint.range = True, [-0.2, 1.4]
        shape, ends = mujoco.mjtGeom.mjGEOM_CAPSULE, [0.0, 0.0, 0.0, length, 0.0, 0.0]
        body.add_geom(
            type=shape, fromto=ends, size=[0.008, 0, 0], mass=mass, contype=0, conaffinity=0
        )
        lead(body, 0.01)
        lead(body, length - 0.008)
        end = length
    for side, route in routes.items():
        tendon = spec.add_tendon(name=f"t{side}")
        for name in route:
            tendon.wrap_site(name)
        spec.add_actuator(trntype=mujoco.mjtTrn.mjTRN_TENDON, target=tendon.name)
    return spec


def motion(step, friction):
    """(400, 3) angles every 5 ms, while the motors pull as sines of 4 and 23 rad/s."""
    model = add_friction(finger(step), "*", friction=friction).compile()
    data, angles = mujoco.MjData(model), []
    for _ in range(400):
        for _ in range(round(STEPS[0] / step)):
            data.ctrl[:] = -6.0 - 5.0 * np.sin(np.array([4.0, 23.0]) * data.time)
            mujoco.mj_step(model, data)
        angles.append(data.qpos.copy())
    return np.array(angles)


def errors(friction):
    """Root mean square differences from a step of 25 µs [rad]."""
    finest = motion(2.5e-5, friction)
    return np.array([np.sqrt(np.mean((motion(s, friction) - finest) ** 2)) for s in STEPS])


@pytest.mark.parametrize("friction", [0.1, 0.3, 0.6])
def test_a_finger_converges_to_first_order_and_is_as_near_as_without_friction(friction):
    rubbing = errors(friction)
    assert (rubbing < 1.1 * errors(0.0)).all()
    assert (rubbing < 1.5 * rubbing[-1] * np.array(STEPS) / STEPS[-1]).all()
