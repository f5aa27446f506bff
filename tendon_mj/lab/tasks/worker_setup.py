"""What a worker of a local Dask cluster does first; Dask loads it by its name."""

from __future__ import annotations

import signal


def dask_setup(worker: object) -> None:
    """Leave Ctrl-C to the process that made the cluster, which then ends the workers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
