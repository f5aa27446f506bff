"""MJCF as text: a file with its includes as one tree, its elements by name, and back.

`MjSpec.to_xml` writes six digits and no comments; here every number that is not changed stays as it
was written, and so do comments.
"""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Iterable, Sequence
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np

from tendon_mj.errors import InvalidValueError, TendonError, TendonWarning, unknown
from tendon_mj.model_files import files_of_model
from tendon_mj.plugin import NAME
from tendon_mj.whole_file import whole_file

Element = ElementTree.Element
_PROLOG = re.compile(r"^\s*<\?xml.*?\?>|<!DOCTYPE[^\[>]*(?:\[.*?\])?\s*>", re.DOTALL)
# attributes of an actuator that stay where it becomes one of another kind
_KEPT = frozenset(
    {"name", "class", "group", "user", "joint", "jointinparent", "gear", "forcelimited"}
    | {"forcerange", "lengthrange", "nsample", "interp", "delay"}
)
_AGREEMENT = 1e-12  # relative; degrees and radians are not the same to the last bit
# that follow from the order of names and instances, or from where the file lies
_DIFFERENT = ("_", "name", "path", "plugin", "sensor_plugin", "actuator_plugin", "text")


class Mjcf:
    """An MJCF file that MuJoCo can load, its includes in place."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._files = [path]  # this one and its includes
        self._before, self.root, self._after = _parse_mjcf(path)
        self._include(self.root, path)

    def element(self, kind: str, name: str) -> Element:
        """A joint, body, tendon, actuator or sensor by name.

        Raises:
            TendonError: the text has none of this name.
        """
        where = f"worldbody//{kind}" if kind in ("body", "joint") else f"{kind}/*"
        elements = self.root.iterfind(where)
        return self._named(kind, name, {str(e.get("name")): e for e in elements if e.get("name")})

    def actuators(self, model: mujoco.MjModel) -> dict[int, Element]:
        """Number of an actuator in the compiled file → its element, of those in the text."""
        elements = [e for e in self.root.iterfind("actuator/*") if isinstance(e.tag, str)]
        if len(elements) == model.nactuator:
            return dict(enumerate(elements))
        named = {e.get("name"): e for e in elements if e.get("name")}
        names = [model.actuator(k).name for k in range(model.nactuator)]
        return {k: named[name] for k, name in enumerate(names) if name in named}

    def plugin(self, name: str) -> Element:
        """Configuration of a sheath or servo, which may go by its tendon's name; as `element`."""
        inline = [p for p in self.root.iter("plugin") if p.find("config") is not None]
        plugins = {str(i.get("name")): i for i in self.root.iterfind("extension/plugin/instance")}
        for plugin in inline:
            config = {c.get("key"): str(c.get("value")) for c in plugin.iterfind("config")}
            if "tendon" in config and "sensor" not in config:
                plugins.setdefault(config["tendon"], plugin)
        plugins |= {str(p.get("name")): p for p in inline if p.get("name") not in (None, *plugins)}
        return self._named("sheath or servo", name, plugins)

    def _named(self, kind: str, name: str, named: dict[str, Element]) -> Element:
        if name not in named:
            raise TendonError(
                f"{self.path}: {unknown(kind, name, named)}; one that `attach` or `replicate` makes"
                " is not in the text, and cannot be changed there"
            )
        return named[name]

    def section(self, tag: str, attribute: str) -> Element:
        """The last ``tag`` at the top level that sets ``attribute``; created if missing."""
        sections = self.root.findall(tag)
        stating = [s for s in sections if s.get(attribute) is not None]
        if sections:
            return (stating or sections)[-1]
        made = ElementTree.Element(tag)
        self.root.insert(0, made)
        return made

    def move_to(self, folder: Path, spec: mujoco.MjSpec) -> None:
        """Let paths of meshes, textures and models start from a folder; ``spec`` is the file's."""
        here, there = self.path.resolve().parent, folder.resolve()
        for model in self.root.iterfind("asset/model"):
            model.set("file", os.path.relpath(here / str(model.get("file")), there))
        others = (element for element in self.root.iter() if element.tag != "model")
        if any(key.startswith("file") for element in others for key in element.attrib):
            for compiler in self.root.iterfind("compiler"):
                compiler.attrib.pop("assetdir", None)
            for attribute in ("meshdir", "texturedir"):
                at = os.path.relpath(here / str(getattr(spec, attribute)), there)
                self.section("compiler", attribute).set(attribute, at)

    def warn_of_outside(self, written: Path) -> None:
        """Warn that a written file holds text from neither the main file's folder nor below it."""
        here = self.path.parent.resolve()
        files = [file.resolve() for file in self._files]
        outside = ", ".join(str(file) for file in files if not file.is_relative_to(here))
        if outside:
            warnings.warn(
                f"{written} holds the text of {outside}, which {self.path} includes from outside"
                " its folder",
                TendonWarning,
                stacklevel=3,
            )

    def write(self, path: Path) -> None:
        """Write it as one file; see `whole_file` to replace another."""
        ElementTree.indent(self.root)
        parts = [*self._before, self.root, *self._after]
        texts = [ElementTree.tostring(part, encoding="unicode") for part in parts]
        path.write_text("\n".join([*texts, ""]), encoding="utf-8", newline="\n")

    def _include(self, parent: Element, within: Path) -> None:
        """Put included elements in their place; ``within``: file that ``parent`` is in."""
        for child in list(parent):
            if child.tag != "include":
                self._include(child, within)
                continue
            # MuJoCo looks next to the main file, and then next to the one that includes
            name = str(child.get("file"))
            file = self.path.parent / name
            if not file.exists():
                file = within.parent / name
            before, included, after = _parse_mjcf(file)
            self._files.append(file)
            self._include(included, file)
            at = list(parent).index(child)
            parent[at : at + 1] = [*before, *included, *after]


