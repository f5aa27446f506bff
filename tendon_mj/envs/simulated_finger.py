"""What a task does with a simulated finger: begin an episode, command the motors, read sensors."""

from __future__ import annotations

from abc import ABC, abstractmethod

import mujoco
import numpy as np

from tendon_mj.attach import Parameters
from tendon_mj.lab.finger import OUT_OF_REACH
from tendon_mj.models import TENDONS, Finger
from tendon_mj.typing import FloatArray

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
        """Exchange the model for that of a finger with other numbers; the state starts anew."""

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
