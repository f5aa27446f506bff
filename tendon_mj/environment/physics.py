"""dm_control's physics of the finger, with the sheaths' parameters and the sensors by name."""

from __future__ import annotations

import mujoco
import numpy as np
from dm_control.mujoco import Physics, wrapper
from numpy.typing import NDArray

from tendon_mj.attach import Parameters
from tendon_mj.builders.finger import build_finger
from tendon_mj.builders.finger_parameters import TENDONS, Finger
from tendon_mj.finger.control import OUT_OF_REACH

Array = NDArray[np.float64]
LIVE = ("friction", "pretension", "axial_stiffness")  # of a sheath, without another model


class FingerPhysics(Physics):  # type: ignore[misc]  # dm_control is not typed
    """The finger between dm_control's `MjModel` and `MjData`.

    All state of the sheaths is in `plugin_state`, which dm_control's resets, copies and pickles
    carry along.
    """

    @classmethod
    def of(cls, finger: Finger) -> FingerPhysics:
        """Physics of a finger with these numbers."""
        physics: FingerPhysics = cls.from_model(wrapper.MjModel(build_finger(finger).compile()))
        return physics

    def rebuild(self, finger: Finger) -> None:
        """Exchange the model for that of a finger with other numbers; the state starts anew."""
        self._reload_from_model(wrapper.MjModel(build_finger(finger).compile()))

    def start(self, finger: Finger) -> None:
        """Begin an episode with a finger's friction, pretension and axial stiffness, all live.

        A tendon is laid at the first evaluation after a reset, and dm_control has evaluated once
        by then; so the data is reset again and takes the parameters before its next evaluation.
        The joints' springs stay the model's, the motors hold the pretension that is given.
        """
        mujoco.mj_resetData(self.model.ptr, self.data.ptr)
        parameters = Parameters(self.model.ptr, self.data.ptr)
        strain = finger.pretension / finger.axial_stiffness
        torque = finger.spool_radius * finger.pretension * (1.0 + 0.5 * strain)
        for tendon in TENDONS:
            for name in LIVE:
                parameters[f"{tendon}_sheath.{name}"] = getattr(finger, name)
            self.model.ptr.actuator(f"{tendon}_angle").biasprm[0] = torque

    def move_object_away(self) -> None:
        """Put the object out of the finger's reach, as long as this model lasts."""
        place = self.model.ptr.joint("object").qposadr[0]
        self.model.ptr.qpos_spring[place] = OUT_OF_REACH
        self.data.ptr.qpos[place] = OUT_OF_REACH

    def sensor(self, name: str) -> float:
        """Reading of a sensor of one number [its unit]."""
        return float(self.data.ptr.sensor(name).data[0])

    def command(self, angles: Array) -> None:
        """Command the angles of the spools [rad], flexor and extensor; the torque motors rest."""
        control = np.zeros(self.model.nu)
        for tendon, angle in zip(TENDONS, angles, strict=True):
            control[self.model.ptr.actuator(f"{tendon}_angle").id] = angle
        self.set_control(control)

    def command_range(self) -> tuple[Array, Array]:
        """Lowest and highest angle of each spool [rad]."""
        rows = [self.model.ptr.actuator(f"{tendon}_angle").ctrlrange for tendon in TENDONS]
        low, high = np.array(rows).T
        return low, high
