"""A cluster of Dask on this machine (extra `cluster`)."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager

from tendon_mj.errors import MissingPackageError

_ALLOWED_LOSSES = 10  # of workers under one task
_REPLACED = "1 h"  # until a worker that died is given up; a busy machine takes more than 15 s


@contextmanager
def local_cluster(workers: int | None) -> Iterator[str]:
    """Address of a scheduler with workers on this machine, which are begun anew when they die.

    Args:
        workers: processes with one thread each; default: as many as there are cores.

    Raises:
        MissingPackageError: Dask is not installed.
    """
    try:
        import dask
        import distributed
    except ImportError as error:
        raise MissingPackageError(
            f"workers of a cluster need Dask ({error}); pip install 'tendon-mj[cluster]'"
        ) from None
    settings = {
        "distributed.scheduler.allowed-failures": _ALLOWED_LOSSES,
        "distributed.deploy.lost-worker-timeout": _REPLACED,
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
            preload=["tendon_mj.lab.tasks.worker_setup"],
        ) as cluster,
    ):
        yield cluster.scheduler_address
