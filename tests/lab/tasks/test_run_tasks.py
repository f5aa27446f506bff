"""Laws of tasks on this machine's processes; those of Dask are beside them in test_dask.py."""

import dataclasses
import os
import pickle
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from tendon_mj.errors import InvalidValueError, TendonError, WorkerError
from tendon_mj.lab.tasks import ParquetParts, Workers, identity, process_pool, run_tasks
from tendon_mj.lab.tasks.identity import THREADS
from tendon_mj.lab.tasks.job import Job
from tendon_mj.lab.tasks.workers import MOST
from tests.lab.tasks import functions
from tests.lab.tasks.functions import Kept

ROOT = Path(__file__).parents[2]
KEYS = [f"task_{k:02d}" for k in range(12)]


def number(key):
    return int(key.rpartition("_")[2])


def run(function, shared, store, **options):
    run_tasks(function, shared, KEYS, number, store, **options)
    return store


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGKILL")
def test_a_killed_process_loses_no_result(tmp_path):
    store = run(functions.mortal, str(tmp_path), Kept(), on=Workers(processes=2))
    assert store.results == {key: number(key) for key in KEYS}
    assert sorted(store.written) == KEYS  # each once
    completed = (tmp_path / "log").read_text().split()
    assert len(completed) <= len(KEYS) + 1  # but what the other process was at


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGKILL")
def test_a_process_killed_while_it_answers_halts_nothing(tmp_path, monkeypatch):
    files = tmp_path / "files"
    files.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(files))
    store = run(functions.killed_while_it_answers, str(tmp_path), Kept(), on=Workers(processes=2))
    assert [len(store.results[key]) for key in KEYS] == [1_000_000 + number(k) for k in KEYS]
    assert list(files.iterdir()) == []


def test_what_was_done_before_is_not_computed_again_and_progress_says_so():
    store, said = Kept(done=KEYS[:10]), []
    run(functions.threads, 3, store, on=Workers(processes=1), progress=lambda *a: said.append(a))
    one_thread = "1"  # for linear algebra
    assert store.results == {"task_10": one_thread, "task_11": one_thread}
    assert said[0] == ("tasks", 10, 12)
    assert said[-1] == ("tasks", 12, 12)
    run(functions.doomed, None, Kept(done=KEYS))  # begins no process


def test_what_is_begun_is_begun_once_workers_are_there(monkeypatch):
    begun = []
    run(functions.doomed, None, Kept(done=KEYS), begin=lambda: begun.append("nothing to do"))
    on = Workers(processes=1)
    run(functions.threads, 3, Kept(done=KEYS[1:]), on=on, begin=lambda: begun.append("one task"))
    monkeypatch.setattr(Workers, "opened", lambda *a: (_ for _ in ()).throw(WorkerError("none")))
    with pytest.raises(WorkerError):
        run(functions.threads, 3, Kept(), begin=lambda: begun.append("no workers"))
    assert begun == ["nothing to do", "one task"]


def test_a_refusal_names_the_task_and_ends_the_run():
    with pytest.raises(TendonError, match="task_00: 0 is too much"):
        run(functions.refused, None, Kept(), on=Workers(processes=1))


PROGRAM = """
import sys
from tendon_mj.lab.tasks import ParquetParts, Workers, run_tasks
from tests.lab.tasks.test_run_tasks import KEYS, number, row
if __name__ == "__main__":
    store = ParquetParts(__import__("pathlib").Path(sys.argv[1], "rows"))
    run_tasks(row, sys.argv[1], KEYS, number, store, on=Workers(processes=1))
"""


def row(folder, k):
    """A table of one row, after a moment."""
    functions.logged(folder, k)
    time.sleep(0.05)
    return {"k": np.array([k])}


