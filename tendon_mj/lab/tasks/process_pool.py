"""Worker processes of this machine with one core each, which end with the one that made them."""

from __future__ import annotations

import os
import pickle
import shutil
import signal
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from multiprocessing.connection import Connection, wait
from pathlib import Path
from tempfile import NamedTemporaryFile, TemporaryDirectory
from typing import Any

from tendon_mj.lab.tasks.identity import THREADS
from tendon_mj.lab.tasks.job import Function, Job

_SPAWN = get_context("spawn")
_AHEAD = 2  # tasks a process: one that runs, and one that waits
# A pipe takes so many bytes whole or not at all. Of a longer result, the half that a killed process
# has written would be waited on forever; it comes in a file, and only its path in the pipe.
_WHOLE = 2048
_DYING = 0.3  # after which a process whose pipe was closed is alive [s]


class ProcessPool:
    """Processes of this machine; where one dies, all are begun anew."""

    lost: tuple[type[BaseException], ...] = (BrokenExecutor,)

    def __init__(self, count: int, job: Job, folder: Path) -> None:
        self._count, self._job, self._folder = count, job, folder
        self._begin()

    def _begin(self) -> None:
        self._read, self._write = _SPAWN.Pipe(duplex=False)
        arguments = (self._job, self._read, self._folder)
        self._pool = ProcessPoolExecutor(self._count, _SPAWN, _begin_worker, arguments)

    def submit(self, key: str, argument: Any) -> Future[Any]:
        """Begin a task, or let it wait for a process."""
        try:
            with _holding_interrupts():
                return self._pool.submit(_run, key, argument)
        except BrokenExecutor as error:
            failed = Future[Any]()
            failed.set_exception(error)
            return failed

    def result(self, done: Future[Any]) -> Any:
        """What a task gave, from the pipe or from its file."""
        given = done.result()
        if isinstance(given, Path):
            content = given.read_bytes()
            given.unlink()
            return pickle.loads(content)
        return pickle.loads(given)

    def capacity(self) -> int:
        """Tasks under way or waiting."""
        return _AHEAD * self._count

    def check(self) -> None:
        """Do nothing: where a process ends, its futures say so."""

    def mend(self) -> None:
        """Begin all processes anew."""
        self.end()
        self._begin()

    def end(self) -> None:
        """End the processes at once, whatever they do."""
        self._write.close()  # they wait for that
        self._pool.shutdown(wait=True, cancel_futures=True)
        self._read.close()


@contextmanager
def process_pool(
    count: int, function: Function, shared: Any, sources: Sequence[str]
) -> Iterator[ProcessPool]:
    """Processes that do the tasks of a function, each with one thread for linear algebra."""
    job = Job.of(function, shared, sources, pickle.dumps)
    names = (THREADS, "OPENBLAS_NUM_THREADS")
    before = {name: os.environ.get(name) for name in names}
    os.environ |= dict.fromkeys(names, "1")  # processes read it before NumPy
    try:
        with TemporaryDirectory(prefix="tendon_mj_") as folder:
            pool = ProcessPool(count, job, Path(folder))
            try:
                yield pool
            finally:
                pool.end()
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


@contextmanager
def _holding_interrupts() -> Iterator[None]:
    """Ctrl-C waits until the end for this process; what is begun within never sees it.

    A process imports for seconds before its own code could ignore it.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


_JOBS: list[tuple[Job, Path]] = []  # that of this worker process, and the folder of its results


def _begin_worker(job: Job, end: Connection, folder: Path) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that made this one
    threading.Thread(target=_wait_for_end, args=(end, folder), daemon=True).start()
    _JOBS[:] = [(job, folder)]


def _wait_for_end(end: Connection, folder: Path) -> None:
    parent = parent_process()
    assert parent is not None
    wait([end, parent.sentinel])
    if wait([parent.sentinel], _DYING):  # its end of the pipe was closed by its death
        shutil.rmtree(folder, ignore_errors=True)  # nobody else will
    os._exit(1)


def _run(key: str, argument: Any) -> bytes | Path:
    ((job, folder),) = _JOBS
    content = pickle.dumps(job.run(key, argument))
    if len(content) <= _WHOLE:
        return content
    with NamedTemporaryFile(dir=folder, delete=False) as file:
        file.write(content)
    return Path(file.name)
