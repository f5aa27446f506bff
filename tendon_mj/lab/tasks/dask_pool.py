"""Workers of Dask: of a cluster on this machine, or of a scheduler (extra `cluster`)."""

from __future__ import annotations

import logging
import time
import warnings
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError, Future
from contextlib import ExitStack, contextmanager
from typing import Any

import cloudpickle
import distributed
from distributed.comm import connect
from distributed.utils import LoopRunner, silence_logging_cmgr

from tendon_mj.errors import WorkerError
from tendon_mj.lab.tasks.identity import THREADS, check_same, identity
from tendon_mj.lab.tasks.job import Function, Job
from tendon_mj.lab.tasks.local_cluster import local_cluster

_AHEAD = 2  # tasks a worker: one that runs, and one that waits
_CONNECT, _WORKERS = 10.0, 60.0  # longest wait for a scheduler, and for its first worker [s]
_PATIENCE = 300.0  # with a scheduler that has lost all workers [s]
_COUNTED = 1.0  # interval at which workers are counted [s]


class DaskPool:
    """Workers that a client's scheduler has, as many as there are at a time."""

    lost: tuple[type[BaseException], ...] = (distributed.KilledWorker,)

    def __init__(self, client: distributed.Client, scheduler: str, job: Job) -> None:
        self._client = client
        self._executor = client.get_executor(pure=False)
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Sending large graph")  # once a run
            # a task and no scattered data: it is done anew where all workers that had it died
            self._job = client.submit(_same, job, key=f"job-{job.digest}", pure=False)
        self._scheduler = scheduler
        self._counted, self._seen, self._workers = -_COUNTED, time.monotonic(), 1

    def submit(self, key: str, argument: Any) -> Future[Any]:
        """Begin a task, or let it wait for a worker."""
        with _told_if_gone(self._scheduler):
            begun: Future[Any] = self._executor.submit(_run, self._job, key, argument)
        return begun

    def result(self, done: Future[Any]) -> Any:
        """What a task gave."""
        return done.result()

    def capacity(self) -> int:
        """Tasks under way or waiting."""
        return _AHEAD * max(1, self._count())

    def check(self) -> None:
        """Refuse to wait for a scheduler that has had no worker for minutes."""
        if not self._count() and time.monotonic() - self._seen > _PATIENCE:
            raise WorkerError(
                f"the scheduler at {self._scheduler} has had no worker for {_PATIENCE:g} s; start"
                " some, and the same command goes on where it was"
            )

    def _count(self) -> int:
        if time.monotonic() - self._counted > _COUNTED:
            with _told_if_gone(self._scheduler):
                self._workers = len(self._client.scheduler_info(n_workers=-1)["workers"])
            self._counted = time.monotonic()
            self._seen = self._counted if self._workers else self._seen
        return self._workers

    def mend(self) -> None:
        """Do nothing: others take the tasks over, and nannies replace the workers."""


@contextmanager
def dask_pool(
    workers: int | None,
    scheduler: str | None,
    function: Function,
    shared: Any,
    sources: Sequence[str],
) -> Iterator[DaskPool]:
    """Workers that do the tasks of a function.

    Args:
        workers: of a cluster made for this run, each a process with one thread.
        scheduler: address of one that runs already.
        function, shared, sources: see `run_tasks`.

    Raises:
        WorkerError: no scheduler answers, it has no worker, or one computes with other versions.
    """
    with ExitStack() as stack:
        if scheduler is None:
            scheduler = stack.enter_context(local_cluster(workers))
        # what goes wrong is raised; Dask would also print a traceback of each lost connection
        for logger in ("distributed", "tornado.application"):
            stack.enter_context(silence_logging_cmgr(logging.CRITICAL + 1, logger))
        client = stack.enter_context(_client(scheduler))
        with _told_if_gone(scheduler):
            _check_workers(client, scheduler, sources)
            pool = DaskPool(client, scheduler, Job.of(function, shared, sources, cloudpickle.dumps))
        yield pool


@contextmanager
def _told_if_gone(scheduler: str) -> Iterator[None]:
    try:
        yield
    except (OSError, CancelledError) as error:
        raise WorkerError(
            f"the scheduler at {scheduler} is gone ({error}); what was computed before is kept, and"
            " the same command goes on where it was"
        ) from None


async def _reach(scheduler: str) -> None:
    options = distributed.Security().get_connection_args("client")
    await (await connect(scheduler, timeout=_CONNECT, **options)).close()


def _client(scheduler: str) -> distributed.Client:
    try:
        # first without a client: one that fails to begin waits at its end for what it has not got
        LoopRunner().run_sync(_reach, scheduler)
        client = distributed.Client(scheduler, timeout=_CONNECT, set_as_default=False)
    except Exception as error:
        raise WorkerError(
            f"no Dask scheduler answers at {scheduler} ({error}); start one with `dask scheduler`,"
            " which prints its address"
        ) from None
    try:
        client.wait_for_workers(1, timeout=_WORKERS)
    except TimeoutError:
        client.close()
        raise WorkerError(
            f"the scheduler at {scheduler} has no worker; start some with"
            f" `dask worker {scheduler} --nworkers 2 --nthreads 1`"
        ) from None
    return client


def _check_workers(client: distributed.Client, scheduler: str, sources: Sequence[str]) -> None:
    """Refuse a worker with other versions before anything is sent to it."""
    expected = _expected(sources)
    threads = client.nthreads()
    answers = client.run(identity, tuple(sources), on_error="return")
    for worker, found in answers.items():
        where = f"worker {worker} of the scheduler at {scheduler}"
        if isinstance(found, BaseException):
            raise WorkerError(f"{where} cannot load tendon_mj: {found}; install the same there")
        check_same(expected, {**found, "--nthreads": str(threads.get(worker, 1))}, where)


def _expected(sources: Sequence[str]) -> dict[str, str]:
    return {**identity(sources), THREADS: "1", "--nthreads": "1"}


def _same(job: Job) -> Job:
    return job


def _run(job: Job, key: str, argument: Any) -> Any:
    # of workers that came after the first look too: threads would share one simulation
    worker = distributed.get_worker()
    name = f"worker {worker.address}"
    check_same({"--nthreads": "1"}, {"--nthreads": str(worker.state.nthreads)}, name)
    return job.run(key, argument, name)
