"""Where tasks run: processes of this machine, local workers of Dask, or those of a scheduler."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, Final

from tendon_mj.errors import InvalidValueError, MissingPackageError
from tendon_mj.lab.tasks.job import Function
from tendon_mj.lab.tasks.pool import Pool
from tendon_mj.lab.tasks.process_pool import process_pool

MOST: Final = 1024  # processes or workers that this machine is asked for
_ADDRESS = re.compile(r"\w+://.+:\d{1,5}")


@dataclass(frozen=True, kw_only=True)
class Workers:
    """Where tasks run; at most one of the three is given.

    Attributes:
        processes: of this machine, without Dask; default: as many as it has cores.
        workers: of a Dask cluster that lives as long as the run.
        scheduler: address of a Dask scheduler, such as tcp://10.0.0.1:8786.

    Raises:
        InvalidValueError: two of them, less than one process or worker or more than `MOST`, or an
            address without a scheme or port.
    """

    processes: int | None = None
    workers: int | None = None
    scheduler: str | None = None

    def __post_init__(self) -> None:
        given = {name: value for name, value in vars(self).items() if value is not None}
        if len(given) > 1:
            options = " and ".join(f"--{name} {value}" for name, value in given.items())
            raise InvalidValueError(f"{options}: give one of them, which says where tasks run")
        for name in ("processes", "workers"):
            if given.get(name, 1) < 1:
                raise InvalidValueError(f"--{name} {given[name]}: there must be at least one")
            if given.get(name, 1) > MOST:
                raise InvalidValueError(
                    f"--{name} {given[name]}: at most {MOST}; one a core computes fastest, and"
                    f" this machine has {os.cpu_count() or 1}"
                )
        if self.scheduler is not None and not _ADDRESS.fullmatch(self.scheduler):
            raise InvalidValueError(
                f"--scheduler {self.scheduler}: it is not like tcp://10.0.0.1:8786, the address"
                " that `dask scheduler` prints"
            )

    def opened(
        self, function: Function, shared: Any, sources: Sequence[str], tasks: int
    ) -> AbstractContextManager[Pool]:
        """A pool that does the tasks of a function; see `run_tasks`.

        No more processes or local workers are begun than there are ``tasks``.

        Raises:
            MissingPackageError: Dask is wanted and not installed.
        """
        if self.workers is None and self.scheduler is None:
            count = min(self.processes or os.cpu_count() or 1, tasks)
            return process_pool(count, function, shared, sources)
        try:
            from tendon_mj.lab.tasks.dask_pool import dask_pool
        except ImportError as error:
            raise MissingPackageError(
                f"--workers and --scheduler need Dask ({error}); pip install 'tendon-mj[cluster]'"
            ) from None
        workers = self.workers and min(self.workers, tasks)
        return dask_pool(workers, self.scheduler, function, shared, sources)

    def __str__(self) -> str:
        if self.scheduler is not None:
            return f"the scheduler at {self.scheduler}"
        if self.workers is not None:
            return f"{self.workers} local worker{'s' if self.workers > 1 else ''} of Dask"
        count = self.processes or os.cpu_count() or 1
        return f"{count} process{'es' if count > 1 else ''}"
