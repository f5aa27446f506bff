"""What a process computes with: versions and sources, held against those of another process."""

from __future__ import annotations

import hashlib
import importlib.metadata
import importlib.util
import os
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

from tendon_mj.errors import WorkerError

_PACKAGES = ("mujoco", "numpy", "scipy", "numba")
THREADS = "OMP_NUM_THREADS"  # OpenBLAS and MKL heed it too
_FREE = "not set"


def identity(sources: Sequence[str] = ("tendon_mj",)) -> dict[str, str]:
    """Name → version of all that the numbers of a task depend on, in this process.

    Sums in BLAS depend on its number of threads, so that is among them.

    Args:
        sources: packages of which the sources count, and not only the version.
    """
    return {**versions(sources), THREADS: os.environ.get(THREADS, _FREE)}


def versions(sources: Sequence[str] = ("tendon_mj",)) -> dict[str, str]:
    """Name → version of packages, and digest of the sources of some."""
    found = {"python": ".".join(map(str, sys.version_info[:2]))}
    found |= {name: importlib.metadata.version(name) for name in _PACKAGES}
    return found | {name: f"sources {_digest(name)}" for name in sources}


@cache  # a package is imported once, and its files may change afterwards
def _digest(package: str) -> str:
    """16 hexadecimal digits of a package's Python sources."""
    found, whole = importlib.util.find_spec(package), hashlib.sha256()
    for folder in found.submodule_search_locations or () if found else ():
        for path in sorted(Path(folder).rglob("*.py")):
            whole.update(path.relative_to(folder).as_posix().encode())
            whole.update(path.read_bytes().replace(b"\r\n", b"\n"))
    return whole.hexdigest()[:16]


def check_same(expected: Mapping[str, str], found: Mapping[str, str], where: str) -> None:
    """Refuse a process that computes with something else.

    Args:
        expected: `identity` of the process that asks, and digests of what it sends.
        found: the same of the other.
        where: names the other.

    Raises:
        WorkerError: names what differs, with both values.
    """
    differing = [
        f"{name}: {found.get(name, 'missing')} there, {value} here"
        for name, value in expected.items()
        if found.get(name) != value
    ]
    if differing:
        way_out = (
            "install the same on every machine, and start workers as"
            f" `dask worker ADDRESS --nworkers 2 --nthreads 1`, which sets {THREADS}"
        )
        raise WorkerError(f"{where} differs from this process; {'; '.join(differing)}; {way_out}")
