"""Bench with a motor: a spool in place of the reel, and a servo for the output tension.

The motor stands for a DC servo motor with a gear of high reduction, J_m its inertia as seen at the
spool. The references T_r are absolute tensions; the paper's are measured from the pretension.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from tendon_mj import add_servo
from tendon_mj.errors import TendonError
from tendon_mj.lab.replay import full_state, rollout_sensors
from tendon_mj.models import Bench, build_bench
from tendon_mj.typing import FloatArray


@dataclass(frozen=True, kw_only=True)
class Servo:
    """Motor and its servo; None takes the default of `tendon_mj.add_servo`.

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
class ServoResponse:
    """Motion and tensions of the bench under a servo, a value per time step.

    Attributes:
        time: [s].
        reference, output_tension, input_tension: T_r, T_out, T_in [N].
        angle, speed: θ [rad] and θ̇ [rad/s] of the motor.
    """

    time: FloatArray
    reference: FloatArray
    output_tension: FloatArray
    input_tension: FloatArray
    angle: FloatArray
    speed: FloatArray

    def part(self, begin: float, end: float) -> ServoResponse:
        """Response from ``begin`` to ``end`` [s]."""
        first, last = np.searchsorted(self.time, [begin, end])
        return ServoResponse(
            *(getattr(self, name)[first:last] for name in self.__dataclass_fields__)
        )


def build_servo_bench(bench: Bench, servo: Servo) -> mujoco.MjSpec:
    """Build the bench with joint `motor`, which winds the tendon in, and actuator `servo` on it."""
    spec = build_bench(bench, reel_joint="motor", reel_radius=servo.radius)
    spool, joint = spec.body("motor"), spec.joint("motor")
    joint.armature = servo.inertia
    # MuJoCo requires mass in a body that moves; the inertia is the armature
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


def run_servo(
    bench: Bench, servo: Servo, reference: ArrayLike, speed: float = 0.0
) -> ServoResponse:
    """Simulate the output tension following ``reference``, the tendon under T_0 at first.

    Args:
        bench, servo: parameters.
        reference: T_r at every time step [N]. Shape (steps,).
        speed: initial one of the motor [rad/s].

    Raises:
        TendonError: the simulation became unstable.
    """
    tension = np.asarray(reference, float)
    model = build_servo_bench(bench, servo).compile()
    data = mujoco.MjData(model)
    data.joint("motor").qvel[0] = speed
    start = full_state(model, data)[None]
    readings = rollout_sensors(model, [data], start, tension[None, :, None])
    if not np.isfinite(readings).all() or data.warning.number.any():
        raise TendonError(f"the simulation of {servo} on {bench} became unstable")
    names = ("output_tension", "input_tension", "motor_angle", "motor_speed")
    columns = [readings[0][:, int(model.sensor(name).adr[0])] for name in names]
    # sensors are read at the beginning of a step
    time: FloatArray = bench.timestep * np.arange(len(tension), dtype=np.float64)
    return ServoResponse(time, tension, *columns)
