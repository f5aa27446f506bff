"""Cache of one function's machine code, in the form in which Numba asks for it.

A file for each signature and machine, in the folder of the sources' digest: a checksum, the key
that the file's name stands for, and the machine code. It is complete when it appears under its
name, so that processes may read and write at the same time.
"""

from __future__ import annotations

import contextlib
import hashlib
import pickle
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import llvmlite.binding
from numba import types
from numba.core.compiler import CompileResult
from numba.core.errors import NumbaWarning
from numba.core.runtime import rtsys
from numba.core.serialize import dumps

from tendon_mj.compilation import folders, session, sources

_CHECKSUM = 32  # bytes of SHA-256


class Cache:
    """Machine code of a function, found again by later processes.

    Numba's own cache (`numba.core.caching.Cache`) has these methods. A file that cannot be read or
    written is never an error: the function is compiled, and the result is the same.

    Args:
        function: in Python.
        wrapped: whether Python calls it; otherwise C does, and Numba need not know the types of
            Python's values, which takes it longer than all else when the package is imported.
    """

    def __init__(self, function: Callable[..., Any], wrapped: bool = True) -> None:
        self._function = function
        self._wrapped = wrapped

    @property
    def cache_path(self) -> str | None:
        """Folder in which new machine code is kept, as Numba's statistics show it."""
        candidate = folders.writable()
        return str(candidate.folder) if candidate else None

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Machine code for a signature, None where it has to be compiled."""
        if self._wrapped:
            target.refresh()
        else:
            rtsys.initialize(target)
        key = self._key(signature, target.codegen())
        found = self._load(key, target)
        if found is None and session.has_waited():
            found = self._load(key, target)
        if found is None:
            session.begin()
        return found

    def save_overload(self, signature: Any, result: Any) -> None:
        """Keep what was compiled for a signature."""
        session.advance()
        candidate = folders.writable()
        if candidate is None or not sources.are_as_imported():
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
            _write(candidate.folder / self._name(key), hashlib.sha256(body).digest() + body)

    def enable(self) -> None:
        """Nothing: this cache is always on."""

    def disable(self) -> None:
        """Nothing: this cache is always on."""

    def flush(self) -> None:
        """Forget all signatures of this function."""
        pattern = f"{self._stem()}-*.bin"
        for file in [file for folder in folders.readable() for file in folder.glob(pattern)]:
            with contextlib.suppress(OSError):
                file.unlink()

    def _key(self, signature: Any, codegen: Any) -> tuple[Any, ...]:
        """All that distinguishes machine code of the same sources: types, machine, closure."""
        closure = [_constant(cell.cell_contents) for cell in self._function.__closure__ or ()]
        code = self._function.__code__.co_code
        return signature, codegen.magic_tuple(), hashlib.sha256(code + dumps(closure)).hexdigest()

    def _stem(self) -> str:
        module = self._function.__module__.removeprefix("tendon_mj.")
        name = self._function.__qualname__.replace("<locals>.", "")
        return f"{module}.{name}-{self._function.__code__.co_firstlineno}"

    def _name(self, key: tuple[Any, ...]) -> str:
        return f"{self._stem()}-{hashlib.sha256(repr(key).encode()).hexdigest()[:16]}.bin"

    def _load(self, key: tuple[Any, ...], target: Any) -> Any:
        if not sources.are_as_imported():
            return None
        for folder in folders.readable():
            with contextlib.suppress(OSError):
                read = folders.read_trusted(folder / self._name(key))
                body = read[_CHECKSUM:]
                if hashlib.sha256(body).digest() != read[:_CHECKSUM]:
                    continue  # cut off when the machine stopped
                found, reduced = pickle.loads(body)
                if found == key:
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
            with contextlib.suppress(OSError):
                Path(file.name).unlink()
            raise