def test_a_killed_client_goes_on_where_it_was(tmp_path):
    pytest.importorskip("pyarrow", reason="the extra tendon-mj[parquet] is not installed")
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)
    command = [sys.executable, str(program), str(tmp_path)]
    process = subprocess.Popen(command, env={**os.environ, "PYTHONPATH": str(ROOT)})
    rows = tmp_path / "rows"
    while not rows.exists() or len(list(rows.glob("task_*"))) < 4:
        assert process.poll() is None
        time.sleep(0.01)
    process.kill()
    process.wait()
    store = ParquetParts(rows)
    before = {path.name: path.stat().st_mtime_ns for path in rows.glob("task_*")}
    run(row, str(tmp_path), store, on=Workers(processes=1))
    after = {path.name: path.stat().st_mtime_ns for path in rows.glob("task_*")}
    assert after.items() >= before.items()
    assert store.read()["k"].tolist() == list(range(len(KEYS)))
    completed = (tmp_path / "log").read_text().split()
    assert len(completed) <= len(KEYS) + 2  # one that ran, and one whose result was on its way


class Modelled:
    """Shared data with an identity, as of a model."""

    def __init__(self, digest):
        self.digest = digest

    def identity(self):
        return {"model arm": self.digest}

    def __reduce__(self):
        return Modelled, (f"{self.digest}, read otherwise",)


@pytest.mark.parametrize("name", ["python", "mujoco", "numpy", "tendon_mj"])
def test_a_worker_with_another_version_is_refused_with_both(name, monkeypatch):
    monkeypatch.setenv(THREADS, "1")
    job = Job.of(functions.scaled, 2, ("tendon_mj",), pickle.dumps)
    assert job.run("task", 3) == 6
    other = dataclasses.replace(job, expected={**job.expected, name: "9.9"}, digest=name)
    with pytest.raises(WorkerError, match=f"{name}: {identity()[name]} there, 9.9 here"):
        other.run("task", 3)


def test_a_worker_with_another_model_or_more_threads_is_refused(monkeypatch):
    monkeypatch.setenv(THREADS, "1")
    job = Job.of(functions.scaled, Modelled("abc"), ("tendon_mj",), pickle.dumps)
    with pytest.raises(WorkerError, match="model arm: abc, read otherwise there, abc here"):
        job.run("task", 3)
    monkeypatch.setenv(THREADS, "8")
    with pytest.raises(WorkerError, match=r"OMP_NUM_THREADS: 8 there, 1 here.*--nthreads 1"):
        job.run("task", 3)


def test_sources_count_and_not_only_versions(tmp_path, monkeypatch):
    for name, text in (("first_form", "a = 1\n"), ("second_form", "a = 2\n")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    found = identity(("first_form", "second_form"))
    assert found["first_form"] != found["second_form"]


def test_no_more_processes_are_begun_than_there_are_tasks(monkeypatch):
    begun = []

    class Counted(ProcessPoolExecutor):
        """Tells of how many processes it may be."""

        def __init__(self, count, *arguments):
            begun.append(count)
            super().__init__(count, *arguments)

    monkeypatch.setattr(process_pool, "ProcessPoolExecutor", Counted)
    store = run(functions.scaled, 2, Kept(done=KEYS[:10]), on=Workers(processes=MOST))
    assert store.results == {key: 2 * number(key) for key in KEYS[10:]}
    assert begun == [2]


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"processes": 2, "workers": 2}, "--processes 2 and --workers 2: give one of them"),
        ({"workers": 0}, "--workers 0: there must be at least one"),
        ({"processes": 2**31}, "--processes 2147483648: at most 1024; one a core"),
        ({"workers": 1025}, "--workers 1025: at most 1024"),
        ({"scheduler": "foo"}, "--scheduler foo: it is not like tcp://10.0.0.1:8786"),
        ({"scheduler": "10.0.0.1:8786"}, "it is not like tcp"),
        ({"scheduler": "tcp://10.0.0.1"}, "it is not like tcp"),
    ],
)
def test_workers_are_one_kind_and_some_and_a_scheduler_has_an_address(given, said):
    with pytest.raises(InvalidValueError, match=said):
        Workers(**given)


