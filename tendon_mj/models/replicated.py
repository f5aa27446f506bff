"""Sheaths that a `<replicate>` would copy, where MuJoCo 3.17 crashes; found in the text."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from tendon_mj.attach import Element, Mjcf
from tendon_mj.errors import TendonError

_OURS = "tendon_mj."  # begins the names of the plugins
_ROOT = re.compile(rb"<mujoco[\s>]")  # and not of what is included
_REFERS = {  # attribute, or type of object → tag of what it names
    **{key: key for key in ("site", "geom", "joint", "tendon", "body")},
    **dict.fromkeys(("sidesite", "cranksite", "slidersite", "refsite"), "site"),
    "jointinparent": "joint",
    "xbody": "body",
}
_MJCF = (".xml", ".mjcf")  # of models in a model, and of what they include


def check_replicated(path: Path, files: Iterable[Path]) -> None:
    """Refuse a model in which MuJoCo would copy a reference to a sheath, before MuJoCo reads it.

    While it copies a sensor or an actuator that refers to a plugin instance by name, it goes
    through the list of instances to which it adds. It copies those whose object is copied, and
    sensors without an object always. What is no MJCF at all is left to MuJoCo, which says so.

    Args:
        path: MJCF file of the model.
        files: that it is made of, see `files_of_model`.

    Raises:
        TendonError: names the model, the sensor or actuator, and what to write.
    """
    models = dict.fromkeys(file for file in files if file == path or file.suffix in _MJCF)
    texts = {file: file.read_bytes() for file in models}
    together = b"".join(texts.values())
    if b"<replicate" not in together or _OURS.encode() not in together:
        return
    for file, text in texts.items():
        if not _ROOT.search(text):
            continue
        try:
            root = Mjcf(file).root
        except (TendonError, OSError, ValueError) as error:  # MuJoCo may read it all the same
            raise TendonError(
                f"{error}; in a model with <replicate>, which MuJoCo may crash over where it copies"
                " a sheath, the text has to be XML in UTF-8"
            ) from None
        _check_copies(file, root)


def _check_copies(file: Path, root: Element) -> None:
    """Refuse a sensor or an actuator of our plugins that would be copied."""
    replicates = list(root.iter("replicate"))
    if not replicates:
        return
    copied = {(e.tag, e.get("name")) for copies in replicates for e in copies.iter()}
    for tendon in root.iterfind("tendon/*"):
        if any(copied & _referred(part) for part in tendon):
            copied.add(("tendon", tendon.get("name")))
    ours = {
        instance.get("name")
        for plugin in root.iterfind("extension/plugin")
        if plugin.get("plugin", "").startswith(_OURS)
        for instance in plugin.iterfind("instance")
    }
    for kind in ("sensor", "actuator"):
        for element in root.iterfind(f"{kind}/plugin"):
            if element.get("instance") not in ours:
                continue
            where, both = f"{file}: {kind} {element.get('name', '')!r}", copied & _referred(element)
            if kind == "sensor" and element.get("objname") is None:
                raise TendonError(
                    f"{where} shows a sheath and has no object; MuJoCo copies such a sensor in each"
                    ' <replicate>, and crashes: give it objtype="tendon" and the tendon\'s name as'
                    " objname"
                )
            if both:
                tag, name = min(both)
                raise TendonError(
                    f"{where} is on {tag} {name!r}, which a <replicate> copies with it;"
                    " MuJoCo may crash over the copies of its plugin instance: leave it out, give"
                    " the copies friction in Python, with tendon_mj.add_friction, and write them"
                    " with MjSpec.to_xml"
                )


def _referred(element: Element) -> set[tuple[str, str]]:
    """Tag and name of whatever an element of a path, a sensor or an actuator refers to."""
    found = {(_REFERS[key], name) for key, name in element.attrib.items() if key in _REFERS}
    kind = element.get("objtype", "")
    return found | {(_REFERS.get(kind, kind), element.get("objname", ""))}
