"""The bench with a motor: a spool in place of the reel, a servo that holds the output tension.

The motor stands for a DC servo motor with a gear of high reduction, J_m its inertia as seen at the
spool. The references T_r are absolute tensions; the paper's are measured from the pretension.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.attach import add_servo
from tendon_mj.builders.bench import Bench, build_bench
from tendon_mj.errors import TendonError
from tendon_mj.replay.rollout import Array, full_state, rollout_sensors


@dataclass(frozen=True, kw_only=True)
class Servo:
    """A motor and its servo; see `tendon_mj.add_servo` for what is None.

    Attributes:
        inertia: J_m [kg m²].
        radius: r of the spool [m].
        tension_gain: G_t [-].
        velocity_gain: G_v [N m s/rad].
    """

    inertia: float = 0.1
    radius: float = 0.01
    tension_gain: float = 7.0
    velocity_gain: float = 2.0
    loosening_tension_gain: float | None = None
    loosening_velocity_gain: float | None = None
    feedback: str = "sensor"
    observer_friction: float | None = None
    output_stiffness: float | None = None
    backlash_feedforward: float | None = None
    rate_feedforward: float | None = None


@dataclass(frozen=True)
class Response:
    """What the bench did under a servo, a value per step.

    Attributes:
        time: [s].
        reference, output_tension, input_tension: T_r, T_out, T_in [N].
        angle, speed: θ [rad] and θ̇ [rad/s] of the motor.
    """

    time: Array
    reference: Array
    output_tension: Array
    input_tension: Array
    angle: Array
    speed: Array

    def part(self, begin: float, end: float) -> Response:
        """What happened from ``begin`` to ``end`` [s]."""
        first, last = np.searchsorted(self.time, [begin, end])
        return Response(*(getattr(self, name)[first:last] for name in self.__dataclass_fields__))


def build_servo_bench(bench: Bench, servo: Servo) -> mujoco.MjSpec:
    """The bench with joint `motor` that winds the tendon in, and actuator `servo` on it."""
    spec = build_bench(bench, reel_joint="motor", reel_radius=servo.radius)
    spool, joint = spec.body("motor"), spec.joint("motor")
    joint.armature = servo.inertia
    # MuJoCo wants mass in a body that moves; what turns is the armature
    spool.add_geom(size=[servo.radius, 0.0, 0.0], mass=1e-6, contype=0, conaffinity=0)
    add_servo(
        spec,
        "tendon",
        tension_gain=servo.tension_gain,
        velocity_gain=servo.velocity_gain,
        loosening_tension_gain=servo.loosening_tension_gain,
        loosening_velocity_gain=servo.loosening_velocity_gain,
        feedback=servo.feedback,
        observer_friction=servo.observer_friction,
        output_stiffness=servo.output_stiffness,
        backlash_feedforward=servo.backlash_feedforward,
        rate_feedforward=servo.rate_feedforward,
    )
    for kind, name in (
        (mujoco.mjtSensor.mjSENS_JOINTPOS, "motor_angle"),
        (mujoco.mjtSensor.mjSENS_JOINTVEL, "motor_speed"),
    ):
        spec.add_sensor(name=name, type=kind, objtype=mujoco.mjtObj.mjOBJ_JOINT, objname="motor")
    return spec


def run_servo(bench: Bench, servo: Servo, reference: ArrayLike, speed: float = 0.0) -> Response:
    """Let the output tension follow ``reference`` [N], a value per time step, from rest under T_0.

    Args:
        bench, servo: what follows.
        reference: (steps,) T_r [N].
        speed: that the motor starts with [rad/s].

    Raises:
        TendonError: the simulation failed.
    """
    wanted = np.asarray(reference, float)
    model = build_servo_bench(bench, servo).compile()
    data = mujoco.MjData(model)
    data.joint("motor").qvel[0] = speed
    start = full_state(model, data)[None]
    shown = rollout_sensors(model, [data], start, wanted[None, :, None])
    if not np.isfinite(shown).all() or data.warning.number.any():
        raise TendonError(f"the simulation of {servo} on {bench} became unstable")
    names = ("output_tension", "input_tension", "motor_angle", "motor_speed")
    columns = [shown[0][:, int(model.sensor(name).adr[0])] for name in names]
    # the sensors show where the step began
    time: Array = bench.timestep * np.arange(len(wanted), dtype=np.float64)
    return Response(time, wanted, *columns)
