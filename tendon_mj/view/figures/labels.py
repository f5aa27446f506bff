"""Labels of a recording's columns, whose names end in their unit."""

from __future__ import annotations

from tendon_mj.recordings.recording import UNITS
from tendon_mj.replay.units import column_unit


def column_name(column: str) -> str:
    """A column's name in words, without its unit: ``tip_speed_m_per_s`` is `tip speed`."""
    ending = max((unit for unit in UNITS if column.endswith(unit)), key=len, default="")
    return column.removesuffix(ending).replace("_", " ")


def column_label(column: str) -> str:
    """A column as an axis label: ``joint_rad`` is `joint [rad]`."""
    unit = column_unit(column)
    return f"{column_name(column)} [{unit}]" if unit else column_name(column)
