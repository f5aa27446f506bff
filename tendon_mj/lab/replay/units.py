"""Units of columns, sensors and parameters; values in the units in which engineers read them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final, NamedTuple

import mujoco

from tendon_mj.lab.recordings import UNITS
from tendon_mj.plugin import KINDS, sensor_kind, servos

_PLACE, _RATE = 1, 2  # MuJoCo's `ctrlspec` of a servo
ROUNDING: Final = 1e-6  # of a step, an interval or a length, and loads [N or N m] and angles [rad]
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
# sensor -> (unit of its reading on a hinge, on a slide)
_OF_JOINT: Final = {
    mujoco.mjtSensor.mjSENS_JOINTPOS: ("rad", "m"),
    mujoco.mjtSensor.mjSENS_JOINTVEL: ("rad/s", "m/s"),
    mujoco.mjtSensor.mjSENS_JOINTACTFRC: ("N m", "N"),
}
_OF_TENDON: Final = {  # through sites; one of joints is in whatever its coefficients say
    mujoco.mjtSensor.mjSENS_TENDONPOS: "m",
    mujoco.mjtSensor.mjSENS_TENDONVEL: "m/s",
    mujoco.mjtSensor.mjSENS_TENDONACTFRC: "N",
}

_PREFIXES: Final = (("M", 1e6), ("k", 1e3), ("", 1.0), ("m", 1e-3), ("µ", 1e-6))
# SI unit → prefixes of its first symbol, as in mN m
_PREFIXED: Final = {
    "m": "mµ",
    "s": "mµ",
    "m/s": "mµ",
    "N": "Mkmµ",
    "N/m": "Mkm",
    "N/s": "kmµ",
    "N s": "kmµ",
    "N s/m": "kmµ",
    "m/N": "mµ",
    "N m": "kmµ",
    "N m/rad": "kmµ",
    "N m s/rad": "kmµ",
}
# SI unit → another one, and how many of it make one of the first
_REPLACED: Final = {
    "rad": ("°", 180.0 / math.pi),
    "rad/s": ("°/s", 180.0 / math.pi),
    "rad/s²": ("°/s²", 180.0 / math.pi),
    "1/s": ("%/s", 100.0),
    "1/m": ("%/m", 100.0),
}
# SI unit → value below which another one is used, that one, and how many of it make one
_SMALLER: Final = {"kg": (1.0, "g", 1e3), "kg m²": (1e-4, "g cm²", 1e7)}
_UNITLESS: Final = ("", "-", "1")


def column_unit(column: str) -> str:
    """The unit that a column's name ends in: ``joint_rad`` is in `rad`; empty without one."""
    unit = unit_ending(column).removeprefix("_")
    return _WRITTEN.get(unit, unit)


def column_name(column: str) -> str:
    """A column's name in words, without its unit: ``tip_speed_m_per_s`` is `tip speed`."""
    return column.removesuffix(unit_ending(column)).replace("_", " ")


def reading_unit(model: mujoco.MjModel, sensor: int) -> str:
    """The unit of a sensor's reading; ``UNKNOWN`` where its kind does not say."""
    kind = sensor_kind(model, sensor)
    if kind:
        return KINDS[kind][1]
    seen, now = int(model.sensor_objid[sensor]), mujoco.mjtSensor(int(model.sensor_type[sensor]))
    if now in _OF_JOINT:
        return _OF_JOINT[now][int(model.jnt_type[seen] == mujoco.mjtJoint.mjJNT_SLIDE.value)]
    if now in _OF_TENDON:
        return UNKNOWN if _of_joints(model, seen) else _OF_TENDON[now]
    return "N" if now == mujoco.mjtSensor.mjSENS_TOUCH else UNKNOWN


def control_unit(model: mujoco.MjModel, actuator: int) -> str:
    """The unit of an actuator's control; ``UNKNOWN`` where its kind does not say.

    A reel's is tendon wound in, a servo of the package takes a tension, a motor a force or torque,
    MuJoCo's servos a place or a rate. Of other gains nobody knows, nor of tendons of joints.
    """
    plugin = int(model.actuator_plugin[actuator])
    if plugin >= 0:
        servo = model.plugin_stateadr[plugin] in servos(model).values()
        return "N" if servo else "m"
    on = int(model.actuator_trntype[actuator])
    if on in (mujoco.mjtTrn.mjTRN_JOINT.value, mujoco.mjtTrn.mjTRN_JOINTINPARENT.value):
        joint = int(model.actuator_trnid[actuator, 0])
        slides = model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE.value
        force, place, rate_of = ("N", "m", "m/s") if slides else ("N m", "rad", "rad/s")
    elif on == mujoco.mjtTrn.mjTRN_TENDON.value and not _of_joints(
        model, int(model.actuator_trnid[actuator, 0])
    ):
        force, place, rate_of = "N", "m", "m/s"
    else:
        return UNKNOWN
    if model.actuator_gaintype[actuator] != mujoco.mjtGain.mjGAIN_FIXED.value:
        return UNKNOWN  # a muscle's activation
    if model.actuator_ctrlspec[actuator]:  # of the shortcuts
        return {_PLACE: place, _RATE: rate_of}.get(int(model.actuator_ctrlspec[actuator]), UNKNOWN)
    if model.actuator_dyntype[actuator] == mujoco.mjtDyn.mjDYN_INTEGRATOR.value:
        return UNKNOWN
    if model.actuator_biastype[actuator] == mujoco.mjtBias.mjBIAS_NONE.value:
        return force
    gain, bias = model.actuator_gainprm[actuator, 0], model.actuator_biasprm[actuator]
    if gain == -bias[1]:
        return place
    return rate_of if bias[1] == 0.0 and gain == -bias[2] else UNKNOWN


