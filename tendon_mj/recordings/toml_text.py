"""TOML text that a user wrote, read by `tomllib` with errors that name the file."""

from __future__ import annotations

import re
import tomllib
from typing import Any, Final

from tendon_mj.errors import RecordingError

MOST_PARTS: Final = 100  # of a key between dots; tomllib's time grows as their square

# An end that is missing is no failure here: tomllib stops at such a text or comment.
_TEXT_OR_COMMENT = re.compile(
    r'"""[^"\\]*(?:(?:\\.|"{1,2}(?!"))[^"\\]*)*(?:"{3,5})?'
    r"|'''[^']*(?:'{1,2}(?!')[^']*)*(?:'{3,5})?"
    r'|"[^"\\\n]*(?:\\[^\n][^"\\\n]*)*"?'
    r"|'[^'\n]*'?"
    r"|#[^\n]*",
    re.DOTALL,
)
_DEEP_KEY = re.compile(rf"(?<![\w-])(?:[\w-]+[ \t]*\.[ \t]*){{{MOST_PARTS}}}")


def read_toml(text: str, where: str) -> dict[str, Any]:
    """TOML text as plain values; messages begin with ``where``, the file.

    Raises `RecordingError` for broken TOML, naming its row, and for a key of more than
    `MOST_PARTS` parts between dots.
    """
    bare = _TEXT_OR_COMMENT.sub(_without_dots, text)
    deep = _DEEP_KEY.search(bare)
    if deep:
        line = bare.count("\n", 0, deep.start()) + 1
        raise RecordingError(
            f"{where}, line {line}: a key has more than {MOST_PARTS} parts between dots; a name"
            " that has dots is written in quotes"
        )
    try:
        return tomllib.loads(text)
    except ValueError as error:  # also an integer of 5000 digits
        raise RecordingError(f"{where}: not TOML: {error}") from None
    except RecursionError:
        raise RecordingError(f"{where}: not TOML: brackets are nested too deeply") from None


def _without_dots(found: re.Match[str]) -> str:
    """One letter in place of a text, which may be a part of a key, none of a comment; its lines."""
    return ("" if found[0].startswith("#") else "t") + "\n" * found[0].count("\n")
