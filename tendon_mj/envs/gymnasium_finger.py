"""Environments on the finger for gymnasium, registered as `tendon_mj/HoldForce-v0` and so on."""

from __future__ import annotations

from typing import Any, ClassVar, cast

import gymnasium
import numpy as np

from tendon_mj.envs.picture import Painter
from tendon_mj.envs.ranges import Ranges
from tendon_mj.envs.simulation import FingerSimulation
from tendon_mj.envs.tasks import CONTROL_TIMESTEP, FingerTask, FollowTrajectory, HoldForce
from tendon_mj.errors import InvalidValueError
from tendon_mj.models import TENDONS, Finger
from tendon_mj.show import Image
from tendon_mj.typing import FloatArray

Observation = dict[str, FloatArray]


class FingerEnv(gymnasium.Env[Observation, FloatArray]):
    """A task of the finger as a gymnasium environment; `HoldForceEnv` and `FollowTrajectoryEnv`.

    An observation is a dict of readings, which end at the bounds of `observation_space` as those of
    real sensors do. An action is two numbers between −1 and 1, the spools' angles within their
    ranges. ``info`` says what the episode drew: `friction` [-], `pretension` [N],
    `axial_stiffness` [N], `bend` [rad].

    An episode is never terminated; `gymnasium.make` truncates it after its time limit.

    Args:
        render_mode: None or "rgb_array".
        friction, pretension, axial_stiffness, bend: (low, high) that an episode draws from, see
            `Ranges`.
        finger: its other numbers.
        width, height: of a rendered picture [pixels].

    Raises:
        InvalidValueError: a range that is none, or another render mode.
    """

    metadata: ClassVar[dict[str, Any]] = {  # type: ignore[misc]  # gymnasium has it an instance's
        "render_modes": ["rgb_array"],
        "render_fps": round(1.0 / CONTROL_TIMESTEP),
    }
    task_type: ClassVar[type[FingerTask]]

    def __init__(
        self,
        render_mode: str | None = None,
        *,
        friction: tuple[float, float] = Ranges.friction,
        pretension: tuple[float, float] = Ranges.pretension,
        axial_stiffness: tuple[float, float] = Ranges.axial_stiffness,
        bend: tuple[float, float] = Ranges.bend,
        finger: Finger | None = None,
        width: int = 480,
        height: int = 360,
    ) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise InvalidValueError(f"render_mode = {render_mode!r} must be None or 'rgb_array'")
        ranges = Ranges(
            friction=friction, pretension=pretension, axial_stiffness=axial_stiffness, bend=bend
        )
        self.render_mode = render_mode
        self._size = width, height
        self._painter: Painter | None = None
        self.task = self.task_type(finger or Finger(), ranges, self.np_random)
        self.simulation = FingerSimulation(self.task.finger)
        self._steps = max(1, round(CONTROL_TIMESTEP / self.task.finger.timestep))
        readings = self.task.observation_range(self.simulation)
        boxes = {k: gymnasium.spaces.Box(*ends, dtype=np.float64) for k, ends in readings.items()}
        self.observation_space = cast(
            "gymnasium.Space[Observation]", gymnasium.spaces.Dict(cast(Any, boxes))
        )
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (len(TENDONS),), np.float64)
        self._readings = readings

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode with numbers of its own.

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
        return self._observe(), dict(self.task.drawn)

    def step(self, action: FloatArray) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Hold the motors' commands for 10 ms.

        Returns:
            observation, reward (0 to 1), whether terminated and whether truncated (never here: the
            wrapper of `gymnasium.make` truncates), and what the episode drew.

        Raises:
            InvalidValueError: the action is not two finite numbers.
            TendonError: the simulation became unstable.
        """
        self.task.before_step(action, self.simulation)
        self.simulation.step(self._steps)
        reward = self.task.get_reward(self.simulation)
        return self._observe(), reward, False, False, dict(self.task.drawn)

    def render(self) -> Image | None:
        """(height, width, 3) picture, the tendons coloured by their tension; None without a mode.

        Raises:
            EngineError: no OpenGL is to be had; the message says what to do.
        """
        if self.render_mode is None:
            return None
        model, data = self.simulation.native
        if self._painter is None or self._painter.model is not model:
            self.close()
            self._painter = Painter(model, *self._size)
        return self._painter.draw(data)

    def close(self) -> None:
        """Free what drawing took."""
        if self._painter is not None:
            self._painter.close()
        self._painter = None

    def _observe(self) -> Observation:
        seen = self.task.get_observation(self.simulation)
        return {name: np.clip(seen[name], *self._readings[name]) for name in self._readings}


class HoldForceEnv(FingerEnv):
    """Press the tip on the object and hold a force: `HoldForce` for gymnasium."""

    task_type = HoldForce


class FollowTrajectoryEnv(FingerEnv):
    """Follow a joint trajectory: `FollowTrajectory` for gymnasium."""

    task_type = FollowTrajectory
