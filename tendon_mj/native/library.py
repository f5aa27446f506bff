"""The library of compiled functions: where it is kept, how it is built, and how it is loaded.

A wheel carries it. A clone builds it when its sources have changed, by Numba and the C compiler of
the system; without a C compiler the object file is kept, and llvmlite links it in each process.
The file's name has the digest of the sources, so that code and machine code belong together.
"""

from __future__ import annotations

import contextlib
import ctypes
import functools
import hashlib
import os
import shlex
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tendon_mj.errors import EngineError
from tendon_mj.native.marks import ARRAYS, ENTRIES

try:
    import fcntl
except ImportError:  # Windows, if several processes may build at once, each for itself
    fcntl = None  # type: ignore[assignment]

_PACKAGE = Path(__file__).parents[1]
_SOURCES = ("native", "plugin", "sheath")  # folders of the package with compiled functions
_SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
FOLDER = Path(__file__).parent / "libraries"  # of the package
_KEPT = 4  # libraries in a folder: of branches between which one switches
_PATIENCE = 300.0  # [s] that a process waits for another that builds the same


@functools.cache
def digest() -> str:
    """Digest of the sources of the machine code; "*" where a package is without its sources."""
    whole = hashlib.sha256()
    files = [path for name in _SOURCES for path in (_PACKAGE / name).rglob("*")]
    if not any(path.suffix == ".py" for path in files):
        return "*"
    for path in sorted(path for path in files if path.suffix in (".py", ".csv")):
        whole.update(path.relative_to(_PACKAGE).as_posix().encode() + b"\0" + path.read_bytes())
    return whole.hexdigest()[:16]


def _folders() -> list[Path]:
    """Folders for libraries: that of the package, and the user's cache if there is one."""
    folders = [FOLDER]
    with contextlib.suppress(RuntimeError):
        variable = {"win32": "LOCALAPPDATA", "darwin": ""}.get(sys.platform, "XDG_CACHE_HOME")
        below = {"win32": "AppData/Local", "darwin": "Library/Caches"}.get(sys.platform, ".cache")
        given = os.environ.get(variable, "")
        folders.append(Path(given or Path.home() / below) / "tendon_mj")
    return folders


def _kept(suffix: str) -> Iterator[Path]:
    for folder in _folders():
        for path in folder.glob(f"tendon_mj-{digest()}{suffix}"):
            # what is in the package is code as the files beside it are
            if folder == FOLDER or (_is_trusted(folder) and _is_trusted(path)):
                yield path


def _is_trusted(path: Path) -> bool:
    """Return whether a file or folder is there that nobody else may write to; its code is run."""
    try:
        status = path.lstat()
    except OSError:
        return False
    if not hasattr(os, "geteuid"):  # on Windows a user's folders are closed to others
        return True
    owners = {os.geteuid(), 0, _PACKAGE.stat().st_uid}
    return status.st_uid in owners and not status.st_mode & 0o022


class Library:
    """The functions of the library, by their symbols."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._linked: Any = None
        self._loaded: Any = None
        if path.suffix == ".o":
            try:
                import llvmlite.binding as llvm  # which comes with Numba
            except ModuleNotFoundError as error:
                raise EngineError(
                    f"{path} was built without a C compiler, and {error.name}, which links it in "
                    "each process, is not installed: pip install numba"
                ) from error
            llvm.initialize_native_target()
            llvm.initialize_native_asmprinter()
            self._linked = llvm.create_lljit_compiler()
            builder = llvm.JITLibraryBuilder().add_object_file(str(path)).add_current_process()
            for symbol in (*ENTRIES, *ARRAYS):
                builder.export_symbol(symbol)
            self._tracker = builder.link(self._linked, "tendon_mj")
        else:
            self._loaded = ctypes.CDLL(str(path))

    def address(self, symbol: str) -> int:
        """Address of a function or array.

        Raises:
            EngineError: the library does not have it.
        """
        if self._linked is not None:
            return int(self._tracker[symbol])
        try:
            place = ctypes.c_char.in_dll(self._loaded, symbol)
        except ValueError as error:
            raise EngineError(f"{self.path} has no {symbol}: build it again") from error
        return ctypes.addressof(place)

    def numbers(self, symbol: str, count: int) -> Any:
        """An array of int64 of the library."""
        return (ctypes.c_int64 * count).from_address(self.address(symbol))


@functools.cache
def load() -> Library:
    """The library, built if there is none of these sources.

    Raises:
        EngineError: it has to be built, and Numba is not installed.
    """
    for suffix in (_SUFFIX, ".o"):
        for path in _kept(suffix):
            return Library(path)
    return Library(build())


def build() -> Path:
    """Build the library of these sources into the first folder that can be written.

    Raises:
        EngineError: Numba is not installed, or no folder can be written.
    """
    try:
        from tendon_mj.native.compiler import compile_object
    except ModuleNotFoundError as error:
        raise EngineError(
            f"tendon-mj has no library for {sys.platform} with these sources, and {error.name}, "
            "which builds one, is not installed: pip install numba"
        ) from error
    folder = _writable()
    with _alone(folder):
        for suffix in (_SUFFIX, ".o"):
            for path in _kept(suffix):  # another process was faster
                return path
        print(f"tendon_mj: compiling, once (half a minute), into {folder}", file=sys.stderr)
        path = link(compile_object(ENTRIES), folder / f"tendon_mj-{digest()}")
    libraries = sorted(folder.glob("tendon_mj-*"), key=lambda path: path.stat().st_mtime)
    for old in libraries[:-_KEPT]:
        old.unlink(missing_ok=True)
    return path


def _writable() -> Path:
    for folder in _folders():
        with contextlib.suppress(OSError):
            folder.parent.mkdir(parents=True, exist_ok=True)
            folder.mkdir(mode=0o755, exist_ok=True)
            tempfile.TemporaryFile(dir=folder).close()
            if folder == FOLDER or _is_trusted(folder):
                return folder
    return Path(tempfile.mkdtemp(prefix="tendon_mj-"))


@contextlib.contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Let one process at a time build in a folder, where the system can lock files."""
    with (folder / "lock").open("wb") as lock:
        began = time.monotonic()
        while fcntl is not None and time.monotonic() - began < _PATIENCE:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except BlockingIOError:
                time.sleep(0.2)
            except OSError:  # a file system without locks
                break
        yield


def link(machine_code: bytes, stem: Path) -> Path:
    """Link an object file to a library, or keep it if there is no C compiler.

    Args:
        machine_code: object file.
        stem: path without suffix.

    Returns:
        The library or the object file, which appears whole or not at all.
    """
    with tempfile.TemporaryDirectory(dir=stem.parent) as work:
        made = Path(work) / "tendon_mj.o"
        made.write_bytes(machine_code)
        flags = ["-undefined", "dynamic_lookup"] if sys.platform == "darwin" else ["-lm"]
        library = made.with_suffix(_SUFFIX)
        command = [*shlex.split(os.environ.get("CC", "cc")), "-shared", "-o", str(library)]
        with contextlib.suppress(OSError):  # there is no such compiler
            done = subprocess.run([*command, str(made), *flags], capture_output=True, check=False)
            made = made if done.returncode else library
        made.chmod(0o755)  # whatever the umask allows to others
        target = stem.with_name(stem.name + made.suffix)
        made.replace(target)
    return target
