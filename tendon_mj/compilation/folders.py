"""Folders in which machine code is kept between runs.

Candidates, in this order: ``NUMBA_CACHE_DIR`` where it is set; beside the package; the user's
cache; a private folder among the temporary files. Each has a folder for each digest of the sources.

Machine code is loaded from pickles, and whoever can write them can run code as the reader. A folder
is therefore used only if nobody but its owner may write in it and the owner is this user, the
administrator or, beside the package, the owner of the package, whose code is run anyway.
"""

from __future__ import annotations

import contextlib
import functools
import os
import re
import shutil
import stat
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from tendon_mj.compilation.sources import AT_IMPORT, PACKAGE

_BESIDE = PACKAGE / "__pycache__" / "machine_code"
_KEPT = 4  # digests for which machine code is kept: branches between which one switches
_DAY = 86400.0  # [s]; a folder in use is marked as used once a day
_DIGEST = re.compile(r"[0-9a-f]{16}")


def _user_cache() -> Path:
    """The user's cache folder by the platform's convention.

    Raises:
        RuntimeError: the user has no home.
    """
    variable = {"win32": "LOCALAPPDATA", "darwin": ""}.get(sys.platform, "XDG_CACHE_HOME")
    if Path(os.environ.get(variable, "")).is_absolute():
        return Path(os.environ[variable])
    below = {"win32": "AppData/Local", "darwin": "Library/Caches"}.get(sys.platform, ".cache")
    return Path.home() / below


def _candidates() -> Iterator[Path]:
    given = os.environ.get("NUMBA_CACHE_DIR", "")
    if given:
        yield Path(given).absolute() / "tendon_mj"
    yield _BESIDE
    with contextlib.suppress(RuntimeError):
        yield _user_cache() / "tendon_mj"
    with contextlib.suppress(OSError):  # no folder for temporary files either
        yield Path(tempfile.gettempdir()) / f"tendon_mj-{_uid()}"


def _uid() -> int:
    return os.geteuid() if hasattr(os, "geteuid") else 0


def _is_closed(status: os.stat_result) -> bool:
    """Whether only its owner may write to a file or folder, who is trusted.

    On Windows folders of a user are closed to other users by default.
    """
    owners = {_uid(), 0, PACKAGE.stat().st_uid}
    return not hasattr(os, "geteuid") or (status.st_uid in owners and not status.st_mode & 0o022)


def is_trusted(folder: Path) -> bool:
    """Whether pickles in a folder, which is not a symbolic link, may be loaded."""
    try:
        status = folder.lstat()
    except OSError:
        return False
    return stat.S_ISDIR(status.st_mode) and _is_closed(status)


def read_trusted(path: Path) -> bytes:
    """Content of a file that only its owner may write, who is trusted.

    The opened file is checked: whoever may rename folders above it, as in a shared
    ``NUMBA_CACHE_DIR``, can put another folder in its place at any time.

    Raises:
        PermissionError: somebody else owns it, or may write it.
        OSError: it cannot be read.
    """
    with path.open("rb") as file:
        if not _is_closed(os.fstat(file.fileno())):
            raise PermissionError(f"{path} may have been written by somebody else")
        return file.read()


@functools.cache
def readable() -> tuple[Path, ...]:
    """Folders with machine code of the sources at hand, the first candidate first."""
    if AT_IMPORT is None:
        return ()
    folders = [c / AT_IMPORT.digest for c in _candidates() if is_trusted(c)]
    trusted = tuple(folder for folder in folders if is_trusted(folder))
    for folder in trusted:
        with contextlib.suppress(OSError):
            if folder.stat().st_mtime < time.time() - _DAY:
                os.utime(folder)
    return trusted


@functools.cache
def writable() -> Path | None:
    """Folder in the first candidate that can be written, made where it is missing; None without.

    Machine code of sources that have not been used for long is deleted there.
    """
    if AT_IMPORT is None:
        return None
    for candidate in _candidates():
        folder = candidate / AT_IMPORT.digest
        if _is_made(folder):
            readable.cache_clear()
            delete_old(folder)
            return folder
    return None


def _is_made(folder: Path) -> bool:
    # beside the package readable for all: an administrator may compile once for all users
    mode = 0o755 if folder.parent == _BESIDE else 0o700
    try:
        folder.parent.parent.mkdir(parents=True, exist_ok=True)
        for made in (folder.parent, folder):
            with contextlib.suppress(FileExistsError):
                made.mkdir(mode=mode)
            if not is_trusted(made):
                return False
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


def delete_old(folder: Path) -> None:
    """Delete all folders of digests beside one but those used last.

    A process that runs has loaded what it needs. One that compiles loses what it has saved, so that
    the next one compiles again; neither depends on a file for its result.
    """
    with contextlib.suppress(OSError):
        others = [
            (other.lstat().st_mtime, other)
            for other in folder.parent.iterdir()
            if _DIGEST.fullmatch(other.name) and other != folder
        ]
        for _, other in sorted(others, reverse=True)[_KEPT - 1 :]:
            shutil.rmtree(other, ignore_errors=True)