def test_parts_are_one_table_in_the_order_of_their_keys(tmp_path):
    pyarrow = pytest.importorskip("pyarrow", reason="the extra tendon-mj[parquet] is not installed")
    parts = ParquetParts(tmp_path / "rows")
    assert parts.read() == {}
    for key in ("b", "a"):
        parts.write(key, {"x": np.array([ord(key), 0]), "is": np.array([True, False])})
    (tmp_path / "rows" / ".c.99.parquet").write_bytes(b"half")  # of a run that was killed
    assert parts.done() == {"a", "b"}
    assert parts.read(["x"])["x"].tolist() == [97, 0, 98, 0]
    foreign, own = tmp_path / "rows" / "mine.parquet", tmp_path / "rows" / "b.parquet"
    pyarrow.parquet.write_table(pyarrow.table({"x": [1]}), foreign)
    with pytest.raises(InvalidValueError, match=r"mine.*is no table of this run"):
        parts.refuse_foreign({"a", "b"}, others=True)
    foreign.write_bytes(b"notes")
    with pytest.raises(InvalidValueError, match=r"mine.*is no table of this run"):
        parts.refuse_foreign({"a", "b"}, others=True)
    foreign.unlink()
    foreign.mkdir()
    with pytest.raises(InvalidValueError, match=r"mine.*is no table of this run"):
        parts.refuse_foreign({"a", "b"}, others=True)
    foreign.rmdir()
    own.write_bytes(own.read_bytes()[:-9])
    parts.refuse_foreign({"a", "b"}, others=True)
    with pytest.raises(InvalidValueError, match=r"b.*is no table of this run"):
        parts.refuse_foreign({"a"}, others=True)
    parts.write("b", {"x": np.array([0])})
    parts.refuse_foreign({"a"}, others=True)  # of another run, and cleared
    with pytest.raises(InvalidValueError, match=r"b.*is no table of this run"):
        parts.refuse_foreign({"a"}, others=False)
    assert ParquetParts(tmp_path / "rows", again=True).done() == set()
    parts.clear()
    assert not list((tmp_path / "rows").iterdir())
    assert parts.read() == {}


def test_a_part_that_is_damaged_or_of_another_run_is_computed_again(tmp_path):
    pytest.importorskip("pyarrow", reason="the extra tendon-mj[parquet] is not installed")
    rows, one = tmp_path / "rows", {"x": np.array([1])}
    parts, other = ParquetParts(rows, "this run"), ParquetParts(tmp_path / "other", "another run")
    for key in ("cut", "empty", "whole"):
        parts.write(key, one)
    other.write("foreign", {"y": np.array(["z"])})
    cut, empty = rows / "cut.parquet", rows / "empty.parquet"
    cut.write_bytes(cut.read_bytes()[:-20])
    empty.write_bytes(b"")
    (tmp_path / "other" / "foreign.parquet").rename(rows / "foreign.parquet")
    (rows / "renamed.parquet").write_bytes((rows / "whole.parquet").read_bytes())
    again = ParquetParts(rows, "this run")
    assert again.done() == {"whole"}
    assert {name: values.tolist() for name, values in again.read().items()} == {"x": [1]}
    again.write("cut", one)
    assert again.read()["x"].tolist() == [1, 1]


def test_a_part_that_was_damaged_since_is_refused_by_its_name(tmp_path):
    pytest.importorskip("pyarrow", reason="the extra tendon-mj[parquet] is not installed")
    parts = ParquetParts(tmp_path / "rows")
    for key in ("a", "b"):
        parts.write(key, {"x": np.arange(9)})
    (tmp_path / "rows" / "b.parquet").write_bytes(b"PAR1")
    with pytest.raises(InvalidValueError, match=r"b\.parquet cannot be read .*; remove it, and"):
        parts.read()
