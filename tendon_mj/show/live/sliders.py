"""Ranges of the sliders of live parameters."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tendon_mj.lab.replay import engineering_unit
from tendon_mj.plugin import PARAMETERS

# those that one changes most, in the order in which they are shown; the others are folded away
FIRST = ("friction", "pretension", "backlash", "axial_stiffness")
_STEPS = 200
_WIDER = 3.0  # upper end of a slider over the model's value
# upper ends where the model's value is 0, of the order that real transmissions have
_TYPICAL = {
    "friction": 0.6,
    "static_friction": 0.6,
    "constant_friction": 5.0,
    "axial_stiffness": 20e3,
    "axial_damping": 100.0,
    "pretension": 40.0,
    "stribeck_friction": 0.3,
    "stribeck_velocity": 0.05,
    "viscous_friction": 100.0,
    "direction_asymmetry": 0.5,
    "friction_gradient": 1.0,
    "friction_drift": 0.1,
    "backlash": 0.005,
    "stiffening": 50.0,
    "creep": 0.5,
    "creep_time": 10.0,
    "sheath_compliance": 1e-4,
    "tendon_mass": 0.05,
    "extra_bend": math.pi,
    "slack": 0.01,
}


@dataclass(frozen=True)
class Slider:
    """A slider of one live parameter of a sheath.

    Attributes:
        parameter: its name.
        label: with the unit.
        hint: what it is.
        low, high, step: of what it shows, in the unit of the label.
        value: at which it begins, likewise.
        factor: what it shows over the value in SI.
    """

    parameter: str
    label: str
    hint: str
    low: float
    high: float
    step: float
    value: float
    factor: float


def slider(parameter: str, value: float) -> Slider | None:
    """The slider of a live parameter, None for one that is not given a range.

    Args:
        parameter: one of a sheath; a radius, which belongs to a joint, has no slider.
        value: that the model has.
    """
    if parameter not in _TYPICAL:
        return None
    known = PARAMETERS[parameter]
    high = max(_WIDER * value, _TYPICAL[parameter] if value == 0.0 else 0.0)
    if parameter in ("friction", "static_friction"):
        high = max(high, _TYPICAL[parameter])
    step = high / _STEPS
    low = 0.0 if known.range.admits(0.0) else step
    if known.range.low < 0.0:
        low = max(-high, known.range.low + step)
    unit = engineering_unit(known.unit, [high])
    label = parameter.replace("_", " ") + (f" [{unit.symbol}]" if unit.symbol else "")
    low, high, step, value = (unit.factor * number for number in (low, high, step, value))
    return Slider(parameter, label, known.text, low, high, step, value, unit.factor)
