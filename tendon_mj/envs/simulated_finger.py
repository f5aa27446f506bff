"""A finger in a simulation: begins an episode, commands the motors, reads the sensors."""

from __future__ import annotations

from abc import ABC, abstractmethod

import mujoco
import numpy as np

from tendon_mj.attach import Parameters
from tendon_mj.errors import TendonError
from tendon_mj.lab.finger import OUT_OF_REACH
from tendon_mj.models import TENDONS, Finger, build_finger
from tendon_mj.typing import FloatArray

_NO_ACTUATION = mujoco.mjtDisableBit.mjDSBL_ACTUATION.value
LIVE = ("friction", "pretension", "axial_stiffness")  # of a sheath, without another model


class SimulatedFinger(ABC):
    """A finger in a simulation, with the sheaths' parameters and the sensors by name.

    All state of the sheaths is in `MjData.plugin_state`, which resets and copies carry along.
    """

    @property
    @abstractmethod
    def native(self) -> tuple[mujoco.MjModel, mujoco.MjData]:
        """MuJoCo's own model and data."""

    @abstractmethod
    def rebuild(self, finger: Finger) -> None:
        """Replace the model by that of a finger with other numbers; the state is reset."""

    def start(self, finger: Finger) -> None:
        """Begin an episode with a finger's friction, pretension and axial stiffness, all live.

        A tendon is laid at the first evaluation after a reset, and dm_control has evaluated once
        by then; so the data is reset again and takes the parameters before its next evaluation.
        The joints' springs stay the model's, the motors hold the pretension that is given.
        """
        model, data = self.native
        mujoco.mj_resetData(model, data)
        parameters = Parameters(model, data)
        strain = finger.pretension / finger.axial_stiffness
        torque = finger.spool_radius * finger.pretension * (1.0 + 0.5 * strain)
        for tendon in TENDONS:
            for name in LIVE:
                parameters[f"{tendon}_sheath.{name}"] = getattr(finger, name)
            model.actuator(f"{tendon}_angle").biasprm[0] = torque

    def move_object_away(self) -> None:
        """Put the object out of the finger's reach, as long as this model lasts."""
        model, data = self.native
        place = model.joint("object").qposadr[0]
        model.qpos_spring[place] = OUT_OF_REACH
        data.qpos[place] = OUT_OF_REACH

    def time(self) -> float:
        """Time since the episode began [s]."""
        return float(self.native[1].time)

    def sensor(self, name: str) -> float:
        """Reading of a sensor of one number [its unit]."""
        return float(self.native[1].sensor(name).data[0])

    def command(self, angles: FloatArray) -> None:
        """Command the angles of the spools [rad], flexor and extensor; the torque motors rest."""
        model, data = self.native
        data.ctrl[:] = 0.0
        for tendon, angle in zip(TENDONS, angles, strict=True):
            data.ctrl[model.actuator(f"{tendon}_angle").id] = angle

    def command_range(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest angle of each spool [rad]."""
        model, _ = self.native
        rows = [model.actuator(f"{tendon}_angle").ctrlrange for tendon in TENDONS]
        low, high = np.array(rows).T
        return low, high


class FingerSimulation(SimulatedFinger):
    """A finger as plain MuJoCo model and data, stepped as dm_control steps it."""

    def __init__(self, finger: Finger) -> None:
        self.rebuild(finger)

    @property
    def native(self) -> tuple[mujoco.MjModel, mujoco.MjData]:
        """MuJoCo's own model and data."""
        return self.model, self.data

    def rebuild(self, finger: Finger) -> None:
        """Replace the model by that of a finger with other numbers; the state is reset."""
        spec = build_finger(finger)
        white = [1.0, 1.0, 1.0]  # a sky before which translucent skin is seen
        kind, flat = mujoco.mjtTexture.mjTEXTURE_SKYBOX, mujoco.mjtBuiltin.mjBUILTIN_FLAT
        spec.add_texture(
            name="sky", type=kind, builtin=flat, rgb1=white, rgb2=white, width=8, height=8
        )
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)

    def evaluate(self) -> None:
        """Compute positions, tensions and sensors of a new episode, before any actuation."""
        flags = self.model.opt.disableflags
        self.model.opt.disableflags = flags | _NO_ACTUATION
        mujoco.mj_forward(self.model, self.data)
        self.model.opt.disableflags = flags

    def step(self, count: int) -> None:
        """Advance by ``count`` time steps; positions and velocities are those of the last one."""
        mujoco.mj_step2(self.model, self.data)
        if count > 1:
            mujoco.mj_step(self.model, self.data, count - 1)
        mujoco.mj_step1(self.model, self.data)
        for kind, warning in zip(mujoco.mjtWarning.__members__, self.data.warning, strict=False):
            if warning.number:
                raise TendonError(
                    f"the simulation became unstable before {self.data.time:.3g} s "
                    f"({kind.removeprefix('mjWARN_')}): take a shorter time step, "
                    "finger=Finger(timestep=…), or a lower axial_stiffness"
                )
