"""A function mapped over tasks that have keys; results are kept as they come."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from typing import Any, Protocol, TypeVar

from tendon_mj.errors import WorkerError
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.tasks.pool import Pool
from tendon_mj.lab.tasks.workers import Workers

Shared = TypeVar("Shared")
Argument = TypeVar("Argument")
Result = TypeVar("Result")
_Result = TypeVar("_Result", contravariant=True)
_CHECKED = 10.0  # longest interval at which workers are looked at [s]
_LOSSES = 5  # of workers in a row, without a result in between


class Store(Protocol[_Result]):
    """Where results are kept, each whole or not at all."""

    def done(self) -> Collection[str]:
        """Keys of the tasks whose result is kept."""
        ...

    def write(self, key: str, result: _Result) -> None:
        """Keep a result."""
        ...


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

    Where it runs and with how many workers changes no number. What is under way is bounded by the
    number of workers, and so is memory. Whoever calls is the only one that writes: a run that is
    killed goes on where it was, and workers need no folder in common.

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

    Raises:
        WorkerError: a worker computes with something else than this process, or workers died
            ``5`` times without a result in between, or the scheduler is gone.
        TendonError: a task was refused; those that were computed before are kept.
    """
    kept = set(store.done())
    todo = [key for key in keys if key not in kept]
    progress(what, len(keys) - len(todo), len(keys))
    if not todo:
        begin()
    else:
        with (on or Workers()).opened(function, shared, sources, len(todo)) as pool:
            begin()
            _run_all(
                pool,
                todo,
                argument,
                store,
                lambda left: progress(what, len(keys) - left, len(keys)),
            )


def _run_all(
    pool: Pool,
    todo: list[str],
    argument: Callable[[str], Any],
    store: Store[Any],
    report: Callable[[int], None],
) -> None:
    rest, losses = todo[::-1], 0  # the next is last
    waiting: dict[Future[Any], str] = {}
    while rest or waiting:
        while rest and len(waiting) < pool.capacity():
            key = rest.pop()
            waiting[pool.submit(key, argument(key))] = key
        finished, _ = wait(waiting, _CHECKED, FIRST_COMPLETED)
        ended = {f: waiting.pop(f) for f in list(waiting) if f in finished}  # in their order
        failed, lost = dict[str, BaseException](), list[str]()
        for future, key in ended.items():
            error = CancelledError() if future.cancelled() else future.exception()
            if error is None:
                store.write(key, pool.result(future))
                losses = 0
            elif isinstance(error, pool.lost):
                lost.append(key)
            else:
                failed[key] = error
        for key, error in failed.items():
            raise _gone(key) if isinstance(error, CancelledError) else error
        if lost:
            losses += 1
            if losses >= _LOSSES:
                raise WorkerError(
                    f"workers died {losses} times in a row, the last time in {', '.join(lost)};"
                    " where memory ran out, give fewer workers. What was computed before is kept"
                )
            pool.mend()
            rest += sorted(lost, reverse=True)
        report(len(rest) + len(waiting))
        pool.check()


def _gone(key: str) -> WorkerError:
    return WorkerError(
        f"{key} was cancelled: the scheduler is gone. What was computed before is kept; the same"
        " command goes on from there"
    )
