"""Laws of tasks on a Dask scheduler, with two workers on this machine."""

import gc
import io
import json
import logging
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tendon_mj.errors import WorkerError
from tendon_mj.lab.tasks import Workers, run_tasks
from tests.lab.tasks import functions
from tests.lab.tasks.functions import Kept

pytest.importorskip("distributed", reason="the extra tendon-mj[cluster] is not installed")
pytestmark = pytest.mark.filterwarnings("default")  # Dask's own

ROOT = Path(__file__).parents[2]
KEYS = [f"task_{k:02d}" for k in range(12)]
NUMBERS = {key: k for k, key in enumerate(KEYS)}


@pytest.fixture(scope="module")
def scheduler():
    """Address of a scheduler with two workers."""
    from tendon_mj.lab.tasks import local_cluster

    with local_cluster(2) as address:
        yield address


def run(function, shared, store=None, **where):
    store = store or Kept()
    run_tasks(function, shared, KEYS, NUMBERS.__getitem__, store, on=Workers(**where))
    return store


def test_a_scheduler_s_workers_give_what_processes_give(scheduler):
    found = run(functions.scaled, 0.1, scheduler=scheduler)
    assert found.results == {key: 0.1 * k for key, k in NUMBERS.items()}
    assert sorted(found.written) == KEYS


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGKILL")
def test_a_lost_worker_loses_only_its_tasks(scheduler, tmp_path):
    found = run(functions.mortal, str(tmp_path), scheduler=scheduler)
    assert found.results == NUMBERS
    assert sorted(found.written) == KEYS
    assert len((tmp_path / "log").read_text().split()) <= len(KEYS) + 2 * 2  # under way


def test_workers_with_other_versions_are_refused_before_they_get_a_task(scheduler, monkeypatch):
    from tendon_mj.lab.tasks import dask_pool

    real = dask_pool.identity()["mujoco"]
    here = lambda sources: {"mujoco": "9.9"}  # noqa: E731
    monkeypatch.setattr(dask_pool, "_expected", here)
    with pytest.raises(WorkerError, match=f"worker tcp.* mujoco: {real} there, 9.9 here"):
        run(functions.doomed, None, scheduler=scheduler)


def test_a_worker_that_comes_later_with_another_version_is_named(scheduler, monkeypatch):
    from tendon_mj.lab.tasks import dask_pool, job

    other = {**job.identity(), "mujoco": "9.9"}
    monkeypatch.setattr(dask_pool, "_check_workers", lambda *given: None)
    monkeypatch.setattr(job, "identity", lambda sources: other)
    with pytest.raises(WorkerError, match=r"worker tcp://127\.0\.0\.1:\d+ differs .*, 9\.9 here"):
        run(functions.doomed, None, scheduler=scheduler)


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "other://127.0.0.1:1"])
def test_an_address_where_nobody_answers_is_refused_and_nothing_is_left(address, monkeypatch):
    from tendon_mj.lab.tasks import dask_pool

    monkeypatch.setattr(dask_pool, "_CONNECT", 0.3)
    with pytest.raises(WorkerError, match=f"no Dask scheduler answers at {address}"):
        run(functions.scaled, 1, scheduler=address)
    client = dask_pool.distributed.Client
    clients = [one for one in gc.get_objects() if issubclass(type(one), client)]  # no dead proxies
    assert {one.status for one in clients} <= {"closed"}


class Ending(Kept):
    """Results in memory; a process is killed with the third."""

    def __init__(self, process):
        super().__init__()
        self.process = process

    def write(self, key, result):
        super().write(key, result)
        if len(self.results) == 3:
            self.process.kill()
            self.process.wait()


def test_a_scheduler_that_ends_is_told_in_one_line(tmp_path):
    log, address = io.StringIO(), tmp_path / "address"
    handler = logging.StreamHandler(log)
    handler.setLevel(logging.ERROR)
    loggers = [logging.getLogger(name) for name in ("distributed", "tornado.application")]
    command = [sys.executable, "-m", "dask"]
    options = ["--no-dashboard", "--scheduler-file", str(address)]
    own = {
        "env": {**os.environ, "PYTHONPATH": str(ROOT)},
        "stdout": subprocess.DEVNULL,
        "stderr": subprocess.DEVNULL,
    }
    on_loopback = ["--host", "127.0.0.1", "--port", "0"]
    begun = [subprocess.Popen([*command, "scheduler", *on_loopback, *options], **own)]
    for logger in loggers:
        logger.addHandler(handler)
    try:
        begun.append(subprocess.Popen([*command, "worker", "--nthreads", "1", *options], **own))
        while not address.exists() or not address.read_text():
            time.sleep(0.05)
        store = Ending(begun[0])
        scheduler = json.loads(address.read_text())["address"]
        with pytest.raises(
            WorkerError, match=r"scheduler.* is gone.* kept.* the same command goes"
        ):
            run(functions.logged, str(tmp_path), store, scheduler=scheduler)
    finally:
        for logger in loggers:
            logger.removeHandler(handler)
        for process in begun:
            process.terminate()
            process.wait()
    assert 3 <= len(store.results) < len(KEYS)
    assert log.getvalue() == ""
