"""Files that a model is made of; none may be a pipe, which MuJoCo would wait for, or a device."""

from __future__ import annotations

import html
import re
import stat
from collections.abc import Iterator
from pathlib import Path

from tendon_mj.errors import TendonError

_VALUE = r"(?:\"[^\"]*\"|'[^']*')"
_TAG = re.compile(rf"<([\w:.-]+)(?=[\s/>])((?:\s*[\w:.-]+\s*=\s*{_VALUE})*)")
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_ATTRIBUTE = re.compile(rf"([\w:.-]+)\s*=\s*({_VALUE})")
_PLAIN = (stat.S_IFREG, stat.S_IFDIR, 0)  # kinds of files for which nothing waits
_FOLDERS = ("meshdir", "texturedir", "assetdir")


def check_model_files(path: Path) -> list[Path]:
    """Refuse a model that names a device or pipe, before MuJoCo opens it.

    What is no XML or is not there is left to MuJoCo, which says so.

    Returns:
        `files_of_model`.

    Raises:
        TendonError: names the model, the element and the file.
    """
    files = [path]
    for tag, file in _named_files(path):
        if _kind(file) not in _PLAIN:
            raise TendonError(
                f"{path}: <{tag}> names {file}, which is a device or pipe; give a file in its place"
            )
        files.append(file)
    return _there(files)


def files_of_model(path: Path) -> list[Path]:
    """A model's file, and those that it or a model in it includes or takes a mesh or the like from.

    Empty where none is there, as for a name of the package's models.
    """
    return _there([path, *(file for _, file in _named_files(path))])


def _there(files: list[Path]) -> list[Path]:
    return [file for file in files if _kind(file) == stat.S_IFREG]


def _named_files(path: Path) -> Iterator[tuple[str, Path]]:
    """Elements that name a file, and each place where MuJoCo would look for it.

    A file that is included is read after it was yielded.
    """
    models, seen = [path], {_place(path)}
    while models:
        main = models.pop()
        includes, assets, folders, strips = [main], list[tuple[str, str]](), {main.parent}, False
        while includes:
            here = includes.pop()
            folders.add(here.parent)
            for tag, attributes in _elements(_text(here)):
                strips |= tag == "robot" or attributes.get("strippath") == "true"  # URDF does, too
                folders |= {main.parent / attributes[f] for f in _FOLDERS if f in attributes}
                for name in (text for key, text in attributes.items() if key.startswith("file")):
                    assets.append((tag, name))
                    # MuJoCo looks beside the main file, and then beside the one that includes
                    for file in (main.parent / name, here.parent / name):
                        place = _place(file)
                        if tag in ("include", "model") and place is not None and place not in seen:
                            yield tag, file
                            seen.add(place)
                            (includes if tag == "include" else models).append(file)
        for tag, name in assets:
            for folder in folders:
                yield tag, folder / (Path(name).name if strips else name)


def _kind(file: Path) -> int:
    """Kind of a file, as `stat.S_IFMT` has it; 0 where none is there, or can be."""
    try:
        return stat.S_IFMT(file.stat().st_mode)
    except (OSError, ValueError):
        return 0


def _place(file: Path) -> tuple[int, int, str] | None:
    """Folder and name of a file, the same for whatever path to it; None where no folder is."""
    try:
        folder = file.parent.stat()
    except (OSError, ValueError):
        return None
    return folder.st_dev, folder.st_ino, file.name


def _elements(text: str) -> Iterator[tuple[str, dict[str, str]]]:
    """Tag and attributes of each element, of broken XML too."""
    for found in _TAG.finditer(_COMMENT.sub("", text)):
        yield (
            found[1],
            {one[1]: html.unescape(one[2][1:-1]) for one in _ATTRIBUTE.finditer(found[2])},
        )


def _text(path: Path) -> str:
    try:
        return path.read_text("utf-8", "surrogateescape") if _kind(path) in _PLAIN else ""
    except (OSError, ValueError):
        return ""
