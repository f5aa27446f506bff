"""Writes a model with other parameters in it, as MJCF that replays as they were simulated.

| parameter | where it is written |
|---|---|
| of a sheath or servo | its plugin instance's ``config`` |
| ``drawn_bend`` of a sheath | added to ``extra_bend`` there, and what it adds beside it, as |
| | ``<custom><text name="<sheath>.drawn_bend.correction" data="…"/>`` |
| of a joint; ``gear``, ``kp``, ``kv`` | the element's own attribute; with a joint or a mass also |
| | ``stiffness`` and ``damping`` of every joint that had ``springdamper``, in place of that |
| | of muscles always ``lengthrange``, which their gear and masses change |
| ``mass`` of a body | its ``<inertial>``, which is made where its geoms have the mass |
| ``command_scale``, ``command_offset``, ``command_delay`` | ``user`` data, in this order; of a |
| | joint ``<custom><text name="<joint>.command" data="…"/>`` |
| ``scale`` … ``drift`` of a sensor | the sensor's ``user`` data, in the order of `Readout` |
| ``efficiency``, ``rest_in`` … of it | ``<custom><text name="<sensor>.gear" data="…"/>``, all |
| ``gravity.x`` … | ``<option gravity>`` |
| a parameter's interval | ``<custom><text name="<parameter>.interval" data="<low> <high>"/>`` |
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

import mujoco

from tendon_mj.attach import Mjcf, check_suffix, number, numbers, set_first
from tendon_mj.errors import InvalidValueError, TendonError, UnknownNameError
from tendon_mj.lab.replay.live_parameters import CORRECTION, DRAWN_BEND, EXTRA_BEND, custom_numbers
from tendon_mj.lab.replay.muscle import is_muscle
from tendon_mj.lab.replay.parameters import GEAR, GEARED, SLIP, Adjustable
from tendon_mj.lab.replay.patch.check_written import check_written
from tendon_mj.lab.replay.readout import JOINT_COMMAND, USER_NUMBERS
from tendon_mj.models import load_model, load_spec, model_path
from tendon_mj.typing import FloatArray
from tendon_mj.whole_file import whole_file

_INTERVAL = ".interval"


def patch_model(
    model: str | Path,
    parameters: Mapping[str, float],
    path: str | Path,
    *,
    intervals: Mapping[str, tuple[float, float]] | None = None,
) -> Path:
    """Write a model with these parameters, and make sure that the file has them.

    All other numbers stay as they are written in the source, digit for digit, with its comments;
    included files are put in their places. On a model with intervals `replay_recording` does not
    let a recording's guesses overrule it; on another, give it ``described=False``.

    Args:
        model: as ``recording.model``: a model of the package or an MJCF file.
        parameters: ``<element>.<parameter>`` to value, as in `replay_recording`.
        path: file to write, in an existing folder; what is there stays where an error is raised.
        intervals: (low, high) of some of the parameters.

    Returns:
        The path.

    Warns:
        TendonWarning: the model includes files from outside its folder, whose text is written too.

    Raises:
        UnknownNameError: no such model or parameter, or an interval of none that is given.
        InvalidValueError: a value or an interval outside its range, user data that other numbers
            occupy, or a path that does not end in .xml.
        TendonError: an element that is not in the text, or the written file is not the model.
    """
    source, target, intervals = model_path(str(model)), Path(path), dict(intervals or {})
    check_suffix(target)
    _check_intervals(parameters, intervals)
    adjustable = Adjustable(load_model(str(source)))
    adjustable.set(parameters)
    text, spec = Mjcf(source), load_spec(str(source))
    kinds = {name: parameter.kind for name, parameter in adjustable.parameters().items()}
    for name, value in parameters.items():
        element, parameter = name.rsplit(".", 1)
        if kinds[name] == "live":
            _write_live(text, adjustable, element, parameter, value)
        elif kinds[name] == "joint" and parameter.startswith("command_"):
            row = adjustable.joint_commands[adjustable.model.joint(element).id]
            _write_custom(text, element + JOINT_COMMAND, numbers(row))
        elif kinds[name] == "joint":
            _write_joint(text, adjustable.model, spec, element, parameter, value)
        elif kinds[name] == "body":
            _write_mass(text, adjustable.model, element, value)
        elif kinds[name] in ("actuator", "motor"):
            _write_actuator(text, adjustable, element, parameter)
        elif kinds[name] == "sensor":
            sensor = adjustable.model.sensor(element).id
            if parameter in GEARED:
                gear = adjustable.readings[sensor, USER_NUMBERS:]
                _write_custom(text, element + GEAR, numbers(gear))
                continue
            row = adjustable.readings[sensor, :USER_NUMBERS]
            user = _user(name, row, adjustable.model.sensor_user[sensor], text, "sensor")
            text.sensor(element).set("user", user)
        else:
            text.section("option", "gravity").set("gravity", numbers(adjustable.model.opt.gravity))
    if {"body", "joint"} & {kinds[name] for name in parameters}:
        _write_spring_dampers(text, adjustable.model, spec)
    _write_damping(text, adjustable, spec)
    muscles = _write_length_ranges(text, adjustable.model)
    _write_intervals(text, intervals)
    text.root.insert(0, ElementTree.Comment(_says(source, adjustable, parameters, intervals)))
    text.move_to(target.parent, spec)
    with whole_file(target) as made:  # what is there stays unless the new one holds
        text.write(made)
        check_written(made, target, adjustable, parameters, muscles)
    text.warn_of_outside(target)
    return target


def read_intervals(model: mujoco.MjModel) -> dict[str, tuple[float, float]]:
    """Parameter → (low, high), as ``patch_model`` wrote them.

    Raises:
        InvalidValueError: a custom text with the name of an interval that is none.
    """
    found = {}
    for k in range(model.ntext):
        name = str(mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_TEXT, k))
        if name.endswith(_INTERVAL) and "." in name.removesuffix(_INTERVAL):
            low, high = custom_numbers(model, k, 2)
            if low > high:
                raise InvalidValueError(
                    f"custom text {name!r} of the model: {low:g} is above {high:g}"
                )
            found[name.removesuffix(_INTERVAL)] = (low, high)
    return found


def _check_intervals(
    parameters: Mapping[str, float], intervals: Mapping[str, tuple[float, float]]
) -> None:
    for name, (low, high) in intervals.items():
        if name not in parameters:
            raise UnknownNameError("parameter of an interval", name, parameters)
        if not -math.inf < low <= high < math.inf:
            raise InvalidValueError(f"{name}: interval {low:g} … {high:g} must be finite, in order")


def _write_live(
    text: Mjcf, adjustable: Adjustable, element: str, parameter: str, value: float
) -> None:
    if parameter not in (EXTRA_BEND, DRAWN_BEND):
        _write_config(text, element, parameter, value)
        return
    correction = adjustable.live.correction(element)
    extra_bend = adjustable.live[f"{element}.{EXTRA_BEND}"] + correction
    _write_config(text, element, EXTRA_BEND, extra_bend)
    if parameter == DRAWN_BEND:
        _write_custom(text, element + CORRECTION, number(correction))


def _write_config(text: Mjcf, element: str, parameter: str, value: float) -> None:
    holder = text.plugin(element)
    for config in holder.iterfind("config"):
        if config.get("key") == parameter:
            config.set("value", number(value))
            return
    ElementTree.SubElement(holder, "config", key=parameter, value=number(value))


def _write_joint(
    text: Mjcf,
    model: mujoco.MjModel,
    spec: mujoco.MjSpec,
    element: str,
    parameter: str,
    value: float,
) -> None:
    turns = model.joint(element).type[0] == mujoco.mjtJoint.mjJNT_HINGE.value
    if parameter == "springref" and turns and spec.compiler.degree:
        value = math.degrees(value)
    set_first(text.joint(element), parameter, value)


def _write_spring_dampers(text: Mjcf, model: mujoco.MjModel, spec: mujoco.MjSpec) -> None:
    """Write as stiffness and damping what `springdamper` made of masses that may be other ones now.

    A joint without a name, or that is not in the text, stays as it is: it may have other masses.
    """
    for joint in spec.joints:
        if not joint.springdamper.any() or not joint.name:
            continue
        try:
            written, compiled = text.joint(joint.name), model.joint(joint.name)
        except TendonError:
            continue
        set_first(written, "stiffness", compiled.stiffness[0])
        set_first(written, "damping", compiled.damping[0])
        written.set("springdamper", "0 0")  # which a class may give, too


def _write_mass(text: Mjcf, model: mujoco.MjModel, element: str, value: float) -> None:
    """Write the mass of a body as the model has it by now, and its inertia in proportion."""
    body, written = model.body(element), text.body(element)
    inertial = written.find("inertial")
    if inertial is None:
        pose = {"pos": numbers(body.ipos), "quat": numbers(body.iquat)}
        inertial = ElementTree.SubElement(written, "inertial", pose)
        inertial.set("diaginertia", numbers(body.inertia))
    else:
        ratio = value / float(inertial.get("mass", "nan"))
        for attribute in ("diaginertia", "fullinertia"):
            if attribute in inertial.attrib:
                stated = str(inertial.get(attribute)).split()
                inertial.set(attribute, numbers(ratio * float(number) for number in stated))
    inertial.set("mass", number(value))


def _write_damping(text: Mjcf, adjustable: Adjustable, spec: mujoco.MjSpec) -> None:
    """Write as kv what a damping ratio made of masses that may be other ones now."""
    for actuator in spec.actuators:
        if actuator.biasprm[2] > 0.0 and f"{actuator.name}.kv" in adjustable.parameters():
            _write_actuator(text, adjustable, actuator.name, "kv")


def _write_length_ranges(text: Mjcf, model: mujoco.MjModel) -> list[int]:
    """Write the lengths over which muscles' forces are defined, which compiling would seek anew.

    Returns the muscles; those that `attach` or `replicate` makes are not in the text.
    """
    written = {k: e for k, e in text.actuators(model).items() if is_muscle(model, k)}
    for k, element in written.items():
        element.set("lengthrange", numbers(model.actuator_lengthrange[k]))
    return list(written)


def _write_actuator(text: Mjcf, adjustable: Adjustable, element: str, parameter: str) -> None:
    m, written = adjustable.model, text.actuator(element)
    k = m.actuator(element).id
    if parameter == "gear":
        set_first(written, "gear", m.actuator_gear[k, 0])
    elif parameter in SLIP:
        raise InvalidValueError(
            f"{element}.{parameter}: a slip is of one recording and not of the model; state it in"
            " [known] of that recording"
        )
    elif parameter not in ("kp", "kv"):
        row, user = adjustable.commands[k, :3], m.actuator_user[k]
        written.set("user", _user(f"{element}.{parameter}", row, user, text, "actuator", 2))
    elif written.tag == "general":
        written.set("gainprm", numbers(m.actuator_gainprm[k]))
        written.set("biasprm", numbers(m.actuator_biasprm[k]))
    else:
        written.attrib.pop("dampratio", None)  # which would say kv again, from kp
        written.set("kp", number(m.actuator_gainprm[k, 0]))
        written.set("kv", number(0.0 - m.actuator_biasprm[k, 2]))


def _user(
    name: str, row: FloatArray, there: FloatArray, text: Mjcf, kind: str, fewest: int | None = None
) -> str:
    """User data that begins with our row; the ``nuser`` of its kind is enlarged to hold it.

    Where there are fewer numbers than ``fewest``, by default than in a row, they are not ours.
    """
    if not row.any():
        raise InvalidValueError(f"{name}: a scale of 0 with nothing else cannot be written")
    if 0 < len(there) < (fewest or len(row)):
        raise InvalidValueError(
            f"{name}: the model's {kind}s have user data of {len(there)} numbers of their own, and"
            f" {len(row)} are needed there"
        )
    size, attribute = max(len(row), len(there)), f"nuser_{kind}"
    text.section("size", attribute).set(attribute, str(size))
    return numbers([*row, *there[len(row) :]])


def _write_intervals(text: Mjcf, intervals: Mapping[str, tuple[float, float]]) -> None:
    for name, interval in intervals.items():
        _write_custom(text, name + _INTERVAL, numbers(interval))


def _write_custom(text: Mjcf, name: str, data: str) -> None:
    """Write a custom text in place of one of the same name."""
    custom = text.root.find("custom")
    if custom is None:
        custom = ElementTree.SubElement(text.root, "custom")
    for old in [t for t in custom.iterfind("text") if t.get("name") == name]:
        custom.remove(old)
    ElementTree.SubElement(custom, "text", name=name, data=data)


def _says(
    source: Path,
    adjustable: Adjustable,
    parameters: Mapping[str, float],
    intervals: Mapping[str, tuple[float, float]],
) -> str:
    known = adjustable.parameters()
    lines = [f" Written by tendon-mj from {source.name}, with"]
    for name, value in parameters.items():
        within = (
            f", {intervals[name][0]:.4g} … {intervals[name][1]:.4g}" if name in intervals else ""
        )
        lines.append(f"{name} = {value:.6g} [{known[name].unit}]{within}")
    return re.sub("-(?=-)", "- ", "\n       ".join(lines)) + " "  # two would end the comment
