"""A description to fill in: every actuator, sensor and likely parameter of a model, as TOML."""

from __future__ import annotations

import copy
from collections.abc import Iterator

import mujoco
import numpy as np
import tomli_w

from tendon_mj.lab.replay.parameters import Adjustable, Parameter
from tendon_mj.lab.replay.units import control_unit, reading_unit
from tendon_mj.lab.units import ROUNDING, ending_of, unit_fault

_SHEATH = ("axial_stiffness", "pretension", "drawn_bend")
_JOINT = ("stiffness", "springref", "damping", "frictionloss", "armature")
_MOTOR = ("command_scale", "command_offset", "kp", "kv", "gear")
_GUESS, _SPAN = 0.15, 3.0  # μ where the model has none, and the factor of its range

_HEAD = """\
# What the columns of a recording are on the model. Fill in `source`; give the columns the names
# that they have in your table, with the unit that they are in, such as lever_deg or pull_kN; take
# out what you did not record. Then: tendon-mj check RECORDING. Every entry: docs/recording.md
# If your table has other names, counts or dates, add at the end:
#   [columns]
#   time_s = "timestamp"
#   lever_deg = { column = "present_position", factor = 0.087890625, period = 4096 }
"""
_DRIVE = """\
# column = the actuator that it commands, a list of several, or a hinge or slide that it prescribes.
# Between samples it is linear; for a command that keeps its value until the next sample write
# { actuator = "…", hold = true }."""
_MEASURED = """\
# column = the sensor that read it. If you know its noise, { sensor = "…", noise = 0.05 }: the
# standard deviation at rest, in the column's unit."""
_KNOWN = """\
# Measured on the rig, and never fitted [SI]. The model has these values; take the # off those that
# you know, with the value that you measured."""
_UNCERTAIN = """\
# Fitted before anything is called missing: best guess, and the range that it may lie in [SI]."""


def format_template(model: mujoco.MjModel, name: str) -> str:
    """TOML text of a description for recordings of a model, to be filled in by hand.

    ``name`` is a model of the package, or the path of an MJCF file from the description's folder.
    """
    parameters = Adjustable(copy.copy(model)).parameters()
    columns: set[str] = set()
    parts = [
        f"{_HEAD}\nmodel = {_quoted(name)}",
        'source = ""  # who measured it, when, on which rig, under which licence\n'
        + _settle(model),
        "\n".join(["[drive]", _DRIVE, *_drive(model, columns)]),
        "\n".join(["[measured]", _MEASURED, *_measured(model, columns)]),
        "\n".join(["[known]", _KNOWN, *_known(model, parameters)]),
        "\n".join(["[uncertain]", _UNCERTAIN, *_uncertain(parameters)]),
    ]
    return "\n\n".join(parts) + "\n"


def _settle(model: mujoco.MjModel) -> str:
    """Line of the settling time: 0 if an actuator bears a load in the reference pose."""
    if _bears_a_load(model):
        return (
            "# A motor bears a load at rest: a replay begins with the first drive value, since a\n"
            "# control of 0 would let go.\n"
            "settle = 0.0  # [s]"
        )
    return "settle = 0.5  # [s], in which a replay comes to the first drive value before it begins"


def _bears_a_load(model: mujoco.MjModel) -> bool:
    """Return whether a pretension, a spring or weight pulls at a joint that an actuator turns."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    load = np.abs(data.qfrc_passive - data.qfrc_bias)
    on_joints = model.actuator_trntype == mujoco.mjtTrn.mjTRN_JOINT
    turned = model.jnt_dofadr[model.actuator_trnid[on_joints, 0]]
    return bool((load[turned] > ROUNDING).any())


def _drive(model: mujoco.MjModel, columns: set[str]) -> Iterator[str]:
    for k in range(model.nactuator):
        name, unit = model.actuator(k).name, control_unit(model, k)
        if not name:
            yield f"# actuator {k} has no name: give it one in the model to drive it"
        elif ending_of(unit):
            limits = model.actuator_ctrlrange[k].tolist() if model.actuator_ctrllimited[k] else []
            span = f", {limits[0]:g} … {limits[1]:g}" if limits else ""
            column = _quoted_key(column_of(name, unit, columns))
            yield f"{column} = {_quoted(name)}  # control in {unit}{span}"
        else:
            column = _quoted_key(column_of(name, "N", columns))
            yield f"# {column} = {_quoted(name)}  # the model does not say in which unit"


def _measured(model: mujoco.MjModel, columns: set[str]) -> Iterator[str]:
    for k in range(model.nsensor):
        name, unit, size = model.sensor(k).name, reading_unit(model, k), int(model.sensor_dim[k])
        if not name:
            yield f"# sensor {k} has no name: give it one in the model to compare with it"
        elif size != 1:
            yield f"# sensor {name!r} reads {size} numbers, but a column holds one"
        elif ending_of(unit):
            column = _quoted_key(column_of(name, unit, columns))
            yield f"{column} = {{ sensor = {_quoted(name)} }}  # [{unit}]"
        else:
            column = _quoted_key(column_of(name, "N", columns))
            yield f"# {column} = {{ sensor = {_quoted(name)} }}  # in which unit is it?"


def _known(model: mujoco.MjModel, parameters: dict[str, Parameter]) -> Iterator[str]:
    driven = {model.actuator(k).name for k in range(model.nactuator)}
    for name, parameter in parameters.items():
        element, _, which = name.rpartition(".")
        listed = {
            "live": which in _SHEATH and parameter.value > 0.0,
            "joint": which in _JOINT and parameter.value != 0.0,
            "body": True,
            "actuator": which in _MOTOR and element in driven,
            "motor": which in _MOTOR and element in driven,
            "gravity": True,
        }
        if listed.get(parameter.kind, False):
            unit = "control per column, such as a radius" if "scale" in which else parameter.unit
            yield f"# {_quoted(name)} = {_number(parameter.value)}  # [{unit}]"


def _uncertain(parameters: dict[str, Parameter]) -> Iterator[str]:
    for name, parameter in parameters.items():
        if parameter.kind != "live" or not name.endswith(".friction"):
            continue
        of, gear = "the capstan law", f"{name.removesuffix('.friction')}.gear_friction"
        if not parameter.value and gear in parameters and parameters[gear].value:
            of, name, parameter = "a gear, 1/η - 1", gear, parameters[gear]
        value = parameter.value or _GUESS
        low, high = _number(parameter.value / _SPAN), _number(value * _SPAN)
        entry = f"{{ value = {_number(value)}, low = {low}, high = {high} }}"
        yield f"{_quoted(name)} = {entry}  # [-], of {of}"


def column_of(name: str, unit: str, taken: set[str]) -> str:
    """A name for an element's column, which ends in its unit [SI] and in no other before it.

    Characters that no column's name may hold, such as a comma, become underscores. The name differs
    from those that are ``taken``, to which it is added.
    """
    ending = ending_of(unit)
    name = "".join(c if c.isprintable() and c not in ',"' else "_" for c in name).strip()
    column = name if name.endswith(ending) else name + ending
    column = f"{name}_of_it{ending}" if unit_fault(column, si=True) else column
    if column in taken:
        return column_of(f"another_{name}", unit, taken)
    taken.add(column)
    return column


def _number(value: float) -> str:
    return repr(float(f"{value:.4g}"))


def _quoted(text: str) -> str:
    return tomli_w.dumps({"k": text}).strip().removeprefix("k = ")


def _quoted_key(text: str) -> str:
    return tomli_w.dumps({text: 0}).strip().removesuffix(" = 0")
