"""dm_control's physics of the finger."""

from __future__ import annotations

import mujoco
from dm_control.mujoco import Physics, wrapper

from tendon_mj.envs.simulated_finger import SimulatedFinger
from tendon_mj.models import Finger, build_finger


class FingerPhysics(SimulatedFinger, Physics):  # type: ignore[misc]  # dm_control is not typed
    """The finger between dm_control's `MjModel` and `MjData`.

    All state of the sheaths is in `plugin_state`, which dm_control's resets, copies and pickles
    carry along.
    """

    @classmethod
    def of(cls, finger: Finger) -> FingerPhysics:
        """Physics of a finger with these numbers."""
        physics: FingerPhysics = cls.from_model(wrapper.MjModel(build_finger(finger).compile()))
        return physics

    @property
    def native(self) -> tuple[mujoco.MjModel, mujoco.MjData]:
        """MuJoCo's own model and data."""
        return self.model.ptr, self.data.ptr

    def rebuild(self, finger: Finger) -> None:
        """Exchange the model for that of a finger with other numbers; the state starts anew."""
        self._reload_from_model(wrapper.MjModel(build_finger(finger).compile()))
