"""Writes a model with other parameters in it, as MJCF that replays as they were simulated.

| parameter | where it is written |
|---|---|
| of a sheath or servo | its plugin instance's ``config`` |
| ``drawn_bend`` of a sheath | added to ``extra_bend`` there, and the addition as |
| | ``<custom><text name="<sheath>.drawn_bend.correction" data="…"/>`` |
| of a joint; ``gear``, ``kp``, ``kv`` | the element's own attribute; with a joint or a mass also |
| | ``stiffness`` and ``damping`` of every joint that had ``springdamper``, in place of that |
| | of muscles always ``lengthrange``, which their gear and masses change |
| ``frictionloss`` of a joint | also ``solreffriction`` and ``solimpfriction``, where it had none |
| ``mass`` of a body | its ``<inertial>``, which is made where its geoms have the mass |
| ``command_scale``, ``command_offset``, ``command_delay`` | ``user`` data, in this order; of a |
| | joint ``<custom><text name="<joint>.command" data="…"/>`` |
| ``scale`` … ``drift`` of a sensor | the sensor's ``user`` data, in the order of `Readout` |
| ``efficiency``, ``rest_in`` … of it | ``<custom><text name="<sensor>.gear" data="…"/>``, all |
| ``range_low`` … | ``<joint range>``, ``<fixed range>``, ``<spatial range>`` |
| ``gravity.x`` … | ``<option gravity>`` |
| a parameter's interval | ``<custom><text name="<parameter>.interval" data="<low> <high>"/>`` |
"""

from __future__ import annotations

import copy
import math
import re
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np

from tendon_mj.attach import Mjcf, check_suffix, number_text, numbers, set_first, set_gains
from tendon_mj.errors import InvalidValueError, TendonError, UnknownNameError
from tendon_mj.lab.replay.parameters import (
    CORRECTION,
    DRAWN_BEND,
    EXTRA_BEND,
    GEAR,
    GEARED,
    OUTPUT_REST,
    RANGE_ENDS,
    RANGE_WIDTH,
    SLIP,
    Adjustable,
    is_muscle,
)
from tendon_mj.lab.replay.readout import JOINT_COMMAND, USER_NUMBERS, custom_numbers
from tendon_mj.models import load_model, load_spec, model_path
from tendon_mj.typing import FloatArray
from tendon_mj.whole_file import whole_file

_INTERVAL = ".interval"
_AGREE = 1e-12  # relative; degrees and radians are not the same to the last bit
_COMPARED = (
    *("qpos0", "body_mass", "body_inertia", "dof_invweight0", "dof_damping", "jnt_stiffness"),
    *("site_pos", "tendon_length0", "actuator_biasprm"),
)


def patch_model(
    model: str | Path,
    parameters: Mapping[str, float],
    path: str | Path,
    *,
    intervals: Mapping[str, tuple[float, float]] | None = None,
) -> Path:
    """Write a model with these parameters, and make sure that the file has them.

    All other numbers stay as they are written in the source, digit for digit, with its comments;
    included files are put in their places. `replay_recording` does
    not let a recording's guesses overrule it, on a model with intervals not even if the recording
    names it.

    Args:
        model: as ``recording.model``: a model of the package or an MJCF file.
        parameters: ``<element>.<parameter>`` to value, as in `replay_recording`.
        path: file to write, in an existing folder; an existing file stays if an error is raised.
        intervals: (low, high) of some of the parameters.

    Returns:
        The path.

    Warns:
        TendonWarning: the model includes files from outside its folder; their text is written too.

    Raises:
        UnknownNameError: no such model or parameter, or an interval of none that is given.
        InvalidValueError: a value or an interval outside its range, user data that other numbers
            occupy, or a path that does not end in .xml.
        TendonError: an element that is not in the text, or the written file is not the model.
    """
    source, target, intervals = model_path(str(model)), Path(path), dict(intervals or {})
    check_suffix(target)
    for name, (low, high) in intervals.items():
        if name not in parameters:
            raise UnknownNameError("parameter of an interval", name, parameters)
        if not -math.inf < low <= high < math.inf:
            raise InvalidValueError(
                f"{name}: interval {low:g} … {high:g} must be finite and ascending"
            )
    patch = _Patch(source, parameters)
    patch.write_all()
    for name, interval in intervals.items():
        patch.write_custom(name + _INTERVAL, numbers(interval))
    patch.comment(intervals)
    patch.text.move_to(target.parent, patch.spec)
    with whole_file(target) as made:  # an existing file stays unless the new one holds
        patch.text.write(made)
        patch.check(made, target)
    patch.text.warn_of_outside(target)
    return target


def read_intervals(model: mujoco.MjModel) -> dict[str, tuple[float, float]]:
    """Parameter → (low, high), as ``patch_model`` wrote them.

    Raises:
        InvalidValueError: a custom text with the name of an interval that is none.
    """
    stored = custom_numbers(model, _INTERVAL, 2, lambda name: "." in name)
    return {name: (low, high) for name, (low, high) in stored.items()}


