"""Fig. 6: the phase plane of the servo, its two lines ẋ₂ = 0 and the backlash between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from experiments.force_servo.bench import Response, Servo, run_servo
from experiments.force_servo.linear import damped, mode
from tendon_mj.builders.bench import Bench
from tendon_mj.replay.rollout import Array

GOAL = 60.0  # reference of every trajectory [N]
STARTS = {1: (25.0, 32.0, 39.0, 46.0), -1: (95.0, 88.0, 81.0, 74.0)}  # tensions they come from [N]
_TURNS = {1: 20.0, -1: 105.0}  # where the creep to the start comes from [N]


@dataclass(frozen=True)
class Line:
    """Where the motor neither speeds up nor slows down, in one direction.

    Attributes:
        direction: +1 pulling, −1 loosening.
        angle, speed: points of trajectories at which ẋ₂ = 0, x₁ [rad] from rest at the reference
            on the pulling branch, x₂ [rad/s].
        slope, analytic_slope: −dx₂/dx₁ of the line through them, and ω/2ζ [1/s].
    """

    direction: int
    angle: Array
    speed: Array
    slope: float
    analytic_slope: float

    @property
    def error(self) -> float:
        """Relative error of the slope."""
        return self.slope / self.analytic_slope - 1.0


@dataclass(frozen=True)
class PhasePlane:
    """Trajectories and lines of the phase plane.

    Attributes:
        servo, swinging: critical for pulling, and lightly damped.
        lines: with the critical gains, one each direction.
        trajectories: of the critical servo, from below and above, each after a reversal too.
        swing: of the lightly damped one, from below.
        origin: θ at which it rests at the reference on the pulling branch [rad].
    """

    servo: Servo
    swinging: Servo
    lines: tuple[Line, Line]
    trajectories: tuple[Response, ...]
    swing: Response
    origin: float


def _approach(bench: Bench, servo: Servo, start: float, turn: float) -> tuple[Array, float]:
    """Reference that creeps to ``start`` from ``turn`` and then steps to the goal; time of that."""
    slow = min(mode(bench, servo, way).frequency for way in (1, -1))
    rest = round(12.0 / slow / bench.timestep)
    lead = np.concatenate(
        [
            np.linspace(bench.pretension, turn, rest),
            np.full(rest, turn),
            np.linspace(turn, start, 3 * rest),
        ]
    )
    whole = np.concatenate([lead, np.full(2 * rest, GOAL)])
    return whole, len(lead) * bench.timestep


def _fastest(response: Response) -> tuple[float, float]:
    """Angle and speed where the speed is greatest, to below the time step."""
    k = int(np.argmax(np.abs(response.speed)))
    near = slice(max(k - 3, 0), k + 4)
    bend = np.polyfit(response.time[near] - response.time[k], response.speed[near], 2)
    at = -bend[1] / (2.0 * bend[0])
    angle = np.interp(response.time[k] + at, response.time, response.angle)
    return float(angle), float(np.polyval(bend, at))


def phase_plane(bench: Bench, servo: Servo) -> PhasePlane:
    """Trajectories to one reference from several tensions, and the lines that they show."""
    critical, swinging = damped(bench, servo, 1.0), damped(bench, servo, 0.2)
    seen: dict[int, list[Response]] = {}
    for way, starts in STARTS.items():
        seen[way] = []
        for start in starts:
            reference, begin = _approach(bench, critical, start, _TURNS[way])
            run = run_servo(bench, critical, reference)
            seen[way].append(run.part(begin, np.inf))
    origin = float(seen[1][0].angle[-1])
    lines = []
    for way, runs in seen.items():
        angle, speed = np.array([_fastest(run) for run in runs]).T
        slope = -float(np.polyfit(angle, speed, 1)[0])
        lines.append(Line(way, angle - origin, speed, slope, mode(bench, critical, way).slope))
    reversed_ = []
    for way in (1, -1):
        reference, begin = _approach(bench, critical, STARTS[way][0], GOAL)
        reversed_.append(run_servo(bench, critical, reference).part(begin, np.inf))
    reference, begin = _approach(bench, swinging, STARTS[1][0], _TURNS[1])
    swing = run_servo(bench, swinging, reference).part(begin, np.inf)
    trajectories = (seen[1][0], seen[-1][0], *reversed_)
    return PhasePlane(critical, swinging, (lines[0], lines[1]), trajectories, swing, origin)
