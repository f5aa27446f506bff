"""TOML text that a user wrote, read by `tomllib` with errors that name the file."""

from __future__ import annotations

import re
import tomllib
from typing import Any, Final

from tendon_mj.errors import RecordingError

MOST_PARTS: Final = 100  # of a key between dots; tomllib's time grows as their square
MOST_DIGITS: Final = 1000  # of an integer; above 308 it is no float, and Python prints 4300

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
_LONG_INTEGER = re.compile(
    rf"(?<![\w.-])[+-]?(?:0x[\da-fA-F_]{{{MOST_DIGITS},}}|(?:0[ob])?[\d_]{{{MOST_DIGITS},}})"
    r"(?![\w.-]|[ \t]*=)"  # what goes on is a float, or a key
)


def read_toml(text: str, where: str) -> dict[str, Any]:
    """TOML text as plain values; messages begin with ``where``, the file.

    Raises `RecordingError` for broken TOML, naming its row, for a key of more than `MOST_PARTS`
    parts between dots, and for an integer of `MOST_DIGITS` digits or more, hexadecimal or not.
    """
    bare = _TEXT_OR_COMMENT.sub(_without_dots, text)
    for found, what in (
        (
            _DEEP_KEY.search(bare),
            f"a key has more than {MOST_PARTS} parts between dots; a name that has dots is written"
            " in quotes",
        ),
        (
            _LONG_INTEGER.search(bare),
            f"an integer has {MOST_DIGITS} digits or more; a number is written such as 1.5e6",
        ),
    ):
        if found:
            line = bare.count("\n", 0, found.start()) + 1
            raise RecordingError(f"{where}, line {line}: {what}")
    try:
        return tomllib.loads(text)
    except ValueError as error:
        raise RecordingError(f"{where}: not TOML: {error}") from None
    except RecursionError:
        raise RecordingError(f"{where}: not TOML: brackets are nested too deeply") from None


def _without_dots(found: re.Match[str]) -> str:
    """One letter in place of a text, which may be a part of a key, none of a comment; its lines."""
    return ("" if found[0].startswith("#") else "t") + "\n" * found[0].count("\n")
