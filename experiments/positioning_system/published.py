"""Published values: A. Janot, M. Gautier and M. Brunot, EMPS benchmark, 2019."""

from __future__ import annotations

from typing import Final

MASS: Final = 95.1  # [kg]
VISCOUS: Final = 203.5  # [N s/m]
COULOMB: Final = 20.4  # [N]
OFFSET: Final = -3.2  # of the motor's force [N]
POSITION_GAIN: Final = 160.18  # [1/s]
VELOCITY_GAIN: Final = 243.45  # [V s/m]
FORCE_GAIN: Final = 35.15  # [N/V]
SERVO_STIFFNESS: Final = POSITION_GAIN * VELOCITY_GAIN * FORCE_GAIN  # [N/m]
SERVO_DAMPING: Final = VELOCITY_GAIN * FORCE_GAIN  # [N s/m]

# Limits: values within this of the published ones, and held-out errors within this factor
# of the published model's.
WITHIN: Final = 0.10
ERROR_RATIO: Final = 1.2

# The model's parameters; the offset acts on the carriage as a constant force does.
PARAMETERS: Final = {
    "carriage.mass": MASS,
    "screw.damping": VISCOUS,
    "screw.frictionloss": COULOMB,
    "gravity.x": -OFFSET / MASS,
}
