"""Machine code of a function, kept on disk in the form in which Numba asks for it.

There is a file for each signature and machine, in the folder of the sources' digest: a checksum,
the key that the file's name stands for, and the machine code. It is complete when it appears under
its name, so that processes may read and write at the same time.
"""

from __future__ import annotations

import contextlib
import hashlib
import pickle
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Any

import llvmlite.binding
from numba import types
from numba.core.compiler import CompileResult
from numba.core.errors import NumbaWarning
from numba.core.runtime import rtsys
from numba.core.serialize import dumps

from tendon_mj.compilation import folders, sources

try:
    import fcntl
except ImportError:  # Windows, where several processes may compile at once, each for itself
    fcntl = None  # type: ignore[assignment]

_CHECKSUM = 32  # bytes of SHA-256
_PATIENCE = 600.0  # [s]; a process that holds the lock for longer has been stopped


class _Session:
    """A compilation that other processes wait for."""

    lock: IO[bytes] | None = None
    has_asked = False  # for the lock


_session: _Session | None = None
_has_said = False  # that this process compiles


@contextlib.contextmanager
def announced() -> Iterator[None]:
    """Print a line on stderr if anything is compiled inside, and let other processes wait for it.

    They wait only to load the result instead of compiling it as well.
    """
    global _session
    outer, _session = _session, _Session()
    try:
        yield
    finally:
        if _session.lock is not None:
            _session.lock.close()
        _session = outer


def _has_waited() -> bool:
    """Wait, once in a session, for a process that compiles the same; whether more may be kept."""
    if _session is None or _session.has_asked:
        return False
    _session.has_asked = True
    folder = folders.writable()
    if folder is None or fcntl is None:
        return False
    try:
        _session.lock = (folder / "lock").open("wb")
        _wait(_session.lock)
    except OSError:  # a file system without locks
        return False
    return True


def _wait(lock: IO[bytes]) -> None:
    """Wait for a lock, which the system takes back from a process that dies."""
    began, has_said = time.monotonic(), False
    while time.monotonic() - began < _PATIENCE:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() - began > 1.0 and not has_said:
                _say("waiting for another process that compiles its plugins")
                has_said = True
            time.sleep(0.2)
        else:
            return


def _begin() -> None:
    """Say, once in a process, that functions are compiled."""
    global _has_said
    if _session is None or _has_said:
        return
    _has_said = True
    folder = folders.writable()
    if folder is None:
        _say(
            "compiling its plugins, in every process (about two minutes): no cache folder can be"
            " written; set NUMBA_CACHE_DIR"
        )
    else:
        _say(f"compiling its plugins for this machine, once (about two minutes), into {folder}")


def _say(text: str) -> None:
    with contextlib.suppress(OSError, ValueError, AttributeError):  # closed, or none at all
        print(f"tendon_mj: {text}", file=sys.stderr, flush=True)


class Cache:
    """Machine code of a function, found again by later processes.

    It has the methods that Numba calls of its own cache (`numba.core.caching.Cache`). A file that
    cannot be read or written is never an error: the function is compiled, and the result is the
    same.

    Args:
        function: in Python.
        wrapped: whether Python calls it; otherwise C does, and Numba need not know the types of
            Python's values, which takes it longer than all else when the package is imported.
    """

    def __init__(self, function: Callable[..., Any], wrapped: bool = True) -> None:
        self._function = function
        self._wrapped = wrapped

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Machine code for a signature, None where it has to be compiled."""
        if self._wrapped:
            target.refresh()
        else:
            rtsys.initialize(target)
        key = self._key(signature, target.codegen())
        machine_code = self._load(key, target)
        if machine_code is None and _has_waited():
            machine_code = self._load(key, target)
        if machine_code is None:
            _begin()
        return machine_code

    def save_overload(self, signature: Any, result: Any) -> None:
        """Keep what was compiled for a signature."""
        folder = folders.writable()
        if folder is None or not sources.are_as_imported():
            return
        if result.library.has_dynamic_globals or any(not x.can_cache for x in result.lifted):
            warnings.warn(
                f"{self._function.__qualname__} holds addresses and is compiled by every process",
                NumbaWarning,
                stacklevel=2,
            )
            return
        key = self._key(signature, result.library.codegen)
        reduced = result._reduce()
        body = dumps((key, reduced if self._wrapped else _unlinked(reduced)))
        with contextlib.suppress(OSError):  # a full disk, or a folder deleted in the meantime
            _write(folder / self._name(key), hashlib.sha256(body).digest() + body)

    def _key(self, signature: Any, codegen: Any) -> tuple[Any, ...]:
        """All that distinguishes machine code of the same sources: types, machine, closure."""
        closure = [_constant(cell.cell_contents) for cell in self._function.__closure__ or ()]
        code = self._function.__code__.co_code
        return signature, codegen.magic_tuple(), hashlib.sha256(code + dumps(closure)).hexdigest()

    def _name(self, key: tuple[Any, ...]) -> str:
        module = self._function.__module__.removeprefix("tendon_mj.")
        name = self._function.__qualname__.replace("<locals>.", "")
        line = self._function.__code__.co_firstlineno
        return f"{module}.{name}-{line}-{hashlib.sha256(repr(key).encode()).hexdigest()[:16]}.bin"

    def _load(self, key: tuple[Any, ...], target: Any) -> Any:
        if not sources.are_as_imported():
            return None
        for folder in folders.readable():
            with contextlib.suppress(OSError):
                read = folders.read_trusted(folder / self._name(key))
                body = read[_CHECKSUM:]
                if hashlib.sha256(body).digest() != read[:_CHECKSUM]:
                    continue  # cut off when the machine stopped
                kept, reduced = pickle.loads(body)
                if kept == key:
                    return CompileResult._rebuild(target, *reduced)
        return None


def _unlinked(reduced: tuple[Any, ...]) -> tuple[Any, ...]:
    """Cached part of a function that only C calls: none of its bitcode, but for its entry's name.

    Numba keeps bitcode beside the machine code, for other functions to be linked with it, and takes
    longer to parse it than for all else when the package is imported.
    """
    (name, kind, data), described, *rest = reduced
    if kind != "object":
        return reduced
    machine_code, _ = data
    entry = f'define void @"{described.llvm_cfunc_wrapper_name}"() {{ ret void }}'
    bitcode = llvmlite.binding.parse_assembly(entry).as_bitcode()
    return (name, kind, (machine_code, bitcode)), described, *rest


def _constant(value: Any) -> Any:
    """Part of the key for a value of a closure, equal in every process."""
    if isinstance(value, types.ExternalFunction):  # pickled as a class, each time another one
        return value.symbol, str(value.sig)
    return value


def _write(path: Path, content: bytes) -> None:
    """Write a file that appears whole or not at all."""
    with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".tmp", delete=False) as file:
        try:
            file.write(content)
            file.close()
            Path(file.name).chmod(path.parent.stat().st_mode & 0o644)
            Path(file.name).replace(path)
        except BaseException:
            Path(file.name).unlink(missing_ok=True)
            raise
