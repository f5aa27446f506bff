"""Tasks on the finger: its simulation, ranges of its parameters, observations, actions, rewards."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import mujoco
import numpy as np

from tendon_mj.attach import Parameters
from tendon_mj.envs.scene import draw_forces, draw_pose
from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.finger import OUT_OF_REACH
from tendon_mj.models import JOINTS, TENDONS, Finger
from tendon_mj.typing import FloatArray

LIVE = ("friction", "pretension", "axial_stiffness")  # of a sheath, without another model
CONTROL_TIMESTEP = 0.01  # between two actions [s]
_LARGEST_TENSION = 2.5  # that the tension sensors read, over a stalled motor's [-]
_BEYOND_COMMAND = 2.0  # of the motors' commands, that their encoders read [rad]
_BEYOND_STOP = 0.3  # of the joints' ranges, that their encoders read [rad]
_HELD_FORCES = (0.5, 2.0)  # (low, high) of the force that is to be held [N]
_RANGE_SHARE = 0.7  # of the joints' ranges that a trajectory uses [-]
_REWARD_SCALE = 0.2  # by how much off the reward falls to 1/e [N], [rad]
_LEAD = 0.1  # of the trajectory ahead that an agent observes [s]
Random = np.random.RandomState | np.random.Generator  # dm_control's, gymnasium's
_RANGE_UNITS = {"friction": "-", "pretension": "N", "bend": "rad", "axial_stiffness": "N"}


@dataclass(frozen=True, kw_only=True)
class Ranges:
    """(low, high) of every number that an episode draws uniformly; low = high keeps it.

    Friction, pretension and axial stiffness are live parameters of the simulation's data: setting
    them costs nothing. Bend is geometry, so unless it is kept the model is built again for every
    episode (about 5 ms).

    Attributes:
        friction: μ, the same for both tendons [-].
        pretension: T_0 of both tendons [N].
        axial_stiffness: EA of both tendons [N].
        bend: of both sheaths [rad].

    Raises:
        InvalidValueError: not two finite numbers in order, below 0, or an axial stiffness of 0.
    """

    friction: tuple[float, float] = (0.05, 0.25)
    pretension: tuple[float, float] = (3.0, 6.0)
    axial_stiffness: tuple[float, float] = (2000.0, 2000.0)
    bend: tuple[float, float] = (math.pi / 3.0, math.pi)

    def __post_init__(self) -> None:
        for name, unit in _RANGE_UNITS.items():
            given, bound = getattr(self, name), "> 0" if name == "axial_stiffness" else "≥ 0"
            try:
                low, high = (float(number) for number in given)
            except (TypeError, ValueError):
                low = high = math.nan
            in_order = math.isfinite(high) and 0.0 <= low <= high
            if not in_order or (bound == "> 0" and low == 0.0):
                raise InvalidValueError(
                    f"{name} = {given!r} [{unit}] must be a pair (low, high), finite, in order and "
                    f"{bound}; a pair of equal numbers keeps it"
                )
            object.__setattr__(self, name, (low, high))

    def draw(self, random: Random) -> dict[str, float]:
        """A number from each range, by name."""
        return {f.name: float(random.uniform(*getattr(self, f.name))) for f in fields(self)}


class Reading(NamedTuple):
    """A reading that an agent observes, and the lowest and highest that it may be."""

    value: FloatArray
    low: FloatArray
    high: FloatArray


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
        for tendon in TENDONS:
            for name in LIVE:
                parameters[f"{tendon}_sheath.{name}"] = getattr(finger, name)
            model.actuator(f"{tendon}_angle").biasprm[0] = finger.resting_torque

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


class FingerTask(ABC):
    """A task with a different friction, pretension and bend in every episode.

    Actions are the angles of the two spools between −1 and 1 of their ranges. Without an
    estimate of friction no action sequence suits every episode.

    Args:
        finger: gives all other parameters.
        ranges: to draw from.
        random: of the draws; the same state of it gives the same episodes.
    """

    def __init__(self, finger: Finger, ranges: Ranges, random: Random) -> None:
        most = 2.0 * np.pi * min(finger.forearm_guides, finger.wrist_guides)  # π each
        if ranges.bend[1] > most:
            raise InvalidValueError(
                f"bend = {ranges.bend} [rad] must be at most {most:.4g}, by which the guides of"
                " forearm and wrist turn a sheath; is it in radians?"
            )
        self.finger, self.ranges = replace(finger, bend=ranges.bend[0]), ranges
        self.random = random
        self.drawn: dict[str, float] = {}

    def initialize_episode(self, physics: SimulatedFinger) -> None:
        """Draw the episode's numbers and begin it with the finger straight and at rest."""
        self.drawn = self.ranges.draw(self.random)
        numbers: dict[str, Any] = dict(self.drawn)
        drawn = replace(self.finger, **numbers)
        low, high = self.ranges.bend
        if low < high:  # otherwise the physics was made with it
            physics.rebuild(replace(self.finger, bend=drawn.bend))
        physics.start(drawn)
        physics.command(np.zeros(len(TENDONS)))

    def before_step(self, action: FloatArray, physics: SimulatedFinger) -> None:
        """Turn the action, a finite number for each tendon, into angles of the spools."""
        shares = np.asarray(action, float)
        if shares.shape != (len(TENDONS),) or not np.isfinite(shares).all():
            raise InvalidValueError(
                f"action = {action!r} must be {len(TENDONS)} finite numbers between -1 and 1, of "
                f"{' and '.join(TENDONS)}: shape {(len(TENDONS),)}"
            )
        low, high = physics.command_range()
        physics.command(low + 0.5 * (shares + 1.0) * (high - low))

    def get_observation(self, physics: SimulatedFinger) -> dict[str, FloatArray]:
        """Values of `readings` by name."""
        return {name: reading.value for name, reading in self.readings(physics).items()}

    def readings(self, physics: SimulatedFinger) -> dict[str, Reading]:
        """Readings of an encoder and a tension sensor on each motor, then those of the task.

        `motor_angles` [rad] and `input_tensions` [N] of flexor and extensor. Neither friction nor
        the tension at the finger is among them. Random and bang-bang commands of the motors keep
        within their ranges.
        """
        low, high = physics.command_range()
        angles = np.array([physics.sensor(f"{t}_motor_angle") for t in TENDONS])
        tensions = np.array([physics.sensor(f"{t}_input_tension") for t in TENDONS])
        most = np.full(len(TENDONS), self.largest_force)
        return {
            "motor_angles": Reading(angles, low - _BEYOND_COMMAND, high + _BEYOND_COMMAND),
            "input_tensions": Reading(tensions, 0.0 * most, most),
        }

    @property
    def largest_force(self) -> float:
        """Largest reading of force and tension: 2.5 times the pull of a stalled motor [N]."""
        finger = self.finger
        return _LARGEST_TENSION * finger.motor_torque * finger.gear / finger.spool_radius

    @abstractmethod
    def get_reward(self, physics: SimulatedFinger) -> float:
        """Reward of the present state, from 0 to 1 [–]."""

    @abstractmethod
    def draw_target(self, physics: SimulatedFinger, scene: mujoco.MjvScene) -> None:
        """Add the target to a scene; a `scene_callback` of dm_control's `render`."""


