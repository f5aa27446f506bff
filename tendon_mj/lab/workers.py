"""A function mapped over tasks with keys, on processes of this machine or workers of Dask.

Results are stored as they arrive, by the caller alone: a run that was ended goes on where it was.
Where it runs changes no number, so a worker with other versions is refused.

`joblib.Parallel` (1.6) does not hold this. With one job it computes in the caller, with its number
of threads. It sends tasks ahead of a caller that is slow to store results, and when a worker dies
it loses the results that the caller has not been given yet. Its processes outlive a caller that is
killed. On Dask it waits for ever for a task that killed as many workers as Dask allows.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import importlib.util
import logging
import multiprocessing
import os
import pickle
import re
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Future,
    ProcessPoolExecutor,
    wait,
)
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cache
from multiprocessing.queues import Queue
from multiprocessing.synchronize import Semaphore
from pathlib import Path
from typing import Any, Final, NamedTuple, Protocol, TypeVar

from tendon_mj.errors import InvalidValueError, MissingPackageError, TendonError, WorkerError
from tendon_mj.lab.progress import Progress, silent

THREADS: Final = "OMP_NUM_THREADS"  # OpenBLAS and MKL heed it too
_PACKAGES: Final = ("mujoco", "numpy", "scipy")

Shared = TypeVar("Shared")
Argument = TypeVar("Argument")
Result = TypeVar("Result")
_Result = TypeVar("_Result", contravariant=True)

MOST: Final = 1024  # processes or workers of this machine
_ADDRESS: Final = re.compile(r"\w+://.+:\d{1,5}")
_AHEAD = 2  # tasks per worker: one runs, one waits
_CONNECT, _FIRST_WORKER = 10.0, 60.0  # longest wait for a scheduler, and for its first worker [s]
_NTHREADS: Final = "--nthreads"  # threads would share one simulation
_IMPORT = 10.0  # longest wait for a worker that still imports [s]
_COUNTED = 10.0  # longest interval between two counts of Dask's workers [s]


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
    return shared.identity() if hasattr(shared, "identity") else {}


class Store(Protocol[_Result]):
    """Storage of results, each whole or not at all."""

    def done(self) -> Collection[str]:
        """Keys of the tasks whose result is kept."""
        ...

    def write(self, key: str, result: _Result) -> None:
        """Keep a result."""
        ...


@dataclass(frozen=True, kw_only=True)
class Workers:
    """Processes in which tasks run; at most one of the three is given."""

    processes: int | None = None  # of this machine, without Dask; default: as many as it has cores
    workers: int | None = None  # of a Dask cluster that lives as long as the run
    scheduler: str | None = None  # address of a Dask scheduler, such as tcp://10.0.0.1:8786

    def __post_init__(self) -> None:
        given = {name: value for name, value in vars(self).items() if value is not None}
        if len(given) > 1:
            options = " and ".join(f"--{name} {value}" for name, value in given.items())
            raise InvalidValueError(f"{options}: give one of them")
        for name in ("processes", "workers"):
            if not 1 <= given.get(name, 1) <= MOST:
                raise InvalidValueError(
                    f"--{name} {given[name]} is outside 1 … {MOST}; one per core computes fastest,"
                    f" and this machine has {os.cpu_count() or 1}"
                )
        if self.scheduler is not None and not _ADDRESS.fullmatch(self.scheduler):
            raise InvalidValueError(
                f"--scheduler {self.scheduler} is not an address such as tcp://10.0.0.1:8786, which"
                " `dask scheduler` prints"
            )

    @property
    def on_dask(self) -> bool:
        """Whether tasks run on workers of Dask."""
        return self.workers is not None or self.scheduler is not None

    def __str__(self) -> str:
        if self.scheduler is not None:
            return f"the scheduler at {self.scheduler}"
        if self.workers is not None:
            return f"{self.workers} local worker{'s' if self.workers > 1 else ''} of Dask"
        count = self.processes or os.cpu_count() or 1
        return f"{count} process{'es' if count > 1 else ''}"


def run_tasks(
    function: Callable[[Shared, Argument], Result],
    shared: Shared,
    keys: Sequence[str],
    argument: Callable[[str], Argument],
    store: Store[Result],
    *,
    on: Workers | None = None,
    sources: Sequence[str] = ("tendon_mj",),
    begin: Callable[[], None] = lambda: None,
    progress: Progress = silent,
    what: str = "tasks",
) -> None:
    """Compute ``function(shared, argument(key))`` for every key whose result is not kept yet.

    Where it runs and with how many workers changes no number. Two tasks per worker are under way,
    so memory is bounded, and workers need no folder in common. Results are kept also if a task
    is refused, or workers are lost.

    Args:
        function: of a module that workers can import too.
        shared: sent to each worker once; it may have a method ``identity()`` → name → text, which
            has to be the same there.
        keys: of all tasks, in the order in which they begin.
        argument: makes the argument of a task when it is sent.
        store: keeps the results.
        on: where to run; default: this machine's cores.
        sources: packages of which workers must have the same sources.
        begin: called once, before the first task, when the workers are there and may compute.
        progress: called with ``what``, how many are kept, and of how many.
        what: the tasks are.
    """
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        raise SystemExit(1)  # a worker, which reads the script again; the caller says so
    kept, on = set(store.done()), on or Workers()
    todo = [key for key in keys if key not in kept]
    progress(what, len(keys) - len(todo), len(keys))
    if not todo:
        begin()
        return
    job = Job.of(function, shared, sources)
    with (_dask if on.on_dask else _processes)(on, len(todo), job) as pool:
        begin()
        for left in _run_all(on, pool, todo, argument, store):
            progress(what, len(keys) - left, len(keys))


class _Pool(NamedTuple):
    submit: Callable[[str, Any], Future[Any]]
    size: Callable[[], int]  # number of workers, 1 at least
    lost: tuple[type[BaseException], ...]  # raised by a future whose worker is gone


def _run_all(
    on: Workers, pool: _Pool, todo: Sequence[str], argument: Callable[[str], Any], store: Store[Any]
) -> Iterator[int]:
    """Do all tasks; yields the number that is left whenever some are done."""
    waiting: dict[Future[Any], str] = {}
    rest = list(reversed(todo))
    while rest or waiting:
        with _lost_workers(on, OSError):
            free = _AHEAD * pool.size() - len(waiting)
        for key in [rest.pop() for _ in range(min(free, len(rest)))]:
            given = argument(key)
            with _lost_workers(on, OSError, *pool.lost):
                waiting[pool.submit(key, given)] = key
        wait(waiting, _COUNTED, FIRST_COMPLETED)
        done = [future for future in waiting if future.done()]
        for future in sorted(done, key=_failed):  # results are kept first
            with _lost_workers(on, *pool.lost):
                result = future.result()
            store.write(waiting.pop(future), result)
        yield len(rest) + len(waiting)


def _failed(future: Future[Any]) -> bool:
    return future.cancelled() or future.exception() is not None


@contextmanager
def _lost_workers(on: Workers, *lost: type[BaseException]) -> Iterator[None]:
    try:
        yield
    except lost as error:
        raise WorkerError(
            f"workers of {on} are gone ({type(error).__name__}: {error}). Computed results are"
            " kept, and the same command goes on where it was; where memory ran out, give fewer"
            " workers"
        ) from None


@contextmanager
def _processes(on: Workers, tasks: int, job: Job) -> Iterator[_Pool]:
    """Processes with one thread for linear algebra each; none outlives the caller."""
    count = min(on.processes or os.cpu_count() or 1, tasks)
    others = set(multiprocessing.active_children())
    spawn = multiprocessing.get_context("spawn")
    with _uninterrupted():
        begun = spawn.Semaphore(0)  # a worker has read the script of the caller
        # and not an argument, which a process that ends as it reads the script leaves half written
        jobs, sent = spawn.Queue(), pickle.dumps(job)
        jobs.cancel_join_thread()
        for _ in range(count):
            jobs.put(sent)
        executor = ProcessPoolExecutor(count, spawn, _begin_worker, (jobs, begun))

    def submit(key: str, argument: Any) -> Future[Any]:
        with _uninterrupted(), _environment_of_workers():
            return executor.submit(_run, key, argument)

    try:
        yield _Pool(submit, lambda: count, (BrokenExecutor,))
    except BaseException as error:
        ours, first = set(multiprocessing.active_children()) - others, begun.acquire(block=False)
        late = sum(process.is_alive() for process in ours) - first
        # what a worker has started to import a package would be left alone
        while late > 0 and begun.acquire(timeout=_IMPORT):
            late -= 1
        for process in ours:
            process.terminate()  # a task may take minutes
        if isinstance(error, WorkerError) and not first:
            raise WorkerError(
                f"{on} ended before the first task. Each of them reads the script again: put the"
                ' call under `if __name__ == "__main__":`, in a file'
            ) from None
        raise
    finally:
        executor.shutdown(cancel_futures=True)


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Let Ctrl-C wait until processes and what they share are there as a whole."""
    if threading.current_thread() is not threading.main_thread():  # others are never interrupted
        yield
        return
    pressed: list[tuple[int, Any]] = []
    before = signal.signal(
        signal.SIGINT, lambda *signal_and_frame: pressed.append(signal_and_frame)
    )
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
        if pressed and callable(before):
            before(*pressed[0])


