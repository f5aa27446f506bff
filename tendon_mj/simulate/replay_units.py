"""Units of what recordings and replays name: columns, joints, live parameters of the plugins."""

from __future__ import annotations

from typing import Final

from tendon_mj.engine import GAINS
from tendon_mj.sheath.law import RANGES
from tendon_mj.simulate.recording_table import UNITS

UNKNOWN: Final = "1"  # of a reading or a control that no column names
_WRITTEN = {"Nm": "N m", "rad_per_s": "rad/s", "m_per_s": "m/s"}

# parameter -> (unit on a hinge, unit on a slide)
JOINT: Final[dict[str, tuple[str, str]]] = {
    "stiffness": ("N m/rad", "N/m"),
    "damping": ("N m s/rad", "N s/m"),
    "frictionloss": ("N m", "N"),
    "armature": ("kg m²", "kg"),
    "springref": ("rad", "m"),
}
# parameters of a sheath that say how it is attached, and the effects it can be given
_SHEATH = {
    "reel_radius": "m",
    "output_radius": "m",
    "stribeck_friction": "-",
    "stribeck_velocity": "m/s",
    "viscous_friction": "N s/m",
    "direction_asymmetry": "-",
    "friction_gradient": "1/m",
    "friction_drift": "1/s",
    "backlash": "m",
    "stiffening": "-",
    "creep": "-",
    "creep_time": "s",
    "sheath_compliance": "m/N",
    "tendon_mass": "kg",
    "extra_bend": "rad",
}


def column_unit(column: str) -> str:
    """The unit that a column's name ends in: ``joint_rad`` is in `rad`; empty without one."""
    suffix = max((unit for unit in UNITS if column.endswith(unit)), key=len, default="")
    unit = suffix.removeprefix("_")
    return _WRITTEN.get(unit, unit)


def live_unit(parameter: str) -> str:
    """The unit of a sheath's parameter or a servo's gain."""
    for table in (RANGES, GAINS):
        if parameter in table:
            return str(table[parameter][2])
    return _SHEATH.get(parameter, UNKNOWN)


def rate(unit: str) -> str:
    """A unit per second; one already per second is told with a square."""
    return f"{unit}²" if unit.endswith("/s") else f"{unit}/s"
