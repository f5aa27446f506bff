"""First compilation of the plugins: said on stderr, and done by one process at a time."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Iterator
from typing import IO

from tendon_mj.compilation import folders

try:
    import fcntl
except ImportError:  # Windows, where several processes may compile at once, each for itself
    fcntl = None  # type: ignore[assignment]

_PATIENCE = 600.0  # [s]; a process that holds the lock for longer has been stopped
_WIDTH = 100


class _Session:
    """State of one compilation.

    Attributes:
        started: when compiling began [s], None as long as all was found on disk.
        functions: how many have been compiled.
        lock: file that is locked while this process compiles.
        asked: whether the lock has been asked for.
        shown: whether a line stands on the terminal.
    """

    def __init__(self) -> None:
        self.started: float | None = None
        self.functions = 0
        self.lock: IO[bytes] | None = None
        self.asked = False
        self.shown = False


_current: _Session | None = None
_said = False  # that this process compiles


@contextlib.contextmanager
def announced() -> Iterator[None]:
    """Say on stderr if anything is compiled inside, and let other processes wait for it.

    They wait only to load the result instead of compiling it as well. Nothing is said where all is
    found on disk.
    """
    global _current
    outer, _current = _current, _Session()
    try:
        yield
        _conclude(_current)
    finally:
        _release(_current)
        _current = outer


def has_waited() -> bool:
    """Wait, once in a session, for a process that compiles the same.

    Returns:
        Whether there may be more on disk now than before.
    """
    if _current is None or _current.asked:
        return False
    _current.asked = True
    candidate = folders.writable()
    if candidate is None or fcntl is None:
        return False
    try:
        _current.lock = (candidate.folder / "lock").open("wb")
        _wait(_current.lock)
    except OSError:  # a file system without locks
        return False
    return True


def _wait(lock: IO[bytes]) -> None:
    """Wait for a lock, which the system takes back from a process that dies."""
    began, said = time.monotonic(), False
    while time.monotonic() - began < _PATIENCE:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            seconds = time.monotonic() - began
            if seconds > 1.0:
                _rewrite(f"tendon_mj: another process compiles its plugins: {seconds:.0f} s")
                if not said and not _is_terminal():
                    _write("tendon_mj: waiting for another process that compiles its plugins\n")
                said = True
            time.sleep(0.2)
        else:
            return


def begin() -> None:
    """A function has to be compiled: say so, once in a process or, on a terminal, in a session."""
    global _said
    if _current is None or _current.started is not None:
        return
    _current.started = time.monotonic()
    if not _is_terminal() and not _said:
        _write(_announcement() + "\n")
    _said = True
    advance(0)


def advance(functions: int = 1) -> None:
    """So many more functions have been compiled."""
    if _current is None or _current.started is None:
        return
    _current.functions += functions
    seconds = time.monotonic() - _current.started
    _rewrite(f"{_announcement()}: {_current.functions} functions, {seconds:.0f} s")


def _conclude(session: _Session) -> None:
    if session.started is not None:
        seconds = time.monotonic() - session.started
        _rewrite(f"tendon_mj: compiled its plugins in {seconds:.0f} s")


def _release(session: _Session) -> None:
    if session.lock is not None:
        session.lock.close()
    if session.shown and _is_terminal():
        _write("\n")


def _announcement() -> str:
    candidate = folders.writable()
    what = "tendon_mj: compiling its plugins for this machine"
    if candidate is None:
        return f"{what}, in every process (about two minutes): no cache folder can be written"
    if not candidate.lasting:
        return (
            f"{what} (about two minutes): kept in {candidate.base}, the only folder to be written"
        )
    return f"{what}, once (about two minutes)"


def _is_terminal() -> bool:
    return sys.stderr is not None and sys.stderr.isatty()


def _rewrite(line: str) -> None:
    """Show a line in place of the last one, on a terminal only."""
    if _current is not None and _is_terminal():
        _current.shown = True
        _write(f"\r{line:<{_WIDTH}}")


def _write(text: str) -> None:
    with contextlib.suppress(OSError, ValueError, AttributeError):  # closed, or none at all
        sys.stderr.write(text)
        sys.stderr.flush()
