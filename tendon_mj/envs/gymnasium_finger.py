"""Environments on the finger for gymnasium, registered as `tendon_mj/HoldForce-v0` and so on."""

from __future__ import annotations

import atexit
import weakref
from typing import Any, ClassVar, cast

import gymnasium
import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.envs import tasks
from tendon_mj.envs.scene import build_scene
from tendon_mj.envs.window import INSTEAD, Window
from tendon_mj.errors import InvalidValueError, TendonError
from tendon_mj.models import TENDONS, Finger
from tendon_mj.show import Image, Offscreen
from tendon_mj.show.live import check_screen
from tendon_mj.typing import FloatArray

_NO_ACTUATION = mujoco.mjtDisableBit.mjDSBL_ACTUATION.value
_Observation = dict[str, NDArray[np.float32]]


class FingerSimulation(tasks.SimulatedFinger):
    """A finger as plain MuJoCo model and data, stepped as dm_control steps it."""

    def __init__(self, finger: Finger) -> None:
        self.rebuild(finger)

    @property
    def native(self) -> tuple[mujoco.MjModel, mujoco.MjData]:
        """MuJoCo's own model and data."""
        return self.model, self.data

    def rebuild(self, finger: Finger) -> None:
        """Replace the model by that of a finger with other numbers; the state is reset."""
        self.model = build_scene(finger)
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


class FingerEnv(gymnasium.Env[_Observation, FloatArray]):
    """A task of the finger as a gymnasium environment; `HoldForceEnv` and `FollowTrajectoryEnv`.

    An observation is a dict of float32 readings, which end at the bounds of `observation_space` as
    those of real sensors do. An action is two numbers between −1 and 1, the spools' angles within
    their ranges. ``info`` has the numbers that the episode drew: `friction` [-], `pretension` [N],
    `axial_stiffness` [N], `bend` [rad].

    An episode is never terminated; `gymnasium.make` truncates it after its time limit.

    Args:
        render_mode: None, "rgb_array" or "human", MuJoCo's viewer, which shows every step in real
            time.
        finger: its numbers that an episode does not draw.
        width, height: of a rendered picture [pixels].
        ranges: ``friction``, ``pretension``, ``axial_stiffness`` and ``bend``, (low, high) that
            an episode draws from, see `Ranges`.

    Raises:
        InvalidValueError: an invalid range, or another render mode.
        EngineError: "human" without a screen.
    """

    metadata: ClassVar[dict[str, Any]] = {  # type: ignore[misc]  # gymnasium has it an instance's
        "render_modes": ["human", "rgb_array"],
        "render_fps": round(1.0 / tasks.CONTROL_TIMESTEP),
    }
    task_type: ClassVar[type[tasks.FingerTask]]

    def __init__(
        self,
        render_mode: str | None = None,
        *,
        finger: Finger | None = None,
        width: int = 480,
        height: int = 360,
        **ranges: tuple[float, float],
    ) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise InvalidValueError(
                f"render_mode = {render_mode!r} must be None, 'human' or 'rgb_array'"
            )
        if render_mode == "human":
            check_screen(INSTEAD)
        self.render_mode = render_mode
        self._size = width, height
        self._view: Offscreen | Window | None = None
        self.task = self.task_type(finger or Finger(), tasks.Ranges(**ranges), self.np_random)
        self.simulation = FingerSimulation(self.task.finger)
        self._steps = max(1, round(tasks.CONTROL_TIMESTEP / self.task.finger.timestep))
        readings = self.task.readings(self.simulation)
        self._boxes = {
            name: gymnasium.spaces.Box(r.low.astype(np.float32), r.high.astype(np.float32))
            for name, r in readings.items()
        }
        self.observation_space = cast(
            "gymnasium.Space[_Observation]", gymnasium.spaces.Dict(cast(Any, self._boxes))
        )
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (len(TENDONS),), np.float64)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[_Observation, dict[str, Any]]:
        """Begin an episode with newly drawn numbers.

        Args:
            seed: of this and all later draws.
            options: there are none.

        Raises:
            InvalidValueError: an option.
        """
        if options:
            raise InvalidValueError(
                f"options = {options!r}: there are none; ranges are given to gymnasium.make"
            )
        super().reset(seed=seed)
        self.task.random = self.np_random
        self.task.initialize_episode(self.simulation)
        self.simulation.evaluate()
        if self.render_mode == "human":
            self.render()
        return self._observe(), dict(self.task.drawn)

    def step(self, action: FloatArray) -> tuple[_Observation, float, bool, bool, dict[str, Any]]:
        """Hold the motors' commands for 10 ms.

        Returns:
            observation, reward (0 to 1), whether terminated and whether truncated (never here: the
            wrapper of `gymnasium.make` truncates), and the numbers that the episode drew.

        Raises:
            InvalidValueError: the action is not two finite numbers.
            TendonError: the simulation became unstable.
        """
        self.task.before_step(action, self.simulation)
        self.simulation.step(self._steps)
        reward = self.task.get_reward(self.simulation)
        if self.render_mode == "human":
            self.render()
        return self._observe(), reward, False, False, dict(self.task.drawn)

    def render(self) -> Image | None:
        """(height, width, 3) picture of "rgb_array": the target, and tendons coloured by tension.

        Without a mode, and with "human", whose window `reset` and `step` draw, there is none.

        Raises:
            EngineError: no OpenGL is available; the message says what to do.
        """
        if self.render_mode is None:
            return None
        model, data = self.simulation.native
        if self._view is None:
            human = self.render_mode == "human"
            self._view = Window(model) if human else Offscreen(model, *self._size)
            _free_at_exit(self)

        def add(scene: mujoco.MjvScene) -> None:
            self.task.draw_target(self.simulation, scene)

        if isinstance(self._view, Window):
            self._view.show(model, data, add)
            return None
        camera = mujoco.MjvCamera()  # of which `build_scene` sets the view
        mujoco.mjv_defaultFreeCamera(model, camera)
        return self._view.draw(data, camera, add, model=model)

    def close(self) -> None:
        """Free the graphics memory, or close the window."""
        if self._view is not None:
            self._view.close()
        self._view = None

    def _observe(self) -> _Observation:
        readings = self.task.readings(self.simulation)
        return {
            name: np.clip(readings[name].value.astype(np.float32), box.low, box.high)
            for name, box in self._boxes.items()
        }


def _free_at_exit(environment: FingerEnv) -> None:
    """Close an environment at the interpreter's exit, while OpenGL still works."""
    reference = weakref.ref(environment)

    def close() -> None:
        kept = reference()
        if kept is not None:
            kept.close()

    atexit.register(close)


class HoldForceEnv(FingerEnv):
    """Press the tip on the object and hold a force: `HoldForce` for gymnasium."""

    task_type = tasks.HoldForce


class FollowTrajectoryEnv(FingerEnv):
    """Follow a joint trajectory: `FollowTrajectory` for gymnasium."""

    task_type = tasks.FollowTrajectory
