"""MJCF as text: a file with all that it includes as one tree, its elements by name, and back.

MuJoCo's own `to_xml` writes numbers with six digits, so that a model that went through it is
another one; here every number that is not changed stays as it was written.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import mujoco

from tendon_mj.errors import InvalidValueError, TendonError, TendonWarning, unknown
from tendon_mj.whole_file import whole_file

Element = ElementTree.Element


class Mjcf:
    """An MJCF file, its includes in place.

    Args:
        path: of the main file, one that MuJoCo can load.

    Raises:
        TendonError: a file that is included cannot be read, or is included in itself.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        built = _Builder()
        self.root = _parse(path, built)
        self._files = [path]  # this one and all that it includes
        self._before, self._after = built.before, built.after
        self._include(self.root, [path])

    def joint(self, name: str) -> Element:
        """A joint by name; this and the next raise `TendonError` where the text has none."""
        bodies = self.root.findall("worldbody")
        return self._named("joint", name, (j for body in bodies for j in body.iter("joint")))

    def body(self, name: str) -> Element:
        """A body by name."""
        worlds = self.root.findall("worldbody")
        return self._named("body", name, (b for world in worlds for b in world.iter("body")))

    def actuator(self, name: str) -> Element:
        """An actuator of any kind by name."""
        return self._named("actuator", name, self.root.iterfind("actuator/*"))

    def actuators(self, model: mujoco.MjModel) -> dict[int, Element]:
        """Number of an actuator in the compiled file → its element, of those in the text."""
        elements = [e for e in self.root.iterfind("actuator/*") if isinstance(e.tag, str)]
        if len(elements) == model.nactuator:
            return dict(enumerate(elements))
        named = {e.get("name"): e for e in elements if e.get("name")}
        names = [model.actuator(k).name for k in range(model.nactuator)]
        return {k: named[name] for k, name in enumerate(names) if name in named}

    def sensor(self, name: str) -> Element:
        """A sensor of any kind by name."""
        return self._named("sensor", name, self.root.iterfind("sensor/*"))

    def plugin(self, name: str) -> Element:
        """Configuration of a sheath or servo, which may go by its tendon's name."""
        instances = list(self.root.iterfind("extension/plugin/instance"))
        inline = [p for p in self.root.iter("plugin") if p.find("config") is not None]
        found = {str(i.get("name")): i for i in instances}
        for plugin in inline:
            config = {c.get("key"): str(c.get("value")) for c in plugin.iterfind("config")}
            if "tendon" in config and "sensor" not in config:
                found.setdefault(config["tendon"], plugin)
        found |= {str(p.get("name")): p for p in inline if p.get("name") not in (None, *found)}
        return self._named("sheath or servo", name, (), found)

    def _named(
        self, kind: str, name: str, among: Iterable[Element], more: dict[str, Element] | None = None
    ) -> Element:
        found = {str(e.get("name")): e for e in among if e.get("name")} | (more or {})
        if name not in found:
            raise TendonError(
                f"{self.path}: {unknown(kind, name, found)}; one that `attach` or `replicate` makes"
                " is not in the text, and cannot be changed there"
            )
        return found[name]

    def section(self, tag: str, attribute: str) -> Element:
        """The top-level element that has the last word on an attribute; made if there is none."""
        sections = self.root.findall(tag)
        having = [s for s in sections if s.get(attribute) is not None]
        if having or sections:
            return (having or sections)[-1]
        made = ElementTree.Element(tag)
        self.root.insert(0, made)
        return made

    def move_to(self, folder: Path, spec: mujoco.MjSpec) -> None:
        """Let meshes, textures and models be found from another folder; ``spec`` is the file's."""
        here, there = self.path.resolve().parent, folder.resolve()
        for model in self.root.iterfind("asset/model"):
            model.set("file", os.path.relpath(here / str(model.get("file")), there))
        if any(_files_of(e) for e in self.root.iter() if e.tag != "model"):
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
        """Write it as one file."""
        ElementTree.indent(self.root)
        parts = [*self._before, self.root, *self._after]
        texts = [ElementTree.tostring(part, encoding="unicode") for part in parts]
        with whole_file(path) as made:
            made.write_text("\n".join([*texts, ""]), encoding="utf-8", newline="\n")

    def _include(self, parent: Element, chain: list[Path]) -> None:
        """Put what is included in its place; ``chain``: files, each of which includes the next."""
        for child in list(parent):
            if child.tag != "include":
                self._include(child, chain)
                continue
            # MuJoCo looks beside the main file, and then beside the one that includes
            name = str(child.get("file"))
            file = self.path.parent / name
            if not file.exists():
                file = chain[-1].parent / name
            if file.resolve() in map(Path.resolve, chain):
                raise TendonError(f"{chain[-1]}: {name} is included in itself")
            built = _Builder()
            included = _parse(file, built)
            self._files.append(file)
            self._include(included, [*chain, file])
            at = list(parent).index(child)
            parent[at : at + 1] = [*built.before, *included, *built.after]


def check_suffix(path: Path) -> None:
    """Refuse a name for MJCF under which MuJoCo would not read it.

    Raises:
        InvalidValueError: names the file.
    """
    if path.suffix != ".xml":
        raise InvalidValueError(f"{path}: what is written is MJCF; choose a name that ends in .xml")


def set_first(element: Element, attribute: str, value: float) -> None:
    """Set the first number of an attribute and leave the ones behind it."""
    behind = str(element.get(attribute, "")).split()[1:]
    element.set(attribute, " ".join([number(value), *behind]))


def number(value: float) -> str:
    """As text that reads back bit for bit."""
    return repr(float(value)).removesuffix(".0")


def numbers(values: Iterable[float]) -> str:
    """As the text of an attribute with several numbers."""
    return " ".join(map(number, values))


def _files_of(element: Element) -> list[str]:
    """Files that an element names: a mesh has one, a cube's texture up to six."""
    return [value for key, value in element.attrib.items() if key.startswith("file")]


class _Builder(ElementTree.TreeBuilder):
    """Builds a tree with its comments, and keeps those before and after its root."""

    def __init__(self) -> None:
        super().__init__(insert_comments=True)
        self.before: list[ElementTree.Element[Any]] = []
        self.after: list[ElementTree.Element[Any]] = []
        self._around, self._open = self.before, 0

    def start(self, tag: str, attrs: dict[str, str], /) -> Element:
        self._around, self._open = self.after, self._open + 1
        return super().start(tag, attrs)

    def end(self, tag: str, /) -> Element:
        self._open -= 1
        return super().end(tag)

    def comment(self, text: str | None, /) -> ElementTree.Element[Any]:
        if self._open:
            return super().comment(text)
        self._around.append(ElementTree.Comment(text))
        return self._around[-1]


def _parse(path: Path, builder: _Builder) -> Element:
    try:
        text = path.read_text("utf-8-sig")
        return ElementTree.fromstring(text, parser=ElementTree.XMLParser(target=builder))
    except (OSError, ElementTree.ParseError) as error:
        raise TendonError(f"{path}: cannot be read as MJCF: {error}") from error
    except UnicodeDecodeError as error:
        row = error.object.count(b"\n", 0, error.start) + 1
        byte = error.object[error.start]
        raise TendonError(
            f"{path}, row {row}: byte 0x{byte:02x} is not UTF-8; save the file as UTF-8"
        ) from None
