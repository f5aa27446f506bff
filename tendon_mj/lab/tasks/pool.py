"""What all kinds of workers have in common."""

from __future__ import annotations

from concurrent.futures import Future
from typing import Any, Protocol


class Pool(Protocol):
    """Workers that do the tasks of one job.

    Attributes:
        lost: exceptions of a future that mean that its worker died, and not that the task failed.
    """

    lost: tuple[type[BaseException], ...]

    def submit(self, key: str, argument: Any) -> Future[Any]:
        """Begin a task, or let it wait for a worker."""
        ...

    def result(self, done: Future[Any]) -> Any:
        """What a task gave that is done and did not fail."""
        ...

    def capacity(self) -> int:
        """Tasks that may be under way or wait at a worker, so that none is idle."""
        ...

    def check(self) -> None:
        """Raise `WorkerError` where nothing will come of waiting any longer."""
        ...

    def mend(self) -> None:
        """Replace workers that died, where nothing else does."""
        ...