@contextmanager
def _environment_of_workers() -> Iterator[None]:
    """Begin processes with one thread for BLAS, and without Ctrl-C while they import."""
    before = {name: os.environ.get(name) for name in (THREADS, "OPENBLAS_NUM_THREADS")}
    os.environ |= dict.fromkeys(before, "1")  # read before NumPy
    blocks = hasattr(signal, "pthread_sigmask")  # not on Windows
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}) if blocks else None
    try:
        yield
    finally:
        if mask is not None:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        for name, value in before.items():
            del os.environ[name]
            os.environ |= {} if value is None else {name: value}


_JOBS: list[Job] = []  # of this worker process


def _begin_worker(jobs: Queue[bytes], begun: Semaphore) -> None:
    begun.release()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the caller, which ends this one
    threading.Thread(target=_end_with_parent, daemon=True).start()
    _JOBS[:] = [pickle.loads(jobs.get())]


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


def _run(key: str, argument: Any) -> Any:
    return _JOBS[0].run(key, argument, "a worker process")


@contextmanager
def local_cluster(workers: int | None) -> Iterator[str]:
    """Address of a scheduler with workers on this machine, which Dask restarts when they die."""
    distributed = _import_dask()
    import dask

    settings = {
        "distributed.scheduler.allowed-failures": 10,  # of workers under one task
        "distributed.deploy.lost-worker-timeout": "1 h",  # a busy machine needs more than 15 s
        # watching the workers fifty to a hundred times a second took a fifth of their time
        "distributed.worker.profile.enabled": False,
        "distributed.admin.tick.interval": "500ms",
    }
    with (
        dask.config.set(settings),
        distributed.LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            dashboard_address="127.0.0.1:0",
            silence_logs=logging.CRITICAL + 1,
            preload=[__name__],
        ) as cluster,
    ):
        yield cluster.scheduler_address


