"""Files that are written whole or not at all."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def whole_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A path beside ``path`` to write to; it takes the place of ``path`` when all went well.

    Whoever reads ``path`` meanwhile, or after the process was killed, finds what was there before.

    Raises:
        OSError: what is there is no regular file, such as /dev/null; or the file cannot be
            written. It names ``path``, also where the system's own error names no file, as on a
            full disk, or the one beside it.
    """
    path = Path(path)
    if path.exists() and not path.is_file():
        kind = "folder" if path.is_dir() else "device or pipe"
        raise OSError(f"{path} is a {kind}, which no file replaces; give another path")
    # a name may have 255 bytes; the first letters are for who sees what a killed process left
    beside = path.with_name(f".{path.stem[:20]}.{secrets.token_hex(8)}{path.suffix}")
    try:
        yield beside
        beside.replace(path)
    except OSError as error:
        if error.filename not in (None, str(beside)) or error.errno is None:
            raise
        raise OSError(error.errno, os.strerror(error.errno), str(path)) from error
    finally:
        with suppress(OSError):  # where nothing can be written, nothing can be removed
            beside.unlink(missing_ok=True)
