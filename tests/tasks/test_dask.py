"""Laws of tasks on a Dask scheduler, with two workers on this machine."""

import sys

import pytest

from tendon_mj.errors import WorkerError
from tendon_mj.tasks import Workers, run_tasks
from tests.tasks import functions
from tests.tasks.functions import Kept

pytest.importorskip("distributed", reason="the extra tendon-mj[cluster] is not installed")
pytestmark = pytest.mark.filterwarnings("default")  # Dask's own

KEYS = [f"task_{k:02d}" for k in range(12)]
NUMBERS = {key: k for k, key in enumerate(KEYS)}


@pytest.fixture(scope="module")
def scheduler():
    """Address of a scheduler with two workers."""
    from tendon_mj.tasks import local_cluster

    with local_cluster(2) as address:
        yield address


def run(function, shared, **where):
    store = Kept()
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
    from tendon_mj.tasks import dask_pool

    real = dask_pool.identity()["mujoco"]
    here = lambda sources: {"mujoco": "9.9"}  # noqa: E731
    monkeypatch.setattr(dask_pool, "_expected", here)
    with pytest.raises(WorkerError, match=f"worker tcp.* mujoco: {real} there, 9.9 here"):
        run(functions.doomed, None, scheduler=scheduler)


def test_an_address_where_nobody_answers_is_refused(monkeypatch):
    from tendon_mj.tasks import dask_pool

    monkeypatch.setattr(dask_pool, "_CONNECT", 0.3)
    with pytest.raises(WorkerError, match="no Dask scheduler answers at tcp"):
        run(functions.scaled, 1, scheduler="tcp://127.0.0.1:1")