def dask_setup(worker: object) -> None:
    """Leave Ctrl-C to the process that made the cluster; Dask calls this when a worker begins."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _import_dask() -> Any:
    try:
        import distributed
    except ImportError as error:
        raise MissingPackageError(
            f"--workers and --scheduler need Dask ({error}); pip install 'tendon-mj[cluster]'"
        ) from None
    return distributed


@contextmanager
def _dask(on: Workers, tasks: int, job: Job) -> Iterator[_Pool]:
    """Workers of a Dask scheduler, as many as there are at a time."""
    distributed = _import_dask()
    with ExitStack() as stack:
        address = on.scheduler or stack.enter_context(local_cluster(min(on.workers or 1, tasks)))
        # errors are raised; Dask would also print a traceback of each lost connection
        for logger in ("distributed", "tornado.application"):
            stack.enter_context(
                distributed.utils.silence_logging_cmgr(logging.CRITICAL + 1, logger)
            )
        client = stack.enter_context(_client(distributed, address))
        with _lost_workers(on, OSError, CancelledError):
            answers = client.run(_identity_on_dask, job.sources, on_error="return")
            for worker, there in answers.items():
                where = f"worker {worker} of the scheduler at {address}"
                if isinstance(there, BaseException):
                    raise WorkerError(
                        f"{where} cannot load tendon_mj: {there}; install the same there"
                    )
                expected = {**job.expected, _NTHREADS: "1"}
                check_same({name: expected[name] for name in there}, there, where)
            with warnings.catch_warnings():
                warnings.filterwarnings("ignore", "Sending large graph")  # once a run
                # a task and not scattered data: it is done again where its worker died
                sent = client.submit(_same, job, pure=False)
        submit = client.get_executor(pure=False).submit
        yield _Pool(
            lambda key, argument: submit(_run_on_dask, sent, key, argument),
            lambda: max(1, len(client.nthreads())),
            (CancelledError, distributed.KilledWorker),
        )


def _client(distributed: Any, address: str) -> Any:
    try:
        client = distributed.Client(address, timeout=_CONNECT, set_as_default=False)
    except (OSError, ValueError) as error:
        raise WorkerError(
            f"no Dask scheduler answers at {address} ({error}); start one with `dask scheduler`,"
            " which prints its address"
        ) from None
    try:
        client.wait_for_workers(1, timeout=_FIRST_WORKER)
    except TimeoutError:
        client.close()
        raise WorkerError(
            f"the scheduler at {address} has no workers; start some with"
            f" `dask worker {address} --nworkers 2 --nthreads 1`"
        ) from None
    return client


def _identity_on_dask(sources: tuple[str, ...], dask_worker: Any) -> dict[str, str]:
    return {**identity(sources), _NTHREADS: str(dask_worker.state.nthreads)}


def _same(job: Job) -> Job:
    return job


def _run_on_dask(job: Job, key: str, argument: Any) -> Any:
    from distributed import get_worker

    worker = get_worker()
    where = f"worker {worker.address}"  # that may have joined later
    check_same({_NTHREADS: "1"}, {_NTHREADS: str(worker.state.nthreads)}, where)
    return job.run(key, argument, where)
