"""Labels of a recording's columns, whose names end in their unit."""

from __future__ import annotations

from tendon_mj.replay.units import column_name as column_name
from tendon_mj.replay.units import column_unit


def column_label(column: str) -> str:
    """A column as an axis label: ``joint_rad`` is `joint [rad]`."""
    unit = column_unit(column)
    return f"{column_name(column)} [{unit}]" if unit else column_name(column)
