"""Text files of a recording, read with errors that say where they are broken."""

from __future__ import annotations

from pathlib import Path

from tendon_mj.errors import RecordingError, unknown


def read_text(path: Path, hint: str = "") -> str:
    """Read a UTF-8 text file (a byte-order mark is dropped), every line end turned into ``\\n``.

    ``hint`` is appended to the message when there is no such file. Raises `RecordingError` for a
    missing file (naming the nearest of the same kind beside it), one that cannot be opened, and
    one that is not UTF-8 (naming row and column).
    """
    try:
        return path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise RecordingError(f"{path}: {_missing(path)}{hint}") from None
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {error.strerror}") from error
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
