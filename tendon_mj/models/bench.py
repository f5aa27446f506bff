"""The bench of the paper's Fig. 1 as a model with every parameter free.

A reel winds the tendon in; it runs through a sheath of uniform bend and pulls, through a sensor
spring k_s, on an environment spring k_e. `models/bench/bench.xml` is this with the defaults.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from tendon_mj.attach import add_friction, add_sites, add_tendon, arc_points
from tendon_mj.errors import InvalidValueError


def check_parameters(
    parameters: Mapping[str, float],
    *,
    may_be_0: Collection[str] = (),
    signed: Collection[str] = (),
    where: str = "",
) -> None:
    """Refuse parameters that are not finite, or not > 0, unless they may be 0 or are signed."""
    for name, value in parameters.items():
        bound = "" if name in signed else " and ≥ 0" if name in may_be_0 else " and > 0"
        in_range = name in signed or value > 0.0 or (name in may_be_0 and value == 0.0)
        if not (np.isfinite(value) and in_range):
            raise InvalidValueError(f"{where}{name} = {value} must be finite{bound}")


@dataclass(frozen=True, kw_only=True)
class Bench:
    """Parameters of the bench; the defaults are those of `models/bench/parameters.toml`."""

    friction: float = 0.15  # μ, static = dynamic [-]
    length: float = 0.5  # of the sheath [m]
    bend: float = np.pi  # total angle that it turns through [rad]
    guides: int = 16  # sites that stand for the sheath
    axial_stiffness: float = 20e3  # EA [N]
    pretension: float = 20.0  # T_0 [N]
    environment_stiffness: float = 10e3  # k_e [N/m]
    sensor_stiffness: float = 40e3  # k_s [N/m]
    mass: float = 1.0  # of the sensor's and of the environment's carriage [kg]
    timestep: float = 0.0005  # [s]

    def __post_init__(self) -> None:
        check_parameters(vars(self), may_be_0=("friction", "pretension"), signed=("bend",))

    @property
    def exponent(self) -> float:
        """|λ| = μ × total bend [-]."""
        return self.friction * self.bend

    @property
    def output_stiffness(self) -> float:
        """k_se = 1/(1/k_e + 1/k_s) [N/m]."""
        return 1.0 / (1.0 / self.environment_stiffness + 1.0 / self.sensor_stiffness)

    def stiffened(self, factor: float) -> Bench:
        """The bench with EA, k_e, k_s and the masses times ``factor``: less strain and travel."""
        return dataclasses.replace(
            self,
            axial_stiffness=self.axial_stiffness * factor,
            environment_stiffness=self.environment_stiffness * factor,
            sensor_stiffness=self.sensor_stiffness * factor,
            mass=self.mass * factor,
        )


def build_bench(
    bench: Bench, *, reel_joint: str | None = None, reel_radius: float | None = None
) -> mujoco.MjSpec:
    """The bench as an editable model: actuator `reel`, sheath `sheath`, four named sensors.

    ``reel_joint`` names a hinge to add, on a body of that name, with a spool of ``reel_radius`` [m]
    that winds the tendon in instead of the actuator.
    """
    spec = mujoco.MjSpec()
    spec.modelname = "bench"
    spec.option.timestep = bench.timestep
    spec.option.gravity = [0.0, 0.0, 0.0]
    points = arc_points(bench.length, bench.bend, bench.guides)
    sites = add_sites(spec, "guide", points[:-1])
    heading = (points[-1] - points[-2]) / np.linalg.norm(points[-1] - points[-2])

    def carriage(parent: mujoco.MjsBody, name: str, stiffness: float) -> mujoco.MjsBody:
        body = parent.add_body(name=name)
        joint = body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=-heading)
        joint.stiffness[0] = stiffness
        joint.springref = -bench.pretension / stiffness
        joint.damping[0] = 2.0 * np.sqrt(stiffness * bench.mass)
        box = mujoco.mjtGeom.mjGEOM_BOX
        body.add_geom(type=box, size=[0.008] * 3, mass=bench.mass, contype=0, conaffinity=0)
        return body

    environment = carriage(spec.worldbody, "environment", bench.environment_stiffness)
    environment.pos = points[-1] + 0.05 * heading
    sensor = carriage(environment, "sensor", bench.sensor_stiffness)
    sensor.pos = -0.05 * heading
    sensor.add_site(name="output")
    add_tendon(spec, "tendon", [*sites, "output"])
    if reel_joint is not None:
        spool = spec.worldbody.add_body(name=reel_joint)
        spool.add_joint(name=reel_joint, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0.0, 0.0, 1.0])
    add_friction(
        spec,
        "tendon",
        name="sheath",
        friction=bench.friction,
        axial_stiffness=bench.axial_stiffness,
        pretension=bench.pretension,
        reel=None if reel_joint else "reel",
        reel_joint=reel_joint,
        reel_radius=reel_radius,
        sensors=("input_tension", "output_tension", "reel_displacement"),
    )
    travel = spec.add_tendon(name="output_displacement")
    travel.wrap_joint("environment", 1.0)
    travel.wrap_joint("sensor", 1.0)
    spec.add_sensor(
        name="output_displacement",
        type=mujoco.mjtSensor.mjSENS_TENDONPOS,
        objtype=mujoco.mjtObj.mjOBJ_TENDON,
        objname="output_displacement",
    )
    return spec
