"""Steps of the reference: overshoot and rise of each direction, and the six steps of Fig. 7."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from experiments.force_servo.bench import Response, Servo, run_servo
from experiments.force_servo.linear import arrival, damped, mode, overshoot
from tendon_mj.builders.bench import Bench
from tendon_mj.replay.rollout import Array

LOW, MIDDLE, HIGH = 40.0, 60.0, 80.0  # tensions between which the steps go [N]
HELD = 1e6  # k_e of an output that is held, so that the sensor is what gives [N/m]
_REST = 12.0  # time that every stretch of a run takes, over 1/ω of the slower mode
_RAMP = 5.0  # times as long for a slow approach
FIGURE_7 = (0.0, 20.0, 40.0, 60.0, 40.0, 20.0, 0.0)  # above the pretension [N]


@dataclass(frozen=True)
class Step:
    """A step of the reference, measured and as the linear theory has it.

    Attributes:
        direction: +1 pulling, −1 loosening.
        reversed: whether the motor came from the other direction and has the backlash to cross.
        overshoot, predicted_overshoot: over the step [-].
        rise: time from 10 % to 90 % [s].
        delay: time to 10 % [s].
        response: what happened.
    """

    direction: int
    reversed: bool
    overshoot: float
    predicted_overshoot: float
    rise: float
    delay: float
    response: Response


def step(bench: Bench, servo: Servo, direction: int, *, reverse: bool) -> Step:
    """One step of 20 N to ``MIDDLE``.

    Without ``reverse`` the tension has crept to the start in the direction of the step, so that all
    of the tendon already slides that way; with it, it has crept there from the other side.
    """
    slow = min(mode(bench, servo, way).frequency for way in (1, -1))
    rest = round(_REST / slow / bench.timestep)
    start = LOW if direction > 0 else HIGH
    below, above = start - 15.0, start + 15.0
    turn = above if (direction < 0) != reverse else below
    creep = np.linspace(turn, start, round(_RAMP * rest))
    goal = MIDDLE
    lead = np.concatenate([np.linspace(bench.pretension, turn, rest), np.full(rest, turn), creep])
    run = run_servo(bench, servo, np.concatenate([lead, np.full(rest, goal)]))
    seen = run.part(len(lead) * bench.timestep, np.inf)
    first = seen.output_tension[0]
    way = (seen.output_tension - first) / (goal - first)
    begun, risen = int(np.argmax(way >= 0.1)), int(np.argmax(way >= 0.9))
    ahead, speed = mode(bench, servo, direction), 0.0
    if reverse:
        speed = arrival(bench, servo, direction, start, abs(goal - start))
    predicted = overshoot(ahead.damping, speed) if ahead.damping <= 1.0 else 0.0
    time = bench.timestep
    excess = max(0.0, float(way.max()) - 1.0)
    return Step(direction, reverse, excess, predicted, (risen - begun) * time, begun * time, seen)


@dataclass(frozen=True)
class Staircase:
    """Fig. 7: six steps, with the gains of the paper and with those critical for pulling.

    Attributes:
        bench: λ = 1.5, its output held by the sensor alone.
        paper, critical: servos.
        paper_response, critical_response: what they did.
        time: of one level [s].
    """

    bench: Bench
    paper: Servo
    critical: Servo
    paper_response: Response
    critical_response: Response
    time: float

    def overshoots(self, response: Response) -> Array:
        """Overshoot of each of the six steps over its height [-]."""
        found = []
        for k in range(1, len(FIGURE_7)):
            height = FIGURE_7[k] - FIGURE_7[k - 1]
            seen = response.part(k * self.time, (k + 1) * self.time).output_tension
            goal = self.bench.pretension + FIGURE_7[k]
            found.append(max(0.0, float(np.max((seen - goal) / height))))
        return np.array(found)


def staircase(bench: Bench, servo: Servo, time: float = 4.0) -> Staircase:
    """The paper's six steps; its tensions count from the pretension, as in its eq. (27)."""
    held = dataclasses.replace(bench, environment_stiffness=HELD)
    levels = bench.pretension + np.array(FIGURE_7)
    reference = np.repeat(levels, round(time / bench.timestep))
    critical = damped(held, servo, 1.0)
    return Staircase(
        held,
        servo,
        critical,
        run_servo(held, servo, reference),
        run_servo(held, critical, reference),
        time,
    )
