"""MJCF files that a model is made of."""

from __future__ import annotations

import html
import re
from pathlib import Path

_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_NAMED = re.compile(r"<(include|model)\s[^>]*?\bfile\s*=\s*(?:\"([^\"]*)\"|'([^']*)')")


def files_of_model(path: Path) -> list[Path]:
    """A model's file, and those that it includes or attaches; missing ones are left out.

    MuJoCo looks beside the model's file, and then beside the one that includes. Text that is not
    XML is searched too, since MuJoCo reads more than a strict parser does.
    """
    files, todo, seen = list[Path](), [(path, path.parent)], {path.resolve()}
    while todo:
        file, main = todo.pop()
        files.append(file)
        text = _COMMENT.sub("", file.read_text("utf-8", "surrogateescape"))
        for tag, *names in _NAMED.findall(text):
            for folder in (main, file.parent):
                other = folder / html.unescape("".join(names))
                if other.is_file() and other.resolve() not in seen:
                    seen.add(other.resolve())
                    todo.append((other, main if tag == "include" else other.parent))
    return files
