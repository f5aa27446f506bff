"""Laws of tasks on a Dask scheduler, with two workers on this machine."""

import sys
from pathlib import Path

import pytest

from tendon_mj.errors import WorkerError
from tendon_mj.lab import workers
from tendon_mj.lab.workers import Workers, identity, local_cluster, run_tasks
from tests.lab.workers import functions
from tests.lab.workers.functions import KEYS, Kept, number
from tests.refusals import refusing

pytest.importorskip("distributed", reason="the extra tendon-mj[cluster] is not installed")
pytestmark = pytest.mark.filterwarnings("default")  # Dask's own

ROOT = Path(__file__).parents[3]
NUMBERS = {key: number(key) for key in KEYS}


@pytest.fixture(scope="module")
def scheduler():
    """Address of a scheduler with two workers."""
    with local_cluster(2) as address:
        yield address


def run(function, shared, store=None, **where):
    store = store or Kept()
    run_tasks(function, shared, KEYS, number, store, on=Workers(**where))
    return store


def test_a_scheduler_s_workers_give_what_processes_give(scheduler):
    store = run(functions.scaled, 0.1, scheduler=scheduler)
    assert store.results == {key: 0.1 * k for key, k in NUMBERS.items()}
    assert sorted(store.written) == KEYS


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGKILL")
def test_a_lost_worker_loses_only_its_tasks(scheduler, tmp_path):
    store = run(functions.mortal, str(tmp_path), scheduler=scheduler)
    assert store.results == NUMBERS
    assert sorted(store.written) == KEYS
    assert len((tmp_path / "log").read_text().split()) <= len(KEYS) + 2 * 2  # under way


@pytest.mark.parametrize("later", [False, True])
def test_workers_with_another_version_are_named(later, scheduler, monkeypatch):
    real = workers.identity
    monkeypatch.setattr(workers, "identity", lambda sources: {**real(sources), "mujoco": "9.9"})
    if later:  # they were not there when the run began
        monkeypatch.setattr(workers, "_identity_on_dask", lambda sources, dask_worker: {})
    with pytest.raises(WorkerError, match=r"worker tcp://127\.0\.0\.1:\d+") as refused:
        run(functions.doomed, None, scheduler=scheduler)
    assert f"mujoco: {identity()['mujoco']} there, 9.9 here" in str(refused.value)


def test_an_address_where_nobody_answers_is_refused(monkeypatch):
    monkeypatch.setattr(workers, "_CONNECT", 0.3)
    with refusing(WorkerError, "tcp://127.0.0.1:1", "dask scheduler"):
        run(functions.scaled, 1, scheduler="tcp://127.0.0.1:1")
