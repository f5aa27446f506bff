"""Sheaths that a `<replicate>` would copy, where MuJoCo 3.17 crashes; found in the text."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tendon_mj.attach.mjcf import Element, Mjcf
from tendon_mj.errors import TendonError
from tendon_mj.model_files import files_of_model

_OURS = "tendon_mj."  # begins the names of the plugins
_MJCF = (".xml", ".mjcf")  # of models in a model


def check_replicated(path: Path) -> None:
    """Refuse a model in which MuJoCo would copy a reference to a sheath, before MuJoCo reads it.

    While it copies a sensor or an actuator that refers to a plugin instance by name, it goes
    through the list of instances to which it adds. It copies those whose object is copied, and
    sensors without an object always. What cannot be read is left to MuJoCo, which says so.

    Raises:
        TendonError: names the model, the sensor or actuator, and what to write.
    """
    models = (file for file in files_of_model(path) if file == path or file.suffix in _MJCF)
    for file in filter(_may_replicate, models):
        try:
            root = Mjcf(file).root
        except (TendonError, OSError, ValueError):  # also a name that no file can have
            continue
        for fault in _copied(root):
            raise TendonError(f"{file}: {fault}")


def _may_replicate(file: Path) -> bool:
    """Whether something is replicated in a file, or may be in what it includes."""
    text = file.read_bytes()
    return b"<replicate" in text or b"<include" in text


def _copied(root: Element) -> Iterator[str]:
    """What is wrong with each sensor and actuator of our plugins that would be copied."""
    replicates = list(root.iter("replicate"))
    if not replicates:
        return
    sites = {site.get("name") for copies in replicates for site in copies.iter("site")}
    copied = {
        tendon.get("name")
        for tendon in root.iterfind("tendon/spatial")
        if any(site.get("site") in sites for site in tendon.iterfind("site"))
    }
    for kind, attribute in (("sensor", "objname"), ("actuator", "tendon")):
        for element in root.iterfind(f"{kind}/plugin"):
            if not element.get("plugin", "").startswith(_OURS) or not element.get("instance"):
                continue
            where = f"{kind} {element.get('name', '')!r}"
            on = element.get(attribute)
            if on is None and kind == "sensor":
                yield (
                    f"{where} shows a sheath and has no object; MuJoCo copies such a sensor in each"
                    ' <replicate>, and crashes: give it objtype="tendon" and the tendon\'s name as'
                    " objname"
                )
            elif on in copied:
                yield (
                    f"{where} is on tendon {on!r}, which a <replicate> copies with it; MuJoCo may"
                    " crash over the copies of its plugin instance: leave it out, give the copies"
                    " friction in Python, with tendon_mj.add_friction, and write them with"
                    " MjSpec.to_xml"
                )
