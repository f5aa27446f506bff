"""Tasks on the finger: observations, actions and rewards."""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections import OrderedDict
from typing import Any

import numpy as np

from tendon_mj.envs.ranges import Random, Ranges
from tendon_mj.envs.simulated_finger import SimulatedFinger
from tendon_mj.errors import InvalidValueError
from tendon_mj.models import JOINTS, TENDONS, Finger
from tendon_mj.typing import FloatArray

CONTROL_TIMESTEP = 0.01  # between two actions [s]
_LARGEST_TENSION = 2.5  # that the tension sensors read, over a stalled motor's [-]
_BEYOND_COMMAND = 2.0  # of the motors' commands, that their encoders read [rad]
_BEYOND_STOP = 0.3  # of the joints' ranges, that their encoders read [rad]
_LEAD = 0.1  # that an agent is told of the trajectory ahead [s]


class FingerTask(ABC):
    """A task whose episodes each have a friction, pretension and bend of their own.

    Actions are the angles of the two spools between −1 and 1 of their ranges. Without an
    estimate of friction no action sequence suits every episode: that is the point.

    Args:
        finger: whose other numbers it keeps.
        ranges: to draw from.
        random: of the draws; the same state of it gives the same episodes.

    Raises:
        InvalidValueError: a bend that the guides of the sheaths cannot turn by.
    """

    def __init__(self, finger: Finger, ranges: Ranges, random: Random) -> None:
        most = 2.0 * np.pi * min(finger.forearm_guides, finger.wrist_guides)  # π each
        if ranges.bend[1] > most:
            raise InvalidValueError(
                f"bend = {ranges.bend} [rad] must be at most {most:.4g}, by which the guides of"
                " forearm and wrist turn a sheath; is it in radians?"
            )
        self.finger, self.ranges = dataclasses.replace(finger, bend=ranges.bend[0]), ranges
        self.random = random
        self.drawn: dict[str, float] = {}

    def initialize_episode(self, physics: SimulatedFinger) -> None:
        """Draw the episode's numbers and begin it with the finger straight and at rest."""
        self.drawn = self.ranges.draw(self.random)
        numbers: dict[str, Any] = dict(self.drawn)
        drawn = dataclasses.replace(self.finger, **numbers)
        low, high = self.ranges.bend
        if low < high:  # otherwise the physics was made with it
            physics.rebuild(dataclasses.replace(self.finger, bend=drawn.bend))
        physics.start(drawn)
        physics.command(np.zeros(len(TENDONS)))

    def before_step(self, action: FloatArray, physics: SimulatedFinger) -> None:
        """Turn the action into angles of the spools.

        Raises:
            InvalidValueError: the action is not as many numbers as there are tendons.
        """
        try:
            shares = np.asarray(action, float)
        except (TypeError, ValueError, OverflowError):
            shares = np.array(np.nan)
        if shares.shape != (len(TENDONS),) or not np.isfinite(shares).all():
            raise InvalidValueError(
                f"action = {action!r} must be {len(TENDONS)} finite numbers between -1 and 1, of "
                f"{' and '.join(TENDONS)}: shape {(len(TENDONS),)}"
            )
        low, high = physics.command_range()
        physics.command(low + 0.5 * (shares + 1.0) * (high - low))

    def get_observation(self, physics: SimulatedFinger) -> OrderedDict[str, FloatArray]:
        """Readings of an encoder and a tension sensor on each motor, and the goal.

        `motor_angles` [rad] and `input_tensions` [N] of flexor and extensor, then what the task
        adds. Neither friction nor the tension at the finger is in it.
        """
        seen = OrderedDict[str, FloatArray]()
        seen["motor_angles"] = np.array([physics.sensor(f"{t}_motor_angle") for t in TENDONS])
        seen["input_tensions"] = np.array([physics.sensor(f"{t}_input_tension") for t in TENDONS])
        return seen

    def observation_range(
        self, physics: SimulatedFinger
    ) -> dict[str, tuple[FloatArray, FloatArray]]:
        """(lowest, highest) reading of everything observed, by name, in the same shapes.

        Random and bang-bang commands of the motors stay within them.
        """
        low, high = physics.command_range()
        most = np.full(len(TENDONS), self.largest_force)
        return {
            "motor_angles": (low - _BEYOND_COMMAND, high + _BEYOND_COMMAND),
            "input_tensions": (0.0 * most, most),
        }

    @property
    def largest_force(self) -> float:
        """Largest reading of force and tension: 2.5 times what a stalled motor pulls with [N]."""
        finger = self.finger
        return _LARGEST_TENSION * finger.motor_torque * finger.gear / finger.spool_radius

    @abstractmethod
    def get_reward(self, physics: SimulatedFinger) -> float:
        """Reward of the present state, from 0 to 1 [–]."""