def check_suffix(path: Path) -> None:
    """Refuse a name under which MuJoCo would not read MJCF."""
    if path.suffix != ".xml":
        raise InvalidValueError(
            f"{path}: not the name of an MJCF file; choose a name that ends in .xml"
        )


def set_first(element: Element, attribute: str, value: float) -> None:
    """Set the first number of an attribute and leave the others."""
    others = str(element.get(attribute, "")).split()[1:]
    element.set(attribute, " ".join([number_text(value), *others]))


def set_gains(actuator: Element, gain: Sequence[float], bias: Sequence[float]) -> None:
    """Set the gains of a servo."""
    if actuator.tag == "general":
        actuator.set("gainprm", numbers(gain))
        actuator.set("biasprm", numbers(bias))
        return
    actuator.attrib.pop("dampratio", None)  # which would state kv again, from kp
    actuator.set("kp", number_text(gain[0]))
    actuator.set("kv", number_text(0.0 - bias[2]))


def number_text(value: float) -> str:
    """As text that reads back bit for bit."""
    return repr(float(value)).removesuffix(".0")


def numbers(values: Iterable[float]) -> str:
    """As the text of an attribute with several numbers."""
    return " ".join(map(number_text, values))


def _parse_mjcf(path: Path) -> tuple[list[Element], Element, list[Element]]:
    """The root element of a file, and the comments before and after it."""
    try:
        text = _PROLOG.sub("", path.read_text("utf-8-sig"))
        builder = ElementTree.TreeBuilder(insert_comments=True)
        parser = ElementTree.XMLParser(target=builder)
        around = list(ElementTree.fromstring(f"<file>{text}</file>", parser=parser))
        for element in around:
            element.tail = None
        at = next(k for k, element in enumerate(around) if isinstance(element.tag, str))
    except (OSError, UnicodeDecodeError, ElementTree.ParseError, StopIteration) as error:
        reason = str(error) or "it has no element"
        raise TendonError(f"{path}: cannot be read as MJCF: {reason}") from error
    return around[:at], around[at], around[at + 1 :]


def write_sheaths(source: Path, spec: mujoco.MjSpec, path: Path) -> Path:
    """Write the MJCF of a model with the sheaths that its spec has, and compare it with the spec.

    The spec was read from ``source`` and changed by `add_friction` without a reel. Each number that
    this does not change stays as it is written, with the comments; included files are put in their
    places, with a warning where they are from outside the folder. A file at ``path`` is replaced
    once the new one has been compiled and is the model.
    """
    text, before = Mjcf(source), mujoco.MjSpec.from_file(str(source))
    if not path.parent.is_dir() or path.is_dir():
        raise InvalidValueError(f"{path} must be a file in a folder that exists")
    if path.exists() and any(path.samefile(file) for file in files_of_model(source)):
        raise InvalidValueError(f"{path} is a file that {source} is made of: choose another")
    check_suffix(path)
    absent = _write_tendons(text, before, spec)
    _write_motors(text, before, spec)
    _write_plugins(text, before, spec)
    text.move_to(path.parent, before)
    with whole_file(path) as made:
        text.write(made)
        try:
            _check_written(made, path, spec)
        except (TendonError, ValueError) as error:
            if absent:
                raise _not_in_text(text, absent[0]) from error
            raise
    text.warn_of_outside(path)
    return path


