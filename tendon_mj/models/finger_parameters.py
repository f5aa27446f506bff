"""Parameters and geometry of a finger driven through sheaths.

Three joints, a flexor and an extensor, each from a motor's spool through a sheath that bends in the
forearm and back at the wrist, along the palm and over guides on the phalanges. `build_finger` makes
the model; `models/finger/finger.xml` is the one with the defaults.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.attach import arc_points
from tendon_mj.errors import InvalidValueError
from tendon_mj.models.bench import check_parameters
from tendon_mj.typing import FloatArray

JOINTS = ("mcp", "pip", "dip")
TENDONS = ("flexor", "extensor")
FORWARD, UP = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
FLEXION = np.array([0.0, 1.0, 0.0])  # turned about it, a finger along +x goes down
SIDE = {"flexor": -1.0, "extensor": 1.0}  # of the finger where the tendon is, up being the back
_MAY_BE_0 = ("friction", "pretension", "stiffness", "damping", "armature", "bend")
_OBJECT_POSE = ("object_x", "object_z", "object_angle")


@dataclass(frozen=True, kw_only=True)
class FingerJoint:
    """A joint of the finger and the phalanx after it.

    Attributes:
        length: of the phalanx [m].
        radius: of the phalanx with its soft tissue [m].
        mass: of the phalanx [kg].
        low, high: range of the joint, flexion positive [rad].
        stiffness, damping: passive [N m/rad], [N m s/rad].
        armature: inertia of the joint besides the phalanges' [kg m²].
        flexor_offset: of the guides, to the palm's side of the joint's axis [m].
        flexor_before, flexor_after: along the finger, from the guide to the axis and on to the
            next guide [m].
        extensor_offset: of the guides, to the back of the axis [m].
        extensor_reach: along the finger, from the axis to the guide on either side [m].
    """

    length: float
    radius: float
    mass: float
    low: float
    high: float
    stiffness: float
    damping: float
    armature: float
    flexor_offset: float
    flexor_before: float
    flexor_after: float
    extensor_offset: float
    extensor_reach: float

    def __post_init__(self) -> None:
        check_parameters(vars(self), may_be_0=_MAY_BE_0, signed=("low",), where="joint: ")
        if self.high <= self.low:
            raise InvalidValueError(f"joint: low = {self.low} must be below high = {self.high}")

    def guides(self, tendon: str) -> tuple[FloatArray, FloatArray]:
        """The guide before the axis and the one after it, from the axis, at angle 0 [m]."""
        if tendon == "flexor":
            before, after, offset = self.flexor_before, self.flexor_after, self.flexor_offset
        else:
            before = after = self.extensor_reach
            offset = self.extensor_offset
        side = SIDE[tendon] * offset * UP
        return side - before * FORWARD, side + after * FORWARD

    def span(self, tendon: str, angle: ArrayLike) -> FloatArray:
        """Length of tendon between the joint's two guides at angles [rad], in their shape [m]."""
        before, after = self.guides(tendon)
        q = np.asarray(angle, float)
        x = np.cos(q) * after[0] + np.sin(q) * after[2]
        z = np.cos(q) * after[2] - np.sin(q) * after[0]
        length: FloatArray = np.hypot(x - before[0], z - before[2])
        return length


# by each joint: MCP, PIP, DIP
_DEFAULTS = {
    "length": (0.0398, 0.0224, 0.0196),
    "radius": (0.009, 0.0083, 0.007),
    "mass": (0.011, 0.0053, 0.003),
    "low": (np.radians(-10.0), np.radians(-5.0), np.radians(-5.0)),
    "high": (np.radians(90.0), np.radians(100.0), np.radians(80.0)),
    "stiffness": (0.12, 0.1, 0.05),
    "damping": (0.004, 0.003, 0.0015),
    "armature": (2e-5, 1.5e-5, 1e-5),
    "flexor_offset": (0.007, 0.0055, 0.003),
    "flexor_before": (0.018, 0.015, 0.008),
    "flexor_after": (0.013, 0.009, 0.007),
    "extensor_offset": (0.0095, 0.004, 0.0028),
    "extensor_reach": (0.0045, 0.002, 0.0016),
}
_MCP, _PIP, _DIP = (
    FingerJoint(**{name: values[k] for name, values in _DEFAULTS.items()}) for k in range(3)
)


