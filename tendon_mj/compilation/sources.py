"""Digest of all that machine code depends on: the code that is compiled, and its tools.

Numba compares a cached function with its own file, but inlines functions from other files. Here one
digest stands for the code of all of them: a change anywhere is a change everywhere. It is of the
bytecode that Python runs, and not of the texts, which Python itself can fail to read again: it
compares the time of a file in seconds, and its size.
"""

from __future__ import annotations

import hashlib
import os
import sys
from importlib import import_module
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import CodeType
from typing import Any, NamedTuple

PACKAGE = Path(__file__).parents[1]
# packages with compiled functions
COMPILED = ("compilation", "plugin", "sheath")
TOOLS = ("llvmlite", "mujoco", "numba", "numpy")  # whose versions the machine code depends on


class Sources(NamedTuple):
    """State of the sources at one moment."""

    stamps: tuple[tuple[str, int, int], ...]  # path, time of the last change [ns], size
    digest: str  # of their code and of the versions of Python and ``TOOLS``


def _stamp(path: str) -> tuple[str, int, int]:
    status = os.stat(path)  # noqa: PTH116, called hundreds of times in an import
    return path, status.st_mtime_ns, status.st_size


def _version(tool: str) -> str:
    # these modules are imported in any case
    return str(getattr(import_module(tool), "__version__", "none"))


def _code(path: Path) -> CodeType:
    """Code of a module as Python loads it, from its own cache where that is thought to be valid."""
    name = ".".join(("tendon_mj", *path.relative_to(PACKAGE).with_suffix("").parts))
    code = SourceFileLoader(name, str(path)).get_code(name)
    assert code is not None
    return code


def fingerprint(constant: Any) -> str:
    """Text that is equal for equal code, or constants of code, whatever its file and lines."""
    if isinstance(constant, CodeType):
        parts = (
            "code names varnames freevars cellvars argcount posonlyargcount kwonlyargcount flags"
        )
        values = [getattr(constant, f"co_{part}") for part in parts.split()]
        return f"{values} {[fingerprint(inner) for inner in constant.co_consts]}"
    if isinstance(constant, tuple):
        return f"({', '.join(map(fingerprint, constant))})"
    if isinstance(constant, frozenset):  # in another order in every process
        return f"{{{', '.join(sorted(map(fingerprint, constant)))}}}"
    return repr(constant)


def read() -> Sources:
    """Read the sources.

    Raises:
        OSError: a file is missing, or the package was installed without its sources.
        SyntaxError: a file is not Python.
    """
    files = sorted(path for name in COMPILED for path in (PACKAGE / name).rglob("*.py"))
    if not files:
        raise FileNotFoundError(f"no sources in {PACKAGE}")
    # before the code, so that a change while it is read is noticed
    stamps = tuple(_stamp(str(path)) for path in files)
    digest = hashlib.sha256(f"{sys.implementation.cache_tag} {sys.abiflags}".encode())
    for tool in TOOLS:
        digest.update(f"\0{tool} {_version(tool)}".encode())
    for path in files:
        digest.update(f"\0{path.relative_to(PACKAGE).as_posix()}\0".encode())
        digest.update(fingerprint(_code(path)).encode())
    return Sources(stamps, digest.hexdigest()[:16])


def _at_import() -> Sources | None:
    try:
        return read()
    except (OSError, SyntaxError):  # what is wrong shows when it is imported
        return None


# Read before any module with a compiled function is imported: this package is the lowest layer.
AT_IMPORT = _at_import()


def are_as_imported() -> bool:
    """Whether the sources on disk are still those that this process began with.

    They differ in a process that outlives a change of the sources. It may have imported some
    modules before and others after, so that its machine code belongs to neither digest.
    """
    try:
        return AT_IMPORT is not None and all(_stamp(s[0]) == s for s in AT_IMPORT.stamps)
    except OSError:
        return False
