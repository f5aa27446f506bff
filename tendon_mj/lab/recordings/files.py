"""Files of a recording: where they are, their formats, and text with errors that say where."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from tendon_mj.errors import RecordingError, unknown

FORMATS = (".csv", ".parquet", ".mcap")  # in the order in which a stem is sought
_AS_CSV = (".txt", ".tsv", ".dat", ".log")  # read as CSV where a path names them


def check_format(path: Path) -> None:
    """Raise `RecordingError` unless a file has a format that is read, by its suffix."""
    if path.suffix.lower() not in (*FORMATS, *_AS_CSV):
        kind = f"a {path.suffix} file" if path.suffix else "a file without a suffix"
        raise RecordingError(
            f"{path}: {kind} is not read; CSV, Parquet and MCAP are, and docs/recording.md shows"
            " how to convert others"
        )


def tables_in(path: Path) -> list[Path]:
    """The tables in a folder; of a file, or the stem of a recording, the path itself."""
    if not path.is_dir() or (path.name not in ("", "..") and table_beside(path)[0].is_file()):
        return [path]
    tables = sorted(p for p in path.iterdir() if p.suffix.lower() in FORMATS and p.is_file())
    if not tables:
        raise RecordingError(f"{path}: a folder without a table ({', '.join(FORMATS)})")
    return tables


def table_beside(path: Path) -> tuple[Path, Path]:
    """Table and TOML of a path to either or to their stem, which may itself have dots in it.

    Of several tables, the first of `FORMATS` that exists; of none, the CSV, or the path itself if
    it is a file of a format that is not read.

    Raises:
        RecordingError: the path is a folder without a name, such as `.` or `/`.
    """
    if path.name in ("", ".."):
        raise RecordingError(f"{path} is a folder; give the path of a recording's table")
    suffix = path.suffix.lower()
    if suffix in FORMATS or (suffix in _AS_CSV and path.is_file()):
        return path, path.with_suffix(".toml")
    stem = path.name.removesuffix(".toml")
    tables = [path.with_name(stem + suffix) for suffix in FORMATS]
    usual = path if suffix != ".toml" and path.exists() else tables[0]
    return next((t for t in tables if t.is_file()), usual), path.with_name(stem + ".toml")


def check_file(path: Path, hint: str = "") -> None:
    """Raise `RecordingError` unless there is a file that can be opened.

    ``hint`` is appended to the message of a missing file, which names the nearest of the same kind.
    """
    try:
        path.open("rb").close()
    except FileNotFoundError:
        message = f"no such file, nor a folder {str(path.parent)!r}"
        if path.parent.is_dir():
            names = [p.name for p in path.parent.iterdir() if p.suffix == path.suffix]
            message = f"no such file: {unknown('file', path.name, names)}"
        raise RecordingError(f"{path}: {message}{hint}") from None
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {error.strerror}") from error


def read_text(path: Path, hint: str = "") -> str:
    """Read a UTF-8 text file (a byte-order mark is dropped), every line end turned into ``\\n``.

    Raises `RecordingError` for a file that cannot be opened, or is not UTF-8 (with its row).
    """
    check_file(path, hint)
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        row = error.object[: error.start].count(b"\n") + 1
        raise RecordingError(
            f"{path}, row {row}: byte 0x{error.object[error.start]:02x} is not UTF-8; save the file"
            " as UTF-8"
        ) from None


def read_toml(text: str, where: str) -> dict[str, Any]:
    """TOML text as plain values.

    Raises:
        RecordingError: broken TOML; the message begins with ``where`` and has the line.
    """
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise RecordingError(f"{where}: not TOML: {error}") from None
