"""What a sheath keeps in `mjData.plugin_state`: parameters, committed state, the step on trial.

Everything is there, so copying, saving, resetting and threads need nothing from us. A block of
scalars comes first, then a table over the n+1 segments, one over the n guides, and the path.

The *committed* state is what the last finished step left; every evaluation starts from it and
leaves its result on *trial*; only `advance` makes the trial the committed state.
"""

from __future__ import annotations

from typing import Any

from tendon_mj.compilation import compiled
from tendon_mj.engine.abi.memory import doubles, table
from tendon_mj.sheath import tables

# Live parameters, in the order of the plugin's attributes of the same names.
PARAMETERS = (
    "axial_stiffness",
    "friction",
    "static_friction",
    "constant_friction",
    "axial_damping",
    "pretension",
    "reel_radius",
    "output_radius",
    "stribeck_friction",
    "stribeck_velocity",
    "viscous_friction",
    "direction_asymmetry",
    "friction_gradient",
    "friction_drift",
    "backlash",
    "stiffening",
    "creep",
    "creep_time",
    "sheath_compliance",
    "tendon_mass",
    "extra_bend",
)
(
    AXIAL_STIFFNESS,
    FRICTION,
    STATIC_FRICTION,
    CONSTANT_FRICTION,
    AXIAL_DAMPING,
    PRETENSION,
    REEL_RADIUS,
    OUTPUT_RADIUS,
    STRIBECK_FRICTION,
    STRIBECK_VELOCITY,
    VISCOUS_FRICTION,
    DIRECTION_ASYMMETRY,
    FRICTION_GRADIENT,
    FRICTION_DRIFT,
    BACKLASH,
    STIFFENING,
    CREEP,
    CREEP_TIME,
    SHEATH_COMPLIANCE,
    TENDON_MASS,
    EXTRA_BEND,
    # what the sheath is attached to; -1 where there is none
    TENDON,
    GUIDES,
    REEL_JOINT,
    OUTPUT_JOINT,
    REEL_ACTUATOR,
    FIRST_SENSOR,
    LAST_SENSOR,
    # committed
    STARTED,
    WOUND_IN,
    WOUND_OUT,
    COMMIT_TIME,
    UNSOLVED,
    LAID,  # pretension under which the tendon was laid [N]
    VARIED,  # whether the ratios were computed for a moment only
    STRAINED,  # whether the strain law of the step before was another than Hooke's
    REMEMBERED,  # whether the guides' speeds were kept in the step before
    # on trial
    ON_TRIAL,
    TRIAL_WOUND_IN,
    TRIAL_WOUND_OUT,
    TRIAL_TIME,
    TRIAL_ELAPSED,  # time that the step on trial takes [s]
    REEL_TORQUE,  # by which the last evaluation turned the reel's joint back [N m]
    # parameters as they were when the guides' ratios were computed: the four leading ones first
    BOUND,
    _,
    _,
    _,
    BOUND_ASYMMETRY,
    BOUND_EXTRA_BEND,
    SCALARS,
) = range(50)


# Rows that the engine adds to the flow solver's tables.
(
    STRAIN,  # elastic strain, kept while damping, stiffening or creep asks for it [-]
    FRESH_STRAIN,
    TRIAL_STRAIN,
    CREPT,  # creep strain [-]
    TRIAL_CREPT,
    START,  # τ after the step before, from which the solver starts [-]
    TRIAL_START,
    SEGMENT_ROWS,
) = range(tables.SEGMENT_ROWS, tables.SEGMENT_ROWS + 8)
(
    ANGLE,
    BOUND_ANGLE,
    WORK,
    PASSED,  # tendon that has passed to the input since the reset [m]
    SPEED,  # sliding speed seen through the memory of friction [m/s]
    RAN,  # velocity in the step before, positive to the input [m/s]
    TRIAL_FLOW,
    TRIAL_SLIP,
    TRIAL_WORK,
    GUIDE_ROWS,
) = range(tables.GUIDE_ROWS, tables.GUIDE_ROWS + 10)


def size(guides: int) -> int:
    """Numbers that a sheath with so many guides keeps."""
    return SCALARS + SEGMENT_ROWS * (guides + 1) + GUIDE_ROWS * guides + 3 * (guides + 2)


@compiled
def unpack(address: int) -> tuple[Any, Any, Any, int]:
    """Views on one sheath's state: scalars, segments table, guides table; address of the path."""
    scalars = doubles(address, SCALARS)
    n = int(scalars[GUIDES])
    segments = table(address + 8 * SCALARS, SEGMENT_ROWS, n + 1)
    behind = address + 8 * (SCALARS + SEGMENT_ROWS * (n + 1))
    guides = table(behind, GUIDE_ROWS, n)
    return scalars, segments, guides, behind + 8 * GUIDE_ROWS * n