class HoldForce(FingerTask):
    """Press the tip on the object with a force that the episode draws, and hold it.

    Reward exp(−((F − F*)/scale)²) per step, from 0 to 1.

    Args:
        force: (low, high) of F* [N].
        scale: by how much off the reward falls to 1/e [N].
        finger, ranges, random: see `FingerTask`.
    """

    def __init__(
        self,
        finger: Finger,
        ranges: Ranges,
        random: Random,
        *,
        force: tuple[float, float] = (0.5, 2.0),
        scale: float = 0.2,
    ) -> None:
        super().__init__(finger, ranges, random)
        self._forces, self._scale = force, scale
        self.target = force[0]

    def initialize_episode(self, physics: SimulatedFinger) -> None:
        """Draw the force besides."""
        super().initialize_episode(physics)
        self.target = float(self.random.uniform(*self._forces))

    def get_observation(self, physics: SimulatedFinger) -> OrderedDict[str, FloatArray]:
        """`FingerTask`'s, with `tip_force` and `target_force` [N]."""
        seen = super().get_observation(physics)
        seen["tip_force"] = np.array([physics.sensor("tip_force")])
        seen["target_force"] = np.array([self.target])
        return seen

    def observation_range(
        self, physics: SimulatedFinger
    ) -> dict[str, tuple[FloatArray, FloatArray]]:
        """`FingerTask`'s, with those of `tip_force` and `target_force` [N]."""
        low, high = self._forces
        return super().observation_range(physics) | {
            "tip_force": (np.zeros(1), np.array([self.largest_force])),
            "target_force": (np.array([low]), np.array([high])),
        }

    def get_reward(self, physics: SimulatedFinger) -> float:
        """Reward for a force near its target [–]."""
        off = (physics.sensor("tip_force") - self.target) / self._scale
        return float(np.exp(-(off**2)))


class FollowTrajectory(FingerTask):
    """Follow a smooth joint trajectory that the episode draws; the object is out of the way.

    Every joint goes along a sum of two sines between straight and ``share`` of its range, all in
    proportion, as two tendons can move three joints. Reward exp(−|q − q*|²/scale²) per step.

    Args:
        share: of the joints' ranges that is used [-].
        scale: by how much off the reward falls to 1/e [rad].
        finger, ranges, random: see `FingerTask`.
    """

    def __init__(
        self,
        finger: Finger,
        ranges: Ranges,
        random: Random,
        *,
        share: float = 0.7,
        scale: float = 0.2,
    ) -> None:
        super().__init__(finger, ranges, random)
        self._scale = scale
        self._pose = share * np.array([joint.high for joint in finger.joints.values()])
        self._waves = np.zeros((2, 2))

    def initialize_episode(self, physics: SimulatedFinger) -> None:
        """Draw the trajectory besides."""
        super().initialize_episode(physics)
        frequency = self.random.uniform([0.2, 0.4], [0.4, 0.8])
        self._waves = np.stack([frequency, self.random.uniform(0.2, 0.5, 2)])
        physics.move_object_away()

    def target(self, time: float) -> FloatArray:
        """q* at a time [rad]; straight at the start."""
        frequency, size = self._waves
        share = float(size @ (0.5 - 0.5 * np.cos(2.0 * np.pi * frequency * time)))
        return share * self._pose

    def get_observation(self, physics: SimulatedFinger) -> OrderedDict[str, FloatArray]:
        """`FingerTask`'s, with `joint_angles`, `target_angles` and `next_angles` [rad]."""
        seen = super().get_observation(physics)
        now = physics.time()
        seen["joint_angles"] = joint_angles(physics)
        seen["target_angles"] = self.target(now)
        seen["next_angles"] = self.target(now + _LEAD)
        return seen

    def observation_range(
        self, physics: SimulatedFinger
    ) -> dict[str, tuple[FloatArray, FloatArray]]:
        """`FingerTask`'s, with those of all angles [rad]."""
        low, high = np.array([(j.low, j.high) for j in self.finger.joints.values()]).T
        asked = (0.0 * self._pose, self._pose)
        return super().observation_range(physics) | {
            "joint_angles": (low - _BEYOND_STOP, high + _BEYOND_STOP),
            "target_angles": asked,
            "next_angles": asked,
        }

    def get_reward(self, physics: SimulatedFinger) -> float:
        """Reward for joints near their targets [–]."""
        off = (joint_angles(physics) - self.target(physics.time())) / self._scale
        return float(np.exp(-(off @ off)))


def joint_angles(physics: SimulatedFinger) -> FloatArray:
    """(3,) angles of MCP, PIP, DIP [rad]."""
    return np.array([physics.sensor(f"{joint}_angle") for joint in JOINTS])
