"""Writes a model's MJCF with the sheaths that its spec was given, all else as it was written."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np

from tendon_mj.attach.mjcf import Element, Mjcf, check_suffix
from tendon_mj.errors import InvalidValueError, TendonError
from tendon_mj.model_files import files_of_model
from tendon_mj.plugin import NAME
from tendon_mj.whole_file import whole_file

_AGREE = 1e-12  # relative; degrees and radians are not the same to the last bit
# what follows from the order of names and instances, or from where the file lies
_BESIDES = ("_", "name", "path", "plugin", "sensor_plugin", "actuator_plugin", "text")


def write_sheaths(source: Path, spec: mujoco.MjSpec, path: Path) -> Path:
    """Write the MJCF of a model with the sheaths that its spec has, and hold it against the spec.

    `MjSpec.to_xml` writes six digits; here each number that `add_friction` does not change stays as
    it is written, with the comments; included files are put in their places. What is at ``path``
    is replaced once the new file has been compiled, and stays where it cannot be.

    Args:
        source: MJCF file that ``spec`` was read from.
        spec: changed by `add_friction` without a reel, and nothing else.
        path: file to write, in an existing folder.

    Returns:
        The path.

    Warns:
        TendonWarning: the model includes files from outside its folder, whose text is written too.

    Raises:
        InvalidValueError: a path that is no place for a file, or a file that the model is made of.
        TendonError: a tendon that `attach` or `replicate` makes, which is not in the text; or the
            written file is not the model.
    """
    text, before = Mjcf(source), mujoco.MjSpec.from_file(str(source))
    if not path.parent.is_dir() or path.is_dir():
        raise InvalidValueError(f"{path} must be a file in a folder that exists")
    if path.exists() and any(path.samefile(file) for file in files_of_model(source)):
        raise InvalidValueError(f"{path} is a file that {source} is made of: choose another")
    check_suffix(path)
    absent = _write_tendons(text, before, spec)
    _write_instances(text, before, spec)
    _write_sensors(text, before, spec)
    text.move_to(path.parent, before)
    with whole_file(path) as beside:
        text.write(beside)
        try:
            _check(beside, path, spec)
        except (TendonError, ValueError) as error:
            if absent:
                raise _not_in_text(text, absent[0]) from error
            raise
    text.warn_of_outside(path)
    return path


def _section(text: Mjcf, tag: str) -> Element:
    """The last element of the file with this tag; made at its end if there is none."""
    found = text.root.findall(tag)
    return found[-1] if found else ElementTree.SubElement(text.root, tag)


def _write_tendons(text: Mjcf, before: mujoco.MjSpec, spec: mujoco.MjSpec) -> list[str]:
    """Write names of the tendons that had none; return those with a new sheath not in the text."""
    written = [e for part in text.root.findall("tendon") for e in part if _is_tendon(e)]
    by_name = {e.get("name"): e for e in written if e.get("name")}
    sheathed = {plugin.config.get("tendon") for plugin in _new_instances(before, spec)}
    absent = []
    for k, (old, new) in enumerate(zip(before.tendons, spec.tendons, strict=True)):
        if new.name not in sheathed or old.name in by_name:
            continue
        if old.name:
            absent.append(new.name)
        elif len(written) != len(before.tendons):
            raise _not_in_text(text, new.name)
        else:
            written[k].set("name", new.name)
    return absent


def _not_in_text(text: Mjcf, tendon: str) -> TendonError:
    return TendonError(
        f"{text.path}: tendon {tendon!r} is not in the text, as one that `attach` or `replicate` "
        "makes; give it friction in Python and write it with MjSpec.to_xml"
    )


def _is_tendon(element: Element) -> bool:
    return element.tag in ("spatial", "fixed")


def _new_instances(before: mujoco.MjSpec, spec: mujoco.MjSpec) -> list[mujoco.MjsPlugin]:
    """Instances of the plugin that a spec has and had not."""
    known = {plugin.name for plugin in before.plugins}
    return [p for p in spec.plugins if p.plugin_name == NAME and p.name not in known]


def _write_instances(text: Mjcf, before: mujoco.MjSpec, spec: mujoco.MjSpec) -> None:
    extension = _section(text, "extension")
    holders = [p for p in text.root.iterfind("extension/plugin") if p.get("plugin") == NAME]
    holder = holders[-1] if holders else ElementTree.SubElement(extension, "plugin", plugin=NAME)
    for plugin in _new_instances(before, spec):
        instance = ElementTree.SubElement(holder, "instance", name=plugin.name)
        for key, value in plugin.config.items():
            ElementTree.SubElement(instance, "config", key=key, value=value)


def _write_sensors(text: Mjcf, before: mujoco.MjSpec, spec: mujoco.MjSpec) -> None:
    for sensor in list(spec.sensors)[len(before.sensors) :]:
        attributes = {"name": sensor.name, "plugin": NAME, "instance": sensor.plugin.name}
        if sensor.objtype == mujoco.mjtObj.mjOBJ_TENDON:
            attributes |= {"objtype": "tendon", "objname": sensor.objname}
        ElementTree.SubElement(_section(text, "sensor"), "plugin", attributes)


def _check(written: Path, path: Path, spec: mujoco.MjSpec) -> None:
    """Hold a file, as MuJoCo compiles it, against the model that was to be written."""
    again = mujoco.MjSpec.from_file(str(written))
    meant, got = spec.compile(), again.compile()
    for field in dir(meant):
        one, other = getattr(meant, field), getattr(got, field)
        if not isinstance(one, np.ndarray) or field.startswith(_BESIDES) or "path" in field:
            continue
        if one.shape != other.shape or not np.allclose(one, other, rtol=_AGREE, atol=_AGREE):
            raise TendonError(f"{path}: {field} of mjModel is not what was to be written")
    configs = [{p.name: p.config for p in s.plugins if p.name} for s in (spec, again)]
    if configs[0] != configs[1]:
        raise TendonError(f"{path}: the plugins are not what was to be written")
