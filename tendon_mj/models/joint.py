"""An antagonistic joint behind a bent sheath, as a model with every parameter free.

A motor's spool winds tendon 1 in and pays tendon 2 out by moment arm × angle. Both run through one
sheath, side by side across the plane of its bend, so that they are equally long and equally bent,
to a pulley of the same radius on a hinge with a spring. `models/joint/joint.xml` is this with the
defaults.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from tendon_mj.attach import add_friction, add_sensor, add_sites, add_tendon, arc_points
from tendon_mj.models.bench import check_parameters
from tendon_mj.typing import FloatArray

_TENDONS = (1, 2)
_MAY_BE_0 = ("friction", "pretension", "stiffness", "damping", "servo_damping")
_ACROSS = np.array([0.0, 0.0, 1.0])  # normal of the plane in which the sheath bends
_LEFT = np.array([0.0, 1.0, 0.0])  # to which it bends, where it starts along +x
_COLOURS = {1: [0.85, 0.2, 0.15, 1.0], 2: [0.1, 0.35, 0.8, 1.0]}
_STEEL, _TIP = [0.45, 0.47, 0.5, 1.0], [0.95, 0.65, 0.15, 1.0]
_TENDON_RADIUS = 0.0005  # as drawn [m]
_TIP_LENGTH = 0.04  # of the tip and of the spool's crank, as drawn [m]


@dataclass(frozen=True, kw_only=True)
class Joint:
    """Parameters of the joint; the defaults are those of `models/joint/parameters.toml`."""

    bend: float = np.pi * 2.0 / 3.0  # total angle that the sheath turns through [rad]
    friction: float = 0.19  # μ of both tendons, static = dynamic [-]
    length: float = 0.7  # of the sheath [m]
    free_length: float = 0.03  # straight, from sheath to spool and from sheath to hinge [m]
    guides: int = 16  # sites that stand for the sheath
    axial_stiffness: float = 5000.0  # EA of each tendon [N]
    pretension: float = 5.0  # T_0 of each tendon [N]
    moment_arm: float = 0.003  # r, radius of the spool and of the hinge's pulley [m]
    stiffness: float = 0.02  # of the hinge's spring [N m/rad]
    damping: float = 0.0005  # of the hinge [N m s/rad]
    inertia: float = 1e-5  # of the tip about the hinge, with its centre of mass there [kg m²]
    motor_inertia: float = 0.01  # seen at the spool, behind the gear [kg m²]
    servo_stiffness: float = 1e4  # torque of the motor per angle that it lags its command [N m/rad]
    servo_damping: float = 20.0  # torque of the motor per speed of the spool [N m s/rad]
    timestep: float = 0.001  # [s]

    def __post_init__(self) -> None:
        check_parameters(vars(self), may_be_0=_MAY_BE_0, signed=("bend",))

    @property
    def exponent(self) -> float:
        """|λ| = μ × total bend, for one tendon [-]."""
        return self.friction * self.bend


def build_joint(joint: Joint) -> mujoco.MjSpec:
    """The joint as an editable model.

    Actuators `command` [rad] and `reel_1`, `reel_2` [m], which wind each tendon in besides;
    sheaths `sheath_1`, `sheath_2`; hinge `joint`; sensors `joint_angle`, `spool_angle` [rad] and
    `input_tension_k`, `output_tension_k` [N].
    """
    spec = mujoco.MjSpec()
    spec.modelname = "joint"
    spec.option.timestep = joint.timestep
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.gravity = [0.0, 0.0, 0.0]
    centre = arc_points(joint.length, joint.bend, joint.guides)  # spool, guides, hinge
    heading = np.array([np.cos(joint.bend), np.sin(joint.bend), 0.0])
    centre[0] -= joint.free_length * np.array([1.0, 0.0, 0.0])
    centre[-1] += joint.free_length * heading
    spool = _add_wheel(spec, "spool", joint, centre[0], -_LEFT, _ACROSS, 1e-6)
    spool.armature = joint.motor_inertia
    axis = -np.cross(_ACROSS, heading)
    hinge = _add_wheel(spec, "joint", joint, centre[-1], axis, heading, joint.inertia)
    hinge.stiffness[0] = joint.stiffness
    hinge.damping[0] = joint.damping
    # dry friction at the hinge, if a user adds some: by default it would creep on so light a tip
    hinge.solref_friction = [2.0 * joint.timestep, 1.0]
    hinge.solimp_friction = [0.9999, 0.9999, 0.001, 0.5, 2.0]
    command = spec.add_actuator(name="command", trntype=mujoco.mjtTrn.mjTRN_JOINT, target="spool")
    command.set_to_position(kp=joint.servo_stiffness, kv=joint.servo_damping)
    for k, side in zip(_TENDONS, (1.0, -1.0), strict=True):
        points = centre + side * joint.moment_arm * _ACROSS
        sites = add_sites(spec, f"guide_{k}", points)
        tendon = add_tendon(spec, f"tendon_{k}", sites)
        tendon.width, tendon.rgba = _TENDON_RADIUS, _COLOURS[k]
        add_friction(
            spec,
            f"tendon_{k}",
            name=f"sheath_{k}",
            friction=joint.friction,
            axial_stiffness=joint.axial_stiffness,
            pretension=joint.pretension,
            reel=f"reel_{k}",
            reel_joint="spool",
            reel_radius=side * joint.moment_arm,
            output_joint="joint",
            output_radius=-side * joint.moment_arm,
            sensors=(),
        )
    angle, on = mujoco.mjtSensor.mjSENS_JOINTPOS, mujoco.mjtObj.mjOBJ_JOINT
    for name in ("joint", "spool"):
        spec.add_sensor(name=f"{name}_angle", type=angle, objtype=on, objname=name)
    for kind in ("input_tension", "output_tension"):
        for k in _TENDONS:
            add_sensor(spec, f"sheath_{k}", kind, f"{kind}_{k}")
    return spec


def _add_wheel(
    spec: mujoco.MjSpec,
    name: str,
    joint: Joint,
    pos: FloatArray,
    axis: FloatArray,
    arm: FloatArray,
    inertia: float,
) -> mujoco.MjsJoint:
    """A balanced body on a hinge of the same name; turned forward it winds tendon 1 in.

    It is drawn as a wheel with an arm; its mass and inertia [kg m²] do not follow from the drawing.
    """
    body = spec.worldbody.add_body(name=name, pos=pos, explicitinertial=True, mass=0.02)
    body.ipos = [0.0, 0.0, 0.0]
    body.inertia = [inertia, inertia, inertia]
    wheel, capsule = mujoco.mjtGeom.mjGEOM_CYLINDER, mujoco.mjtGeom.mjGEOM_CAPSULE
    for shape, radius, start, end, rgba in (
        (wheel, joint.moment_arm - _TENDON_RADIUS, -0.004 * axis, 0.004 * axis, _STEEL),
        (capsule, 0.6 * joint.moment_arm, 0.0 * arm, _TIP_LENGTH * arm, _TIP),
    ):
        size, ends = [radius, 0.0, 0.0], [*start, *end]
        body.add_geom(type=shape, size=size, fromto=ends, rgba=rgba, contype=0, conaffinity=0)
    return body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=axis)