def _section(text: Mjcf, tag: str) -> Element:
    """The last element of the file with this tag; made at its end if there is none."""
    sections = text.root.findall(tag)
    return sections[-1] if sections else ElementTree.SubElement(text.root, tag)


def _write_tendons(text: Mjcf, before: mujoco.MjSpec, spec: mujoco.MjSpec) -> list[str]:
    """Write new cables, and names of the tendons that had none.

    Returns:
        Tendons with a new sheath that are not in the text.
    """
    written = [e for e in text.root.iterfind("tendon/*") if e.tag in ("spatial", "fixed")]
    by_name = {e.get("name"): e for e in written if e.get("name")}
    sheathed = {plugin.config.get("tendon") for plugin in _new_instances(before, spec)}
    absent = []
    for cable in list(spec.tendons)[len(before.tendons) :]:
        off = dict.fromkeys(("limited", "actuatorfrclimited"), "false")
        own = dict.fromkeys(("stiffness", "damping", "frictionloss", "armature"), "0")
        is_fixed = isinstance(cable.path[0].target, mujoco.MjsJoint)
        tag, group = ("fixed" if is_fixed else "spatial"), str(cable.group)
        attributes = {"name": cable.name, "group": group, **off, **own}
        element = ElementTree.SubElement(_section(text, "tendon"), tag, attributes)
        for point in cable.path:
            if is_fixed:
                ElementTree.SubElement(element, "joint", joint=point.target.name, coef="1")
            else:
                ElementTree.SubElement(element, "site", site=point.target.name)
    for k, (old, new) in enumerate(zip(before.tendons, spec.tendons, strict=False)):
        if new.name not in sheathed or old.name in by_name:
            continue
        if old.name:
            absent.append(new.name)
        elif len(written) != len(before.tendons):
            raise _not_in_text(text, new.name)
        else:
            written[k].set("name", new.name)
    return absent


def _write_motors(text: Mjcf, before: mujoco.MjSpec, spec: mujoco.MjSpec) -> None:
    """Write new bodies of motors, and what these or a servo change in a model.

    See `motor.add_motors` and `bam`.
    """
    known = {body.name for body in before.bodies}
    motors = [body for body in spec.worldbody.bodies if body.name not in known]
    for body in motors:
        element = ElementTree.SubElement(_section(text, "worldbody"), "body", name=body.name)
        own = {"pos": "0 0 0", "mass": number_text(body.mass), "diaginertia": numbers(body.inertia)}
        ElementTree.SubElement(element, "inertial", own)
        (joint,) = body.joints
        ElementTree.SubElement(element, "joint", _joint_attributes(joint))
        for site in body.sites:
            own = {"name": site.name, "pos": numbers(site.pos), "group": str(site.group)}
            ElementTree.SubElement(element, "site", own)
    for joint in before.joints:
        new = spec.joint(joint.name) if joint.name else joint
        for attribute in ("armature", "frictionloss", "damping", "springdamper"):
            value = np.ravel(getattr(new, attribute))
            if (np.ravel(getattr(joint, attribute)) != value).any():
                shown = value if attribute == "springdamper" else value[:1]
                text.element("joint", joint.name).set(attribute, numbers(shown))
    _write_actuators(text, before, spec)
    if not motors:
        return
    for element, key in zip(text.root.iterfind("keyframe/key"), spec.keys, strict=True):
        for attribute, values in (("qpos", key.qpos), ("qvel", key.qvel)):
            if len(values):
                element.set(attribute, numbers(values))
    for note in list(spec.texts)[len(before.texts) :]:
        ElementTree.SubElement(_section(text, "custom"), "text", name=note.name, data=note.data)


def _write_actuators(text: Mjcf, before: mujoco.MjSpec, spec: mujoco.MjSpec) -> None:
    """Write joints that actuators turn now, gains, and actuators that became motors of a servo."""
    changed = [
        (k, old, new)
        for k, (old, new) in enumerate(zip(before.actuators, spec.actuators, strict=True))
        if (old.target, old.gaintype, old.biasprm[2]) != (new.target, new.gaintype, new.biasprm[2])
    ]
    elements = text.actuators(before.compile()) if changed else {}
    for k, old, new in changed:
        element = elements[k] if k in elements else text.element("actuator", new.name)
        if old.target != new.target:
            attribute = next(a for a in ("joint", "jointinparent") if element.get(a))
            element.set(attribute, new.target)
        if old.gaintype != new.gaintype:
            _write_servo(element, new)
        elif old.biasprm[2] != new.biasprm[2]:  # that of a damping ratio at the joint
            set_gains(element, new.gainprm, new.biasprm)


