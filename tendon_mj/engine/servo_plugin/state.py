"""What a servo keeps in `mjData.plugin_state`: gains, memory, commands on their way to the motor.

As for the sheath there is a *committed* state, from which every evaluation starts, and what the
last evaluation leaves on *trial* for `advance`. A ring of (time, torque) pairs follows the scalars.
"""

from __future__ import annotations

import math
from typing import Any

from tendon_mj.compilation import compiled
from tendon_mj.engine.abi.memory import doubles, table

# name -> (lowest allowed value, whether that value itself is allowed, unit, value if not given);
# None: required, or taken from elsewhere. A limit or stiffness of 0 is none, that is without end.
# The order is that of the state and of the plugin's attributes.
GAINS: dict[str, tuple[float, bool, str, float | None]] = {
    "tension_gain": (0.0, False, "-", None),
    "velocity_gain": (0.0, True, "N m s/rad", None),
    "loosening_tension_gain": (0.0, False, "-", None),
    "loosening_velocity_gain": (0.0, True, "N m s/rad", None),
    "motor_inertia": (0.0, False, "kg m²", None),
    "torque_limit": (0.0, True, "N m", 0.0),
    "speed_limit": (0.0, True, "rad/s", 0.0),
    "period": (0.0, True, "s", 0.0),
    "delay": (0.0, True, "s", 0.0),
    "observer_friction": (0.0, True, "-", None),
    "output_stiffness": (0.0, True, "N/m", 0.0),
    "backlash_feedforward": (0.0, True, "-", 0.0),
    "rate_feedforward": (0.0, True, "-", 0.0),
    "reversal_band": (0.0, True, "N", 0.0),
}
PARAMETERS = tuple(GAINS)
ATTRIBUTES = (*PARAMETERS, "tendon", "feedback", "backdrive")
TENDON, FEEDBACK, BACKDRIVE = range(len(PARAMETERS), len(ATTRIBUTES))
FEEDBACKS = ("sensor", "observer")
SWITCH = ("false", "true")

# What a servo remembers from one sample to the next.
(
    ESTIMATE,  # T̂_out, the output tension as the motor side knows it [N]
    TURNED_AT,  # extreme of the reference since it last turned [N]
    SENSE,  # where the reference goes: +1 pulls, −1 loosens, 0 has not moved yet
    CROSSING,  # 1 while the backlash of the last reversal is being crossed
    MARK,  # output tension from which it has to move for the crossing to be over [N]
    REFERENCE,  # the last one [N]
    TIME,  # when that was [s]
    MEMORY,
) = range(8)

(
    TENSION_GAIN,
    VELOCITY_GAIN,
    LOOSENING_TENSION_GAIN,
    LOOSENING_VELOCITY_GAIN,
    MOTOR_INERTIA,
    TORQUE_LIMIT,
    SPEED_LIMIT,
    PERIOD,
    DELAY,
    OBSERVER_FRICTION,
    OUTPUT_STIFFNESS,
    BACKLASH_FEEDFORWARD,
    RATE_FEEDFORWARD,
    REVERSAL_BAND,
    # what it is attached to
    SHEATH,  # where the sheath's state begins in plugin_state, −1 without one
    ACTUATOR,  # −1 for an instance that none uses
    OBSERVES,
    BACKDRIVEN,
    CAPACITY,
    # committed
    STARTED,
    SAMPLE,  # number of the last sample on the grid of periods
    HEAD,
    COUNT,
    # on trial
    ON_TRIAL,
    TRIAL_TIME,
    SAMPLED,
    TRIAL_SAMPLE,
    TRIAL_TORQUE,
) = range(28)
COMMITTED = 28
TRIAL = COMMITTED + MEMORY
SCALARS = TRIAL + MEMORY


def capacity(period: float, delay: float, timestep: float) -> int:
    """Commands that can be on their way at once; 0 for a servo that acts at once."""
    if period == 0.0 and delay == 0.0:
        return 0
    return math.ceil(delay / max(period, timestep) - 1e-9) + 2


def size(commands: int) -> int:
    """Numbers that a servo with room for so many commands keeps."""
    return SCALARS + 2 * commands


@compiled
def unpack(address: int) -> tuple[Any, Any]:
    """Views on one servo's state: scalars, and the ring of commands (time, torque)."""
    scalars = doubles(address, SCALARS)
    return scalars, table(address + 8 * SCALARS, int(scalars[CAPACITY]), 2)