@dataclass(frozen=True, kw_only=True)
class Finger:
    """Parameters of the finger; the defaults are those of `models/finger/parameters.toml`.

    Attributes:
        mcp, pip, dip: the joints and the phalanges after them.
        friction: μ of both tendons, static = dynamic [-].
        axial_stiffness: EA of each tendon [N].
        pretension: T_0 of each tendon in the reference pose, the finger straight [N].
        bend: of each sheath [rad], half of it in the forearm and half of it back at the wrist.
        forearm_length, wrist_length: of sheath [m].
        forearm_guides, wrist_guides: sites that stand for each part of the sheath.
        palm_length: from the wrist to the MCP's axis [m].
        free_length: from the spool to the sheath [m].
        spool_radius: r [m].
        rotor_inertia: of each motor [kg m²].
        gear: turns of the rotor per turn of the spool.
        motor_damping: seen at the spool [N m s/rad].
        servo_stiffness: of the motors' position control, at the spool [N m/rad].
        servo_damping: of that control [N m s/rad].
        servo_margin: by which its range exceeds that of the joints [rad].
        motor_torque: most that a rotor gives [N m].
        object_stiffness: k_e of the object's spring [N/m].
        object_mass: [kg].
        object_angle: below the finger's straight line, in which the object is pressed [rad].
        object_x, object_z: position of the middle of the object's face, from the MCP's axis [m].
        timestep: [s].

    Raises:
        InvalidValueError: a parameter that is not finite, or not positive where it must be.
    """

    mcp: FingerJoint = _MCP
    pip: FingerJoint = _PIP
    dip: FingerJoint = _DIP
    friction: float = 0.15
    axial_stiffness: float = 2000.0
    pretension: float = 4.0
    bend: float = np.pi * 2.0 / 3.0
    forearm_length: float = 0.14
    wrist_length: float = 0.06
    forearm_guides: int = 3
    wrist_guides: int = 3
    palm_length: float = 0.0681
    free_length: float = 0.03
    spool_radius: float = 0.008
    rotor_inertia: float = 5e-7
    gear: float = 30.0
    motor_damping: float = 0.01
    servo_stiffness: float = 50.0
    servo_damping: float = 0.3
    servo_margin: float = 1.0
    motor_torque: float = 0.03
    object_stiffness: float = 2000.0
    object_mass: float = 0.05
    object_x: float = 0.033
    object_z: float = -0.048
    object_angle: float = -np.pi / 12.0
    timestep: float = 0.001

    def __post_init__(self) -> None:
        numbers = {name: value for name, value in vars(self).items() if name not in JOINTS}
        check_parameters(numbers, may_be_0=_MAY_BE_0, signed=_OBJECT_POSE)

    @property
    def joints(self) -> dict[str, FingerJoint]:
        """The joints by name, from the palm outwards."""
        return {name: getattr(self, name) for name in JOINTS}


def sheath_points(finger: Finger, tendon: str) -> FloatArray:
    """Points of the tendon from the spool over the guides of forearm and wrist, (k, 3) [m].

    From the last of them it runs straight along the palm to the finger.
    """
    half = 0.5 * finger.bend
    forearm = arc_points(finger.forearm_length, half, finger.forearm_guides, normal=-FLEXION)
    heading = np.cos(half) * FORWARD + np.sin(half) * UP
    wrist = arc_points(
        finger.wrist_length, -half, finger.wrist_guides, forearm[-1], heading, -FLEXION
    )
    path = np.vstack([-finger.free_length * FORWARD, forearm[1:-1], wrist[1:-1]])
    side = finger.mcp.guides(tendon)[0][2] * UP
    shifted: FloatArray = path - wrist[-1] - finger.palm_length * FORWARD + side
    return shifted


def spool_angles(finger: Finger, angles: ArrayLike) -> dict[str, FloatArray]:
    """Angles that the spools must turn by for joint angles, friction and stretch neglected.

    θ = −ΔL(q)/r, positive where tendon is wound in: (…) for (…, 3) of MCP, PIP, DIP [rad].
    """
    q = np.asarray(angles, float)
    turned = {}
    for tendon in TENDONS:
        longer = np.zeros(q.shape[:-1])
        for k, joint in enumerate(finger.joints.values()):
            longer = longer + joint.span(tendon, q[..., k]) - joint.span(tendon, 0.0)
        turned[tendon] = -longer / finger.spool_radius
    return turned