def _write_servo(element: Element, motor: mujoco.MjsActuator) -> None:
    """Make an actuator a DC motor of MuJoCo, which keeps what is no gain of it."""
    kept = {name: value for name, value in element.attrib.items() if name in _KEPT}
    limited = int(motor.ctrllimited) == 1
    own = dict.fromkeys(("dyntype", "gaintype", "biastype"), "dcmotor") | {"input": "pos"}
    own |= {"actearly": "true", "actlimited": "false", "dynprm": "0"}
    own |= {"ctrllimited": str(limited).lower(), "gainprm": numbers(motor.gainprm)}
    own |= {"biasprm": numbers(motor.biasprm)}
    element.tag = "general"
    element.attrib.clear()
    element.attrib |= kept | own
    if limited:
        element.set("ctrlrange", numbers(motor.ctrlrange))


def _joint_attributes(joint: mujoco.MjsJoint) -> dict[str, str]:
    """Attributes of a motor's joint, none of which is left to the model's defaults."""
    is_slide = joint.type == mujoco.mjtJoint.mjJNT_SLIDE
    limits = {"0": "false", "1": "true", "2": "auto"}
    off = dict.fromkeys(("stiffness", "frictionloss", "springref", "margin"), "0")
    return {
        "name": joint.name,
        "type": "slide" if is_slide else "hinge",
        "axis": numbers(joint.axis),
        "pos": "0 0 0",
        "ref": number_text(joint.ref),
        "limited": "false",
        "range": numbers(joint.range),
        "actuatorfrclimited": limits[str(int(joint.actfrclimited))],
        "actuatorfrcrange": numbers(joint.actfrcrange),
        "armature": number_text(joint.armature),
        "damping": number_text(joint.damping[0]),
        "springdamper": "0 0",
        "actuatorgravcomp": "false",
        **off,
    }


def _not_in_text(text: Mjcf, tendon: str) -> TendonError:
    return TendonError(
        f"{text.path}: tendon {tendon!r} is not in the text, as one that `attach` or `replicate` "
        "makes; give it friction in Python and write it with MjSpec.to_xml"
    )


def _new_instances(before: mujoco.MjSpec, spec: mujoco.MjSpec) -> list[mujoco.MjsPlugin]:
    """Instances of the plugin that a spec has and had not."""
    known = {plugin.name for plugin in before.plugins}
    return [p for p in spec.plugins if p.plugin_name == NAME and p.name not in known]


def _write_plugins(text: Mjcf, before: mujoco.MjSpec, spec: mujoco.MjSpec) -> None:
    """Write new instances, and the sensors that were added after the model's own."""
    extension = _section(text, "extension")
    holders = [p for p in text.root.iterfind("extension/plugin") if p.get("plugin") == NAME]
    holder = holders[-1] if holders else ElementTree.SubElement(extension, "plugin", plugin=NAME)
    for plugin in _new_instances(before, spec):
        instance = ElementTree.SubElement(holder, "instance", name=plugin.name)
        for key, value in plugin.config.items():
            ElementTree.SubElement(instance, "config", key=key, value=value)
    for sensor in list(spec.sensors)[len(before.sensors) :]:
        attributes = {"name": sensor.name, "plugin": NAME, "instance": sensor.plugin.name}
        if sensor.objtype == mujoco.mjtObj.mjOBJ_TENDON:
            attributes |= {"objtype": "tendon", "objname": sensor.objname}
        ElementTree.SubElement(_section(text, "sensor"), "plugin", attributes)


def _check_written(written: Path, path: Path, spec: mujoco.MjSpec) -> None:
    """Compare a file, as MuJoCo compiles it, with the model that it is to hold."""
    again = mujoco.MjSpec.from_file(str(written))
    meant, got = spec.compile(), again.compile()
    for field in dir(meant):
        expected, actual = getattr(meant, field), getattr(got, field)
        if (
            not isinstance(expected, np.ndarray)
            or field.startswith(_DIFFERENT)
            or "path" in field
            or (
                np.shape(expected) == np.shape(actual)
                and np.allclose(expected, actual, rtol=_AGREEMENT, atol=_AGREEMENT)
            )
        ):
            continue
        raise TendonError(f"{path}: {field} of mjModel differs from the model with sheaths")
    configs = [{p.name: p.config for p in s.plugins if p.name} for s in (spec, again)]
    if configs[0] != configs[1]:
        raise TendonError(f"{path}: the plugins differ from those of the model with sheaths")
