"""Independent references of bench and joint: lumped elements with effects, MuJoCo's hinge."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar, TypeVar

import mujoco
import numpy as np

from experiments.hidden_effects.excitation import RATE, RecordingDescription, Sensor, clock
from experiments.references import Carriage, Effects, simulate_effects, uniform_chain
from tendon_mj.lab.recordings import Measured, Recording, Uncertain
from tendon_mj.lab.replay import replay_recording
from tendon_mj.models import Bench, Joint, build_joint
from tendon_mj.typing import FloatArray

TIME_STEPS = {True: 1.25e-4, False: 5e-4}  # of recordings, of the search for a strength [s]
COLUMNS = ("input_tension_N", "output_tension_N")
ELEMENTS = 24  # the bench has 16 guides: reference and model differ in discretisation
OVERSAMPLING = 4  # simulated instants per sample, so that sensors see changes between samples
SETTLING_TIME = 0.5  # before the recording, with the reel at 0 [s]
# Of the tendon where its mass is no effect [kg]: so light that the integrator damps out all waves.
# At 1e-3, μ_s > μ_d makes single elements chatter, a discretisation error of the order 1/ELEMENTS.
MASS = 1e-5
RETARDATION = 1e-4  # damps the ringing of a tendon whose mass is the effect [s]
TIP_MASS = 0.1  # of the joint's tip [kg]
TIP_ARM = 0.01  # of the tip's centre of mass about the hinge [m]
COARSE_STEP = 1e-3  # of the search for a strength, and of the model [s]
# MuJoCo's errors are of first order in the step, whatever the integrator, where friction remembers.
# Of a recording's, 2.5e-4 s makes a joint's damping seem 0.7 % less, 6.25e-5 s 0.2 % [s].
STEP, SHORT_STEP = 2.5e-4, 6.25e-5
_SHEATHS = ("sheath_1", "sheath_2")


@dataclass(frozen=True, kw_only=True)
class ReferenceBench:
    """Ground truth of a case; the defaults are the parameters of the model `bench`.

    Attributes:
        friction: μ [-]. pretension: T_0 of the tendon as mounted, on carriages whose springs
            balance the bench's own T_0 [N]. axial_stiffness: EA [N]. bend: [rad].
        static_excess: μ_s/μ − 1 [-].
        effects: of the transmission.
        reel_scale: tendon wound in over the displacement in the drive's column [-].
        sensors: column to its sensor; columns not named have an ideal one.
        rate: samples per second.
        thermal_shortening: amplitude [m] and period [s] of a sine by which the tendon shortens, of
            which no column tells.
        recording: number of the one that is simulated. slip: number of the recording in which the
            cable slips on the reel, how much is drawn in [m], when, and how long it takes [s].
    """

    description: ClassVar[RecordingDescription] = RecordingDescription(
        drive="input_displacement_m",
        actuator="reel",
        travel=1.0,
        sensors={c: c.removesuffix("_N") for c in COLUMNS},
        sheaths=("sheath",),
        known={
            "sheath.axial_stiffness": Bench.axial_stiffness,
            "environment.stiffness": Bench.environment_stiffness,
            "sensor.stiffness": Bench.sensor_stiffness,
        },
        uncertain={name: (f"sheath.{name}",) for name in ("friction", "pretension")},
        ranges={"friction": Uncertain(0.15, 0.05, 0.4), "pretension": Uncertain(20.0, 15.0, 25.0)},
        true_ranges={"friction": (0.08, 0.3), "pretension": (16.5, 23.5)},
    )

    friction: float = Bench.friction
    pretension: float = Bench.pretension
    axial_stiffness: float = Bench.axial_stiffness
    bend: float = Bench.bend
    static_excess: float = 0.0
    effects: Effects = field(default_factory=Effects)
    reel_scale: float = 1.0
    sensors: Mapping[str, Sensor] = field(default_factory=dict)
    rate: float = RATE
    thermal_shortening: tuple[float, float] = (0.0, 1.0)
    recording: int = 0
    slip: tuple[int, float, float, float] = (-1, 0.0, 0.0, 1.0)

    def simulate(self, drives: Sequence[FloatArray], fine: bool = True) -> list[FloatArray]:
        """Readings without noise, (2, samples) [N] of each drive [m]."""
        return [self._simulate(drive, TIME_STEPS[fine]) for drive in drives]

    def write_model(self, _: Path) -> str:
        """Return the name by which recordings refer to the model: `bench` of the package."""
        return "bench"

    def _simulate(self, drive: FloatArray, time_step: float) -> FloatArray:
        bench, sparse = Bench(), np.arange(len(drive)) / self.rate
        dense = np.linspace(0.0, sparse[-1], OVERSAMPLING * (len(sparse) - 1) + 1)
        wound = self.reel_scale * np.interp(dense, sparse, drive)
        amplitude, period = self.thermal_shortening
        wound += amplitude * np.sin(2.0 * np.pi * dense / period)
        turned, (slipping, drawn_in, since, duration) = wound.copy(), self.slip
        if slipping == self.recording:  # faster and faster, and then at once held again
            wound += drawn_in * np.clip((dense - since) / duration, 0.0, 1.0) ** 2
        lead = np.arange(-SETTLING_TIME, 0.0, dense[1])
        chain = uniform_chain(
            ELEMENTS,
            length=bench.length,
            bend_angle=self.bend,
            axial_stiffness=self.axial_stiffness,
            pretension=self.pretension,
            static_friction=self.friction * (1.0 + self.static_excess),
            dynamic_friction=self.friction,
            mass=MASS,
        )
        run = simulate_effects(
            chain,
            self._all_effects(),
            np.concatenate([lead, dense]),
            np.concatenate([np.zeros_like(lead), wound]),
            carriages=_carriages(),
            preload=bench.pretension,
            time_step=time_step,
        )
        after = slice(len(lead), None)
        tensions = dict(
            zip(COLUMNS, (run.input_tension[after], run.output_tension[after]), strict=True)
        )
        return np.array(
            [
                self.sensors.get(name, Sensor()).read(dense, tension, turned)[::OVERSAMPLING]
                for name, tension in tensions.items()
            ]
        )

    def _all_effects(self) -> Effects:
        """The hidden effects, with the parameters that `Effects` shares with the chain."""
        given = dict(vars(self.effects))
        given["axial_stiffness"] = self.axial_stiffness
        given["retardation_time"] = RETARDATION if self.effects.tendon_mass > 0.0 else 0.0
        return Effects(**given)


def _carriages() -> tuple[Carriage, ...]:
    """Sensor and environment of the bench, each critically damped on its own spring."""
    bench = Bench()
    return tuple(
        Carriage(mass=bench.mass, stiffness=k, damping=2.0 * math.sqrt(k * bench.mass))
        for k in (bench.sensor_stiffness, bench.environment_stiffness)
    )


@dataclass(frozen=True, kw_only=True)
class ReferenceJoint:
    """Ground truth of a case; the defaults are the parameters of the model `joint`.

    Attributes:
        friction: μ of both tendons [-]. pretension: T_0 of both [N].
        axial_stiffness: EA of both [N].
        damping: [N m s/rad], dry_friction: [N m], stiffness: [N m/rad] of the hinge.
        gravity: downward, across the hinge [m/s²]; the model has none.
        bend: of the sheath [rad].
        step: of a recording's simulation [s].
    """

    description: ClassVar[RecordingDescription] = RecordingDescription(
        drive="command_rad",
        actuator="command",
        travel=600.0,
        sensors={
            "joint_rad": "joint_angle",
            "tension_1_N": "input_tension_1",
            "tension_2_N": "input_tension_2",
        },
        sheaths=_SHEATHS,
        known={f"{s}.axial_stiffness": Joint.axial_stiffness for s in _SHEATHS},
        uncertain={
            name: tuple(f"{s}.{name}" for s in _SHEATHS) for name in ("friction", "pretension")
        },
        ranges={"friction": Uncertain(0.19, 0.05, 0.4), "pretension": Uncertain(5.0, 3.5, 6.5)},
        true_ranges={"friction": (0.1, 0.3), "pretension": (4.2, 6.0)},
    )

    friction: float = Joint.friction
    pretension: float = Joint.pretension
    axial_stiffness: float = Joint.axial_stiffness
    rate: ClassVar[float] = RATE
    damping: float = Joint.damping
    dry_friction: float = 0.0
    stiffness: float = Joint.stiffness
    gravity: float = 0.0
    bend: float = Joint.bend
    step: float = STEP

    def simulate(self, drives: Sequence[FloatArray], fine: bool = True) -> list[FloatArray]:
        """Readings without noise, (3, samples) of each drive [rad]."""
        spec = self.spec(self.step if fine else COARSE_STEP)
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICIT
        model = spec.compile()
        return [self._simulate(model, drive) for drive in drives]

    def spec(self, step: float) -> mujoco.MjSpec:
        """The joint with these parameters; the centre of mass of its tip is off the hinge."""
        spec = build_joint(
            Joint(
                bend=self.bend,
                friction=self.friction,
                pretension=self.pretension,
                axial_stiffness=self.axial_stiffness,
                damping=self.damping,
                stiffness=self.stiffness,
                timestep=step,
            )
        )
        spec.joint("joint").frictionloss = self.dry_friction
        spec.option.gravity = [0.0, 0.0, -self.gravity]
        arm = np.cross(spec.joint("joint").axis, [0.0, 0.0, 1.0])
        body = spec.body("joint")
        body.mass = TIP_MASS
        body.ipos = TIP_ARM * arm / np.linalg.norm(arm)
        return spec

    def write_model(self, folder: Path) -> str:
        """Write the model with the default parameters; return its path, for the recordings."""
        path = folder.resolve() / "tipped_joint.xml"
        path.write_text(ReferenceJoint().spec(Joint.timestep).to_xml(), encoding="utf-8")
        return str(path)

    def _simulate(self, model: mujoco.MjModel, drive: FloatArray) -> FloatArray:
        stated = self.description
        recording = Recording(
            name="truth",
            model="joint",
            source="drive",
            time=clock()[: len(drive)],
            columns={stated.drive: drive, **{c: np.zeros_like(drive) for c in stated.sensors}},
            drive={stated.drive: stated.actuator},
            measured={c: Measured(s) for c, s in stated.sensors.items()},
        )
        simulated = replay_recording(recording, model)
        return np.array([simulated.columns[c] for c in stated.sensors])


R = TypeVar("R", ReferenceBench, ReferenceJoint)
