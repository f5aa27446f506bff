"""Files of a recording, opened with errors that say where they are broken."""

from __future__ import annotations

import stat
from pathlib import Path

from tendon_mj.errors import RecordingError, unknown

LARGEST = 2**31  # of a file [bytes]: days at 1 kHz


def check_file(path: Path, hint: str = "") -> None:
    """Raise `RecordingError` unless there is a regular file that can be opened, not too large.

    ``hint`` is appended to the message when there is no such file, which names the nearest of the
    same kind beside it.
    """
    try:
        there = path.stat()
        if not (stat.S_ISREG(there.st_mode) or stat.S_ISDIR(there.st_mode)):
            # opened, a pipe would wait for its writer and a device might never end
            raise RecordingError(f"{path}: a device or pipe; give a regular file")
        with path.open("rb"):
            pass
    except FileNotFoundError:
        raise RecordingError(f"{path}: {_missing(path)}{hint}") from None
    except RecordingError:
        raise
    except (OSError, ValueError) as error:  # ValueError: a name that no file can have
        reason = getattr(error, "strerror", None) or error
        raise RecordingError(f"{path}: cannot be read: {reason}") from error
    if there.st_size > LARGEST:
        raise RecordingError(
            f"{path}: {there.st_size} bytes, more than {LARGEST}; split the recording"
        )


def read_text(path: Path, hint: str = "") -> str:
    """Read a UTF-8 text file (a byte-order mark is dropped), every line end turned into ``\\n``.

    Raises `RecordingError` for what `check_file` refuses, and for a file that is not UTF-8 (naming
    row and column).
    """
    check_file(path, hint)
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        before = error.object[: error.start].splitlines() or [b""]
        at_line_start = error.object[: error.start].endswith((b"\n", b"\r"))
        row = len(before) + at_line_start
        column = 1 if at_line_start else before[-1].count(b",") + 1
        raise RecordingError(
            f"{path}, row {row}, column {column}: byte 0x{error.object[error.start]:02x} is not"
            " UTF-8; save the file as UTF-8"
        ) from None


def _missing(path: Path) -> str:
    if not path.parent.is_dir():
        return f"no such file, nor a folder {str(path.parent)!r}"
    beside = [p.name for p in path.parent.iterdir() if p.suffix == path.suffix and p.is_file()]
    return f"no such file: {unknown('file', path.name, beside)}"
