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
from typing import NamedTuple

from tendon_mj.compilation.sources import AT_IMPORT, PACKAGE

_KEPT = 4  # digests for which machine code is kept: branches between which one goes to and fro
_DAY = 86400.0  # [s]; a folder in use is marked as used once a day
_DIGEST = re.compile(r"[0-9a-f]{16}")


class Candidate(NamedTuple):
    """A folder that may hold machine code.

    Attributes:
        base: the folder, which has one folder for each digest.
        owner: a user other than this one and the administrator who is trusted there, −1 for none.
        mode: permissions with which folders are made.
        lasting: whether it outlives the next start of the machine.
    """

    base: Path
    owner: int = -1
    mode: int = 0o700
    lasting: bool = True

    @property
    def folder(self) -> Path:
        """The folder of the sources at hand."""
        return self.base / (AT_IMPORT.digest if AT_IMPORT else "")


def _user_cache() -> Path | None:
    """The user's cache folder by the platform's convention, None for a user without a home."""
    if sys.platform == "win32":
        given, below_home = os.environ.get("LOCALAPPDATA", ""), "AppData/Local"
    elif sys.platform == "darwin":
        given, below_home = "", "Library/Caches"
    else:
        given, below_home = os.environ.get("XDG_CACHE_HOME", ""), ".cache"
    if Path(given).is_absolute():
        return Path(given)
    home = Path("~").expanduser() if _has_home() else Path()
    return home / below_home if home.is_absolute() else None


def _has_home() -> bool:
    try:
        Path.home()
    except RuntimeError:
        return False
    return True


def _candidates() -> Iterator[Candidate]:
    given = os.environ.get("NUMBA_CACHE_DIR", "")
    if given:
        yield Candidate(Path(given).absolute() / "tendon_mj")
    with contextlib.suppress(OSError):
        # readable for all: an administrator may compile once for all users
        yield Candidate(PACKAGE / "__pycache__" / "machine_code", PACKAGE.stat().st_uid, 0o755)
    user = _user_cache()
    if user:
        yield Candidate(user / "tendon_mj")
    with contextlib.suppress(OSError):  # no folder for temporary files either
        yield Candidate(Path(tempfile.gettempdir()) / f"tendon_mj-{_uid()}", lasting=False)


def _uid() -> int:
    return os.geteuid() if hasattr(os, "geteuid") else 0


def is_trusted(folder: Path, owner: int = -1) -> bool:
    """Whether pickles in a folder may be loaded.

    Args:
        folder: itself no symbolic link.
        owner: a user who is trusted besides this one and the administrator.
    """
    try:
        status = folder.lstat()
    except OSError:
        return False
    if not stat.S_ISDIR(status.st_mode):
        return False
    if not hasattr(os, "geteuid"):
        return True  # Windows: folders of a user are closed to other users by default
    return status.st_uid in {_uid(), 0, owner} and not status.st_mode & 0o022


def read_trusted(path: Path) -> bytes:
    """Content of a file that only its owner may write, who is trusted.

    The file that was opened is what is judged: whoever may rename folders above it, as in a shared
    ``NUMBA_CACHE_DIR``, can put another folder in its place at any time.

    Raises:
        PermissionError: somebody else owns it, or may write it.
        OSError: it cannot be read.
    """
    with path.open("rb") as file:
        status = os.fstat(file.fileno())
        if hasattr(os, "geteuid"):
            owners = {_uid(), 0, PACKAGE.stat().st_uid}
            if status.st_uid not in owners or status.st_mode & 0o022:
                raise PermissionError(f"{path} may have been written by somebody else")
        return file.read()


def _is_trusted(candidate: Candidate) -> bool:
    return all(is_trusted(f, candidate.owner) for f in (candidate.base, candidate.folder))


@functools.cache
def readable() -> tuple[Path, ...]:
    """Folders with machine code of the sources at hand, the first candidate first."""
    if AT_IMPORT is None:
        return ()
    found = tuple(c.folder for c in _candidates() if _is_trusted(c))
    for folder in found:
        with contextlib.suppress(OSError):
            if folder.stat().st_mtime < time.time() - _DAY:
                os.utime(folder)
    return found


@functools.cache
def writable() -> Candidate | None:
    """First candidate that can be written, made where it is missing; None if none can.

    Machine code of sources that have not been used for long is deleted there.
    """
    if AT_IMPORT is None:
        return None
    for candidate in _candidates():
        if _is_made(candidate):
            readable.cache_clear()
            _delete_old(candidate)
            return candidate
    return None


def _is_made(candidate: Candidate) -> bool:
    try:
        candidate.base.parent.mkdir(parents=True, exist_ok=True)
        for folder in (candidate.base, candidate.folder):
            with contextlib.suppress(FileExistsError):
                folder.mkdir(mode=candidate.mode)
        if not _is_trusted(candidate):
            return False
        tempfile.TemporaryFile(dir=candidate.folder).close()
    except OSError:
        return False
    return True


def _delete_old(candidate: Candidate) -> None:
    """Delete all but the folders used last.

    A process that runs has loaded what it needs. One that compiles loses what it has saved, so that
    the next one compiles again; neither depends on a file for its result.
    """
    with contextlib.suppress(OSError):
        others = [
            (folder.lstat().st_mtime, folder)
            for folder in candidate.base.iterdir()
            if _DIGEST.fullmatch(folder.name) and folder != candidate.folder
        ]
        for _, folder in sorted(others, reverse=True)[_KEPT - 1 :]:
            shutil.rmtree(folder, ignore_errors=True)
