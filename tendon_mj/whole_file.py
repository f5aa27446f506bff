"""Files that are written whole or not at all."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def whole_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A path in the same folder to write to; it replaces ``path`` when all went well.

    Whoever reads ``path`` meanwhile, or after the process was killed, finds the old file.

    Raises:
        OSError: the file cannot be written; the error names ``path``.
    """
    path = Path(path)
    # a name may have 255 bytes; the first letters identify a file that a killed process left
    beside = path.with_name(f".{path.stem[:20]}.{secrets.token_hex(8)}{path.suffix}")
    try:
        yield beside
        beside.replace(path)
    except OSError as error:
        if error.filename == str(beside):
            error.filename = str(path)
        raise
    finally:
        beside.unlink(missing_ok=True)
