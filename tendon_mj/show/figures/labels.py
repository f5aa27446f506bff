"""Labels of a recording's columns, and the units in which they are drawn."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tendon_mj.lab.replay import EngineeringUnit, column_unit, engineering_unit
from tendon_mj.lab.replay import column_name as column_name


def drawn_unit(column: str, *series: NDArray[np.float64]) -> EngineeringUnit:
    """The unit in which series of a column are drawn on one axis."""
    largest = [float(np.abs(one).max(initial=0.0)) for one in series]
    return engineering_unit(column_unit(column), largest)


def column_label(column: str, unit: EngineeringUnit) -> str:
    """A column as an axis label: ``joint_rad`` in degrees is `joint [°]`."""
    return f"{column_name(column)} [{unit.symbol}]" if unit.symbol else column_name(column)
