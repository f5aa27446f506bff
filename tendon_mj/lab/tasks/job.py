"""What every task of a run shares, as it is sent to a worker once, and one task done there."""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tendon_mj.errors import TendonError, WorkerError
from tendon_mj.lab.tasks.identity import THREADS, check_same, identity

Function = Callable[[Any, Any], Any]  # (what is shared, argument of the task) → result


@dataclass(frozen=True)
class Job:
    """Function and shared data of a run, pickled.

    Attributes:
        content: the pickle of both.
        sources: packages of which the sources count.
        expected: what a worker has to compute with.
        digest: of the content.
    """

    content: bytes
    sources: tuple[str, ...]
    expected: Mapping[str, str]
    digest: str

    @staticmethod
    def of(
        function: Function,
        shared: Any,
        sources: Sequence[str],
        dumps: Callable[[Any], bytes],
    ) -> Job:
        """The job of a run; ``shared`` may have an ``identity()`` of its own, as of its model."""
        content = dumps((function, shared))
        expected = {**identity(sources), THREADS: "1", **_own_identity(shared)}
        digest = hashlib.sha256(content).hexdigest()
        return Job(content, tuple(sources), expected, digest)

    def run(self, key: str, argument: Any, worker: str = "a worker") -> Any:
        """Do one task in this process, which is to compute as the one that made the job does.

        Args:
            key: of the task.
            argument: of the function.
            worker: names this process.

        Raises:
            WorkerError: it would not.
            TendonError: the task was refused; the message begins with its key.
        """
        if self.digest not in _LOADED:
            here = identity(self.sources)
            check_same({name: self.expected[name] for name in here}, here, worker)
            loaded = pickle.loads(self.content)
            check_same(self.expected, {**here, **_own_identity(loaded[1])}, worker)
            _LOADED.clear()  # of the run before
            _LOADED[self.digest] = loaded
        function, shared = _LOADED[self.digest]
        try:
            return function(shared, argument)
        except TendonError as error:  # with a text alone, which every process can read
            kind = WorkerError if isinstance(error, WorkerError) else TendonError
            raise kind(f"{key}: {error}") from None


_LOADED: dict[str, tuple[Function, Any]] = {}  # digest of a job → its content, in a worker


def _own_identity(shared: Any) -> Mapping[str, str]:
    found: Mapping[str, str] = shared.identity() if hasattr(shared, "identity") else {}
    return found
