"""Environments on the finger for gymnasium, registered as `tendon_mj/HoldForce-v0` and so on."""

from __future__ import annotations

from typing import Any, ClassVar, cast

import gymnasium
import mujoco
import numpy as np
from matplotlib.colors import Normalize

from tendon_mj.envs import tasks
from tendon_mj.errors import InvalidValueError, TendonError
from tendon_mj.models import TENDONS, Finger, build_finger
from tendon_mj.plugin import segment_tensions, sheaths
from tendon_mj.show import Image, Offscreen, add_cable, without_tendons
from tendon_mj.typing import FloatArray

_TENSION_SCALE = Normalize(0.0, 30.0)  # of the colours [N]
_RADIUS = 0.0009  # of a tendon as drawn [m]
_CENTRE, _DISTANCE = (-0.01, 0.0, -0.03), 0.22  # that the camera looks at, and from [m]
_AZIMUTH, _ELEVATION = 90.0, -8.0  # of the camera [deg]
_NO_ACTUATION = mujoco.mjtDisableBit.mjDSBL_ACTUATION.value
_Observation = dict[str, FloatArray]


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


class FingerEnv(gymnasium.Env[_Observation, FloatArray]):
    """A task of the finger as a gymnasium environment; `HoldForceEnv` and `FollowTrajectoryEnv`.

    An observation is a dict of readings, which end at the bounds of `observation_space` as those of
    real sensors do. An action is two numbers between −1 and 1, the spools' angles within their
    ranges. ``info`` has the numbers that the episode drew: `friction` [-], `pretension` [N],
    `axial_stiffness` [N], `bend` [rad].

    An episode is never terminated; `gymnasium.make` truncates it after its time limit.

    Args:
        render_mode: None or "rgb_array".
        finger: its numbers that an episode does not draw.
        width, height: of a rendered picture [pixels].
        ranges: ``friction``, ``pretension``, ``axial_stiffness`` and ``bend``, (low, high) that
            an episode draws from, see `Ranges`.

    Raises:
        InvalidValueError: an invalid range, or another render mode.
    """

    metadata: ClassVar[dict[str, Any]] = {  # type: ignore[misc]  # gymnasium has it an instance's
        "render_modes": ["rgb_array"],
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
            raise InvalidValueError(f"render_mode = {render_mode!r} must be None or 'rgb_array'")
        self.render_mode = render_mode
        self._size = width, height
        self._offscreen: Offscreen | None = None
        self._drawn: mujoco.MjModel | None = None  # on the offscreen buffer
        self.task = self.task_type(finger or Finger(), tasks.Ranges(**ranges), self.np_random)
        self.simulation = FingerSimulation(self.task.finger)
        self._steps = max(1, round(tasks.CONTROL_TIMESTEP / self.task.finger.timestep))
        readings = self.task.readings(self.simulation)
        boxes = {
            k: gymnasium.spaces.Box(r.low, r.high, dtype=np.float64) for k, r in readings.items()
        }
        self.observation_space = cast(
            "gymnasium.Space[_Observation]", gymnasium.spaces.Dict(cast(Any, boxes))
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
        return self._observe(), reward, False, False, dict(self.task.drawn)

    def render(self) -> Image | None:
        """(height, width, 3) picture, the tendons coloured by their tension; None without a mode.

        Raises:
            EngineError: no OpenGL is available; the message says what to do.
        """
        if self.render_mode is None:
            return None
        model, data = self.simulation.native
        if self._offscreen is None or self._drawn is not model:
            self.close()
            self._offscreen, self._drawn = Offscreen(without_tendons(model), *self._size), model
        camera = mujoco.MjvCamera()
        camera.lookat[:], camera.distance = _CENTRE, _DISTANCE
        camera.azimuth, camera.elevation = _AZIMUTH, _ELEVATION

        def add(scene: mujoco.MjvScene) -> None:
            for name in sheaths(model):
                add_cable(scene, *segment_tensions(model, data, name), _TENSION_SCALE, _RADIUS)

        return self._offscreen.draw(data, camera, add)

    def close(self) -> None:
        """Free the graphics memory."""
        if self._offscreen is not None:
            self._offscreen.close()
        self._offscreen = None

    def _observe(self) -> _Observation:
        readings = self.task.readings(self.simulation)
        return {name: np.clip(*reading) for name, reading in readings.items()}


class HoldForceEnv(FingerEnv):
    """Press the tip on the object and hold a force: `HoldForce` for gymnasium."""

    task_type = tasks.HoldForce


class FollowTrajectoryEnv(FingerEnv):
    """Follow a joint trajectory: `FollowTrajectory` for gymnasium."""

    task_type = tasks.FollowTrajectory