def _of_joints(model: mujoco.MjModel, tendon: int) -> bool:
    first = model.wrap_type[model.tendon_adr[tendon]]
    return bool(first == mujoco.mjtWrap.mjWRAP_JOINT.value)


def ending_of(unit: str) -> str:
    """Ending of the name of a column in an SI unit; empty if names have no such unit."""
    return {column_unit(ending): ending for ending in UNITS}.get(unit, "")


def name_in(unit: str, column: str) -> str:
    """A column's name in another unit; empty if names have no such unit."""
    ending = ending_of(unit)
    return column.removesuffix(unit_ending(column)) + ending if ending else ""


def unit_ending(column: str) -> str:
    """The longest unit in which a column's name ends."""
    return max((ending for ending in UNITS if column.endswith(ending)), key=len, default="")


def rate(unit: str) -> str:
    """A unit per second; one already per second gets a square."""
    return f"{unit}²" if unit.endswith("/s") else f"{unit}/s"


class EngineeringUnit(NamedTuple):
    """A unit to read values in."""

    symbol: str  # as it is written; empty for a ratio
    factor: float  # by which a value in the SI unit is multiplied


NEWTON: Final = EngineeringUnit("N", 1.0)


def engineering_unit(unit: str, values: Iterable[float]) -> EngineeringUnit:
    """The unit in which the largest of some values has one to three digits before the point.

    Units that are not SI, as "noise", stay as they are; values that are not finite do not count.
    """
    if unit in _UNITLESS:
        return EngineeringUnit("", 1.0)
    if unit in _REPLACED:
        return EngineeringUnit(*_REPLACED[unit])
    largest = max((abs(v) for v in values if math.isfinite(v)), default=0.0)
    if unit in _SMALLER and 0.0 < largest < _SMALLER[unit][0]:
        return EngineeringUnit(*_SMALLER[unit][1:])
    usable = [p for p in _PREFIXES if not p[0] or p[0] in _PREFIXED.get(unit, "")]
    if largest > 0.0:
        rounded = float(f"{largest:.3g}")  # 999.9 µm is 1 mm
        fitting = [p for p in usable if rounded >= p[1] * (1.0 - 1e-9)] or usable[-1:]
    else:
        fitting = [("", 1.0)]
    prefix, size = fitting[0]
    return EngineeringUnit(prefix + unit, 1.0 / size)


def force_unit(forces: Iterable[float]) -> EngineeringUnit:
    """The unit of all forces [N] that are shown together, by the largest of them.

    It is smaller than N below 1 N, kN from 10 kN on and MN from 10 MN on.
    """
    seen = list(forces)
    unit = engineering_unit("N", seen)
    return unit if unit.factor >= 1.0 else engineering_unit("N", (0.1 * force for force in seen))


def plain(value: float, digits: int = 3) -> str:
    """A number with so many digits, without an exponent where that reads as well."""
    return f"{float(f'{value:.{digits}g}'):g}"


def quantity(value: float, unit: str, digits: int = 3) -> str:
    """A value [unit] with its unit, as in "12 mN m", "4°" or "0.18"; "-" or empty for a ratio."""
    chosen = engineering_unit(unit, [value])
    return with_unit(plain(value * chosen.factor, digits), chosen)


def from_to(
    before: float, after: float, unit: str, between: str = " → ", beside: Iterable[float] = ()
) -> str:
    """Two values [unit] in one unit, as in "4° → 0.11°" or "0.36 → 0.026 mm".

    ``beside`` are values that are written in the same unit elsewhere.
    """
    chosen = engineering_unit(unit, [before, after, *beside])
    first, second = (plain(value * chosen.factor) for value in (before, after))
    first = with_unit(first, chosen) if chosen.symbol.startswith("°") else first
    return first + between + with_unit(second, chosen)


def with_unit(number: str, unit: EngineeringUnit) -> str:
    """A written number with its unit; degrees follow without a space."""
    if not unit.symbol:
        return number
    return f"{number}{'' if unit.symbol.startswith('°') else ' '}{unit.symbol}"


def percent(share: float) -> str:
    """A share in whole percents; 100 % only where it is exactly 1."""
    if not math.isfinite(share):
        return "–"
    return "more than 99 %" if 0.995 <= share < 1.0 else f"{100.0 * share:.0f} %"


def estimated_percent(share: float) -> str:
    """An estimate of a share in whole percents; none is so sure that it is 100 %."""
    return percent(min(share, 0.999))
