"""What a sheath keeps in `mjData.plugin_state`: parameters, committed state, the step on trial.

Everything is there, so copying, saving, resetting and threads need nothing from us. A block of
scalars comes first, then a table over the n+1 segments, one over the n guides, and the path.

The *committed* state is what the last finished step left; every evaluation starts from it and
leaves its result on *trial*; only `advance` makes the trial the committed state.
"""

from __future__ import annotations

from typing import Any

from tendon_mj.engine.memory import doubles, table
from tendon_mj.sheath import tables
from tendon_mj.sheath.compiled import compiled

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
    # what the sheath is attached to; -1 where there is none
    TENDON,
    GUIDES,
    REEL_JOINT,
    OUTPUT_JOINT,
    REEL_ACTUATOR,
    FIRST_SENSOR,
    LAST_SENSOR,
    SPARING,  # whether nothing in the model reads velocities of subtrees
    # committed
    STARTED,
    WOUND_IN,
    WOUND_OUT,
    COMMIT_TIME,
    UNSOLVED,
    # on trial
    ON_TRIAL,
    TRIAL_WOUND_IN,
    TRIAL_WOUND_OUT,
    TRIAL_TIME,
    # the four leading parameters as they were when the guides' ratios were computed
    BOUND,
    _,
    _,
    _,
    SCALARS,
) = range(30)


# Rows that the engine adds to the flow solver's tables.
STRAIN, FRESH_STRAIN, TRIAL_STRAIN, START, TRIAL_START, SEGMENT_ROWS = range(
    tables.SEGMENT_ROWS, tables.SEGMENT_ROWS + 6
)
ANGLE, BOUND_ANGLE, WORK, TRIAL_FLOW, TRIAL_SLIP, TRIAL_WORK, GUIDE_ROWS = range(
    tables.GUIDE_ROWS, tables.GUIDE_ROWS + 7
)


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