class _Patch:
    """The text of a model, and the model with the parameters that go into it."""

    def __init__(self, source: Path, parameters: Mapping[str, float]) -> None:
        self.source, self.parameters = source, parameters
        self.text, self.spec = Mjcf(source), load_spec(str(source))
        self.adjustable = Adjustable(load_model(str(source)))
        self.adjustable.set(parameters)
        self.model = self.adjustable.model
        self.known = self.adjustable.parameters()
        # those that `attach` or `replicate` makes are not in the text
        actuators = self.text.actuators(self.model).items()
        self.muscles = {k: e for k, e in actuators if is_muscle(self.model, k)}

    def write_all(self) -> None:
        """Write the parameters, and the numbers that compiling would make of changed masses."""
        for name, value in self.parameters.items():
            self._write(name, value)
        if {"body", "joint"} & {self.known[name].kind for name in self.parameters}:
            self._write_spring_dampers()
        for actuator in self.spec.actuators:  # kv of a damping ratio
            if actuator.biasprm[2] > 0.0 and f"{actuator.name}.kv" in self.known:
                self._write_actuator(actuator.name, "kv")
        for k, element in self.muscles.items():
            element.set("lengthrange", numbers(self.model.actuator_lengthrange[k]))

    def _write(self, name: str, value: float) -> None:
        (element, parameter), kind = name.rsplit(".", 1), self.known[name].kind
        if kind == "live":
            self._write_live(element, parameter, value)
        elif kind == "joint" and parameter.startswith("command_"):
            row = self.adjustable.joint_commands[self.model.joint(element).id]
            self.write_custom(element + JOINT_COMMAND, numbers(row))
        elif parameter in (RANGE_WIDTH, *RANGE_ENDS):
            self._write_limits(element, kind == "joint")
        elif kind == "joint":
            in_degrees = parameter == "springref" and self._is_in_degrees(element)
            written = math.degrees(value) if in_degrees else value
            set_first(self.text.element("joint", element), parameter, written)
            if parameter == "frictionloss" and value > 0.0:
                self._write_softness(element)
        elif kind == "body":
            self._write_mass(element, value)
        elif kind in ("actuator", "motor"):
            self._write_actuator(element, parameter)
        elif kind == "sensor":
            sensor = self.model.sensor(element).id
            row = self.adjustable.readings[sensor]
            if parameter in GEARED:
                self.write_custom(element + GEAR, numbers(row[USER_NUMBERS:]))
            else:
                user = self.model.sensor_user[sensor]
                data = self._user(name, row[:USER_NUMBERS], user, "sensor", USER_NUMBERS)
                self.text.element("sensor", element).set("user", data)
        else:
            gravity = numbers(self.model.opt.gravity)
            self.text.section("option", "gravity").set("gravity", gravity)

    def _write_limits(self, element: str, of_joint: bool) -> None:
        if not of_joint:
            ends = self.model.tendon_range[self.model.tendon(element).id]
            self.text.element("tendon", element).set("range", numbers(ends))
            return
        ends = self.model.joint(element).range
        in_text = numbers(np.degrees(ends) if self._is_in_degrees(element) else ends)
        self.text.element("joint", element).set("range", in_text)

    def _is_in_degrees(self, joint: str) -> bool:
        """Whether the text has the angles of a joint in degrees."""
        turns = self.model.joint(joint).type[0] == mujoco.mjtJoint.mjJNT_HINGE.value
        return bool(turns and self.spec.compiler.degree)

    def _write_live(self, element: str, parameter: str, value: float) -> None:
        if parameter == "output_play" and f"{element}.{OUTPUT_REST}" not in self.parameters:
            self._write_live(element, OUTPUT_REST, self.adjustable.live[f"{element}.{OUTPUT_REST}"])
        if parameter == DRAWN_BEND:
            correction = self.adjustable.bends.corrections[element]
            self.write_custom(element + CORRECTION, number_text(correction))
            parameter = EXTRA_BEND
        if parameter == EXTRA_BEND:  # with the correction
            value = self.adjustable.live[f"{element}.{EXTRA_BEND}"]
        holder = self.text.plugin(element)
        for config in holder.iterfind("config"):
            if config.get("key") == parameter:
                config.set("value", number_text(value))
                return
        ElementTree.SubElement(holder, "config", key=parameter, value=number_text(value))

    def _write_softness(self, joint: str) -> None:
        """Write how stiff dry friction is, where that is not what the joint says."""
        dof, said = self.model.joint(joint).dofadr[0], self.spec.joint(joint)
        for attribute, has, says in (
            ("solreffriction", self.model.dof_solref[dof], said.solref_friction),
            ("solimpfriction", self.model.dof_solimp[dof], said.solimp_friction),
        ):
            if not np.array_equal(has, says):
                self.text.element("joint", joint).set(attribute, numbers(has))

    def _write_spring_dampers(self) -> None:
        """Write the stiffness and damping that `springdamper` made of the former masses.

        A joint without a name, or that is not in the text, stays as it is: it may have other ones.
        """
        for joint in self.spec.joints:
            if not joint.springdamper.any() or not joint.name:
                continue
            try:
                written = self.text.element("joint", joint.name)
                compiled = self.model.joint(joint.name)
            except TendonError:
                continue
            set_first(written, "stiffness", compiled.stiffness[0])
            set_first(written, "damping", compiled.damping[0])
            written.set("springdamper", "0 0")  # which a class may give, too

    def _write_mass(self, element: str, value: float) -> None:
        """Write the mass of a body as the model has it by now, and its inertia in proportion."""
        body, written = self.model.body(element), self.text.element("body", element)
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
        inertial.set("mass", number_text(value))

    def _write_actuator(self, element: str, parameter: str) -> None:
        m, written = self.model, self.text.element("actuator", element)
        k = m.actuator(element).id
        if parameter == "gear":
            set_first(written, "gear", m.actuator_gear[k, 0])
        elif parameter in SLIP:
            raise InvalidValueError(
                f"{element}.{parameter}: a slip is of one recording and not of the model; state it"
                " in [known] of that recording"
            )
        elif parameter not in ("kp", "kv"):
            row, user = self.adjustable.commands[k, :3], m.actuator_user[k]
            data = self._user(f"{element}.{parameter}", row, user, "actuator", 2)
            written.set("user", data)
        else:
            set_gains(written, m.actuator_gainprm[k], m.actuator_biasprm[k])

    def _user(self, name: str, row: FloatArray, there: FloatArray, kind: str, fewest: int) -> str:
        """User data that begins with our row; the ``nuser`` of its kind is enlarged to hold it.

        Fewer numbers than ``fewest`` are not ours.
        """
        if not row.any():
            raise InvalidValueError(f"{name}: a scale of 0 with nothing else cannot be written")
        if 0 < len(there) < fewest:
            raise InvalidValueError(
                f"{name}: the model's {kind}s already have user data of {len(there)} numbers, and"
                f" {len(row)} are needed there"
            )
        size, attribute = max(len(row), len(there)), f"nuser_{kind}"
        self.text.section("size", attribute).set(attribute, str(size))
        return numbers([*row, *there[len(row) :]])

    def write_custom(self, name: str, data: str) -> None:
        """Write a custom text in place of one of the same name."""
        custom = self.text.root.find("custom")
        if custom is None:
            custom = ElementTree.SubElement(self.text.root, "custom")
        for old in [t for t in custom.iterfind("text") if t.get("name") == name]:
            custom.remove(old)
        ElementTree.SubElement(custom, "text", name=name, data=data)

    def comment(self, intervals: Mapping[str, tuple[float, float]]) -> None:
        """Begin the text with the parameters that were written."""
        lines = [f" Written by tendon-mj from {self.source.name}, with"]
        for name, value in self.parameters.items():
            within = ", {:.4g} … {:.4g}".format(*intervals[name]) if name in intervals else ""
            lines.append(f"{name} = {value:.6g} [{self.known[name].unit}]{within}")
        text = re.sub("-(?=-)", "- ", "\n       ".join(lines)) + " "  # two would end the comment
        self.text.root.insert(0, ElementTree.Comment(text))

    def check(self, made: Path, path: Path) -> None:
        """Compare the file ``made``, as MuJoCo compiles it, with the model that was simulated."""
        try:
            written = load_model(str(made))
        except TendonError as error:
            raise TendonError(str(error).replace(str(made), str(path))) from error
        read = Adjustable(copy.copy(written)).parameters()
        for name, value in self.parameters.items():
            bend = name.endswith((f".{EXTRA_BEND}", f".{DRAWN_BEND}"))  # a difference of two
            near = {"rel_tol": _AGREE, "abs_tol": _AGREE if bend else 0.0}
            if name not in read or not math.isclose(read[name].value, value, **near):
                got = read[name].value if name in read else "no such parameter"
                raise TendonError(f"{path}: {name} = {value!r} was to be written, it reads {got}")
        mujoco.mj_setConst(self.model, mujoco.MjData(self.model))
        muscles = list(self.muscles)
        pulls = self.model.tendon_stiffness > 0.0  # its own spring, resting where springref says
        parts = {
            **dict.fromkeys(_COMPARED, slice(None)),
            **dict.fromkeys(("actuator_acc0", "actuator_lengthrange"), muscles),
            "tendon_lengthspring": pulls,
            **dict.fromkeys(("dof_solref", "dof_solimp"), self.model.dof_frictionloss > 0.0),
        }
        pairs = {f: (getattr(self.model, f)[k], getattr(written, f)[k]) for f, k in parts.items()}
        pairs["gravity"] = self.model.opt.gravity, written.opt.gravity
        for field, (meant, got) in pairs.items():
            if not np.allclose(meant, got, rtol=_AGREE, atol=_AGREE):
                hint = ""
                if field in ("dof_damping", "jnt_stiffness"):
                    hint = "; a joint with springdamper has to be in the text, by a name"
                raise TendonError(f"{path}: {field} of mjModel was not written as intended{hint}")
