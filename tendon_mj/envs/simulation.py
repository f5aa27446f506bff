"""The finger as plain MuJoCo model and data, stepped as dm_control steps it."""

from __future__ import annotations

import mujoco

from tendon_mj.envs.picture import add_sky
from tendon_mj.envs.simulated_finger import SimulatedFinger
from tendon_mj.errors import TendonError
from tendon_mj.models import Finger, build_finger

_NO_ACTUATION = mujoco.mjtDisableBit.mjDSBL_ACTUATION.value


class FingerSimulation(SimulatedFinger):
    """A finger's model and data, without dm_control.

    Args:
        finger: its parameters.
    """

    def __init__(self, finger: Finger) -> None:
        self.rebuild(finger)

    @property
    def native(self) -> tuple[mujoco.MjModel, mujoco.MjData]:
        """MuJoCo's own model and data."""
        return self.model, self.data

    def rebuild(self, finger: Finger) -> None:
        """Exchange the model for that of a finger with other numbers; the state starts anew."""
        spec = build_finger(finger)
        add_sky(spec)
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)

    def evaluate(self) -> None:
        """Compute positions, tensions and sensors of a new episode, before any actuation."""
        flags = self.model.opt.disableflags
        self.model.opt.disableflags = flags | _NO_ACTUATION
        mujoco.mj_forward(self.model, self.data)
        self.model.opt.disableflags = flags

    def step(self, count: int) -> None:
        """Advance by ``count`` time steps; positions and velocities are those of the last one.

        Raises:
            TendonError: the simulation became unstable.
        """
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
