"""Fig. 6 of the paper: phase plane of the servo, the two lines ẋ₂ = 0 and the backlash."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from experiments.force_servo.linear_theory import mode, with_damping
from experiments.force_servo.servo_bench import Servo, ServoResponse, run_servo
from tendon_mj.models import Bench
from tendon_mj.typing import FloatArray

GOAL = 60.0  # reference of every trajectory [N]
# direction -> tensions that the trajectories start at [N]
STARTS = {1: (25.0, 32.0, 39.0, 46.0), -1: (95.0, 88.0, 81.0, 74.0)}
_TURNS = {1: 20.0, -1: 105.0}  # tensions from which the start is approached slowly [N]
_HOLD_RATE = 0.2  # share of the usual dT_out/dθ below which the output counts as held


@dataclass(frozen=True)
class Nullcline:
    """Line ẋ₂ = 0, on which the motor neither accelerates nor slows down, in one direction.

    Attributes:
        direction: +1 pulling, −1 loosening.
        angle, speed: points of trajectories at which ẋ₂ = 0, x₁ [rad] from rest at the reference
            on the pulling branch, x₂ [rad/s].
        slope, analytic_slope: −dx₂/dx₁ of the line through them, and ω/2ζ [1/s].
    """

    direction: int
    angle: FloatArray
    speed: FloatArray
    slope: float
    analytic_slope: float

    @property
    def error(self) -> float:
        """Relative error of the slope [-]."""
        return self.slope / self.analytic_slope - 1.0


@dataclass(frozen=True)
class PhasePlane:
    """Trajectories and lines of the phase plane.

    Attributes:
        servo, swinging: critical for pulling, and lightly damped.
        lines: with the critical gains, one each direction.
        trajectories: of the critical servo, from below and above, then from both after a reversal.
        swing: trajectory of the lightly damped one, from below.
        origin: θ at which the motor rests at the reference on the pulling branch [rad].
    """

    servo: Servo
    swinging: Servo
    lines: tuple[Nullcline, Nullcline]
    trajectories: tuple[ServoResponse, ...]
    swing: ServoResponse
    origin: float


def _approach(bench: Bench, servo: Servo, start: float, turn: float) -> tuple[FloatArray, float]:
    """Reference that ramps slowly from ``turn`` to ``start`` and steps, and when it steps [s]."""
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


def _fastest(response: ServoResponse) -> tuple[float, float]:
    """Angle and speed where the speed is greatest, interpolated between time steps."""
    k = int(np.argmax(np.abs(response.speed)))
    near = slice(max(k - 3, 0), k + 4)
    parabola = np.polyfit(response.time[near] - response.time[k], response.speed[near], 2)
    at = -parabola[1] / (2.0 * parabola[0])
    angle = np.interp(response.time[k] + at, response.time, response.angle)
    return float(angle), float(np.polyval(parabola, at))


def simulate_phase_plane(bench: Bench, servo: Servo) -> PhasePlane:
    """Simulate trajectories to one reference from several tensions, and fit the lines ẋ₂ = 0."""
    critical, swinging = with_damping(bench, servo, 1.0), with_damping(bench, servo, 0.2)
    seen: dict[int, list[ServoResponse]] = {}
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
        lines.append(Nullcline(way, angle - origin, speed, slope, mode(bench, critical, way).slope))
    reversed_ = []
    for way in (1, -1):
        reference, begin = _approach(bench, critical, STARTS[way][0], GOAL)
        reversed_.append(run_servo(bench, critical, reference).part(begin, np.inf))
    reference, begin = _approach(bench, swinging, STARTS[1][0], _TURNS[1])
    swing = run_servo(bench, swinging, reference).part(begin, np.inf)
    trajectories = (seen[1][0], seen[-1][0], *reversed_)
    return PhasePlane(critical, swinging, (lines[0], lines[1]), trajectories, swing, origin)


def output_is_held(response: ServoResponse) -> NDArray[np.bool_]:
    """Mask of the samples at which the motor turns and the output tension does not change."""
    rate, speed = np.gradient(response.output_tension, response.time), response.speed
    turns = np.abs(speed) > 0.01 * np.abs(speed).max()
    slope = np.abs(rate) / np.where(turns, np.abs(speed), 1.0)
    return np.asarray(turns & (slope < _HOLD_RATE * np.quantile(slope[turns], 0.9)))
