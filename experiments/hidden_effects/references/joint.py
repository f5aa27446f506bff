"""Reference of the antagonistic joint: MuJoCo's hinge, at another time step and integrator."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import mujoco
import numpy as np

from experiments.hidden_effects.references.excitation import RATE, clock
from experiments.hidden_effects.references.recording_description import RecordingDescription
from tendon_mj.lab.recordings import Measured, Recording, Uncertain
from tendon_mj.lab.replay import replay_recording
from tendon_mj.models import Joint, build_joint
from tendon_mj.typing import FloatArray

MASS, ARM = 0.1, 0.01  # of the tip, and of its centre of mass about the hinge [kg], [m]
COARSE_STEP = 1e-3  # of the search for a strength, and of the model [s]
# MuJoCo's errors are of first order in the step, whatever the integrator, where friction remembers.
# Of a recording's, 2.5e-4 s makes a joint's damping seem 0.7 % less, 6.25e-5 s 0.2 % [s].
STEP, SHORT_STEP = 2.5e-4, 6.25e-5
_SHEATHS = ("sheath_1", "sheath_2")


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
        body.mass = MASS
        body.ipos = ARM * arm / np.linalg.norm(arm)
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
