"""Function and data of a run for a worker, which must have the same versions."""

from __future__ import annotations

import hashlib
import importlib.metadata
import importlib.util
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final

from tendon_mj.errors import TendonError, WorkerError

THREADS: Final = "OMP_NUM_THREADS"  # OpenBLAS and MKL heed it too
_PACKAGES: Final = ("mujoco", "numpy", "scipy")


def versions(sources: Sequence[str] = ("tendon_mj",)) -> dict[str, str]:
    """Name → version of the packages that numbers depend on, and digest of some's sources."""
    packages = {name: importlib.metadata.version(name) for name in _PACKAGES}
    digests = {name: f"sources {_digest(name)}" for name in sources}
    return {"python": ".".join(map(str, sys.version_info[:2])), **packages, **digests}


def identity(sources: Sequence[str] = ("tendon_mj",)) -> dict[str, str]:
    """`versions` and the number of threads of BLAS, on which its sums depend."""
    return {**versions(sources), THREADS: os.environ.get(THREADS, "not set")}


@cache  # a package is imported once, and its files may change afterwards
def _digest(package: str) -> str:
    """16 hexadecimal digits of a package's Python sources."""
    spec, whole = importlib.util.find_spec(package), hashlib.sha256()
    for folder in spec.submodule_search_locations or () if spec else ():
        for path in sorted(Path(folder).rglob("*.py")):
            whole.update(path.relative_to(folder).as_posix().encode())
            whole.update(path.read_bytes().replace(b"\r\n", b"\n"))
    return whole.hexdigest()[:16]


def check_same(expected: Mapping[str, str], there: Mapping[str, str], where: str) -> None:
    """Refuse a process that computes with something else; the message has both values."""
    differing = [
        f"{name}: {there.get(name, 'missing')} there, {value} here"
        for name, value in expected.items()
        if there.get(name) != value
    ]
    if differing:
        raise WorkerError(
            f"{where} differs from this process; {'; '.join(differing)}; install the same on every"
            " machine, and start workers as `dask worker ADDRESS --nworkers 2 --nthreads 1`, which"
            f" sets {THREADS}"
        )


@dataclass(frozen=True, eq=False)
class Job:
    """Function and shared data of a run, and the versions that a worker must have."""

    function: Callable[[Any, Any], Any]
    shared: Any
    sources: tuple[str, ...]
    expected: Mapping[str, str]

    @staticmethod
    def of(function: Callable[[Any, Any], Any], shared: Any, sources: Sequence[str]) -> Job:
        """The job of a run in this process."""
        expected = {**identity(sources), THREADS: "1", **_identity_of(shared)}
        return Job(function, shared, tuple(sources), expected)

    def run(self, key: str, argument: Any, worker: str) -> Any:
        """Do one task in this process, unless it computes with something else than the caller."""
        if [self] != _CHECKED:
            here = {**identity(self.sources), **_identity_of(self.shared)}
            check_same(self.expected, here, worker)
            _CHECKED[:] = [self]
        try:
            return self.function(self.shared, argument)
        except TendonError as error:  # with a text alone, which every process can read
            kind = WorkerError if isinstance(error, WorkerError) else TendonError
            raise kind(f"{key}: {error}") from None


_CHECKED: list[Job] = []  # the job of this worker


def _identity_of(shared: Any) -> Mapping[str, str]:
    stated: Mapping[str, str] = shared.identity() if hasattr(shared, "identity") else {}
    return stated