class HoldForce(FingerTask):
    """Press the tip on the object with a force F* that the episode draws, and hold it.

    Reward exp(−((F − F*)/0.2 N)²) per step, from 0 to 1.
    """

    target = _HELD_FORCES[0]  # F* [N]

    def initialize_episode(self, physics: SimulatedFinger) -> None:
        """Draw the force too."""
        super().initialize_episode(physics)
        self.target = float(self.random.uniform(*_HELD_FORCES))

    def readings(self, physics: SimulatedFinger) -> dict[str, Reading]:
        """`FingerTask`'s, with `tip_force` and `target_force` [N]."""
        force, most = np.array([physics.sensor("tip_force")]), np.array([self.largest_force])
        low, high = np.array(_HELD_FORCES)[:, None]
        return super().readings(physics) | {
            "tip_force": Reading(force, 0.0 * most, most),
            "target_force": Reading(np.array([self.target]), low, high),
        }

    def get_reward(self, physics: SimulatedFinger) -> float:
        """Reward for a force near its target [–]."""
        off = (physics.sensor("tip_force") - self.target) / _REWARD_SCALE
        return float(np.exp(-(off**2)))

    def draw_target(self, physics: SimulatedFinger, scene: mujoco.MjvScene) -> None:
        """Add the force of the tip, a red arrow of 15 mm/N, and its target, a blue one."""
        draw_forces(scene, physics.native[1], physics.sensor("tip_force"), self.target)


class FollowTrajectory(FingerTask):
    """Follow a smooth joint trajectory that the episode draws; the object is out of the way.

    Every joint goes along a sum of two sines between straight and 0.7 of its range, all in
    proportion, as two tendons can move three joints. Reward exp(−|q − q*|²/(0.2 rad)²) per step.
    """

    def __init__(self, finger: Finger, ranges: Ranges, random: Random) -> None:
        super().__init__(finger, ranges, random)
        self._pose = _RANGE_SHARE * np.array([joint.high for joint in finger.joints.values()])
        self._waves = np.zeros((2, 2))

    def initialize_episode(self, physics: SimulatedFinger) -> None:
        """Draw the trajectory too."""
        super().initialize_episode(physics)
        frequency = self.random.uniform([0.2, 0.4], [0.4, 0.8])
        self._waves = np.stack([frequency, self.random.uniform(0.2, 0.5, 2)])
        physics.move_object_away()

    def target(self, time: float) -> FloatArray:
        """q* at a time [rad]; straight at the start."""
        frequency, size = self._waves
        share = float(size @ (0.5 - 0.5 * np.cos(2.0 * np.pi * frequency * time)))
        return share * self._pose

    def readings(self, physics: SimulatedFinger) -> dict[str, Reading]:
        """`FingerTask`'s, with `joint_angles`, `target_angles` and `next_angles` [rad]."""
        now, straight = physics.time(), 0.0 * self._pose
        low, high = np.array([(j.low, j.high) for j in self.finger.joints.values()]).T
        angles = joint_angles(physics)
        return super().readings(physics) | {
            "joint_angles": Reading(angles, low - _BEYOND_STOP, high + _BEYOND_STOP),
            "target_angles": Reading(self.target(now), straight, self._pose),
            "next_angles": Reading(self.target(now + _LEAD), straight, self._pose),
        }

    def get_reward(self, physics: SimulatedFinger) -> float:
        """Reward for joints near their targets [–]."""
        off = (joint_angles(physics) - self.target(physics.time())) / _REWARD_SCALE
        return float(np.exp(-(off @ off)))

    def draw_target(self, physics: SimulatedFinger, scene: mujoco.MjvScene) -> None:
        """Add the finger in its target pose, translucent blue."""
        draw_pose(scene, physics.native[0], self.target(physics.time()))


def joint_angles(physics: SimulatedFinger) -> FloatArray:
    """(3,) angles of MCP, PIP, DIP [rad]."""
    return np.array([physics.sensor(f"{joint}_angle") for joint in JOINTS])
