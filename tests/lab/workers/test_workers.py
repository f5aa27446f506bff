"""Laws of tasks on this machine's processes; those of Dask are in test_dask.py."""

import os
import pickle
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tendon_mj.errors import InvalidValueError, TendonError, WorkerError
from tendon_mj.lab import workers
from tendon_mj.lab.parquet_parts import ParquetParts
from tendon_mj.lab.workers import Workers, identity, run_tasks
from tests.lab.workers import functions
from tests.lab.workers.functions import KEYS, Kept, number
from tests.refusals import refusing

ROOT = Path(__file__).parents[3]
unix = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGKILL")


def run(function, shared, store, **options):
    run_tasks(function, shared, KEYS, number, store, **options)
    return store


@unix
def test_a_killed_process_ends_the_run_and_the_next_goes_on(tmp_path):
    store, on = Kept(), Workers(processes=1)
    with refusing(WorkerError, "goes on where it was"):
        run(functions.mortal, str(tmp_path), store, on=on)
    assert store.results == {key: number(key) for key in KEYS[:3]}
    run(functions.mortal, str(tmp_path), store, on=on)
    assert store.results == {key: number(key) for key in KEYS}
    assert sorted(store.written) == KEYS  # each once


def test_what_was_done_before_is_not_computed_again_and_progress_says_so():
    store, shown = Kept(done=KEYS[:10]), []
    before = os.environ.get(workers.THREADS)
    run(functions.threads, 3, store, on=Workers(processes=1), progress=lambda *a: shown.append(a))
    assert store.results == {"task_10": "1", "task_11": "1"}  # one thread for linear algebra
    assert os.environ.get(workers.THREADS) == before
    assert shown[0] == ("tasks", 10, 12)
    assert shown[-1] == ("tasks", 12, 12)
    run(functions.doomed, None, Kept(done=KEYS))  # begins no process


def test_a_refusal_names_the_task_and_ends_the_run():
    with pytest.raises(TendonError, match="task_00: 0 is too much"):
        run(functions.refused, None, Kept(), on=Workers(processes=1))


PROGRAM = """
import os, sys
from pathlib import Path
from tendon_mj.lab.parquet_parts import ParquetParts
from tendon_mj.lab.workers import Workers, run_tasks
from tests.lab.workers.functions import KEYS, number, row
if __name__ == "__main__":
    store = ParquetParts(Path(sys.argv[1], "rows"))
    run_tasks(row, sys.argv[1], KEYS, number, store, on=Workers(processes=1))
"""


@unix
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
    time.sleep(0.5)
    completed = (tmp_path / "log").read_text().split()
    store = ParquetParts(rows)
    before = {path.name: path.stat().st_mtime_ns for path in rows.glob("task_*")}
    assert len(completed) <= len(before) + 2  # the worker ended with its client
    run(functions.row, str(tmp_path), store, on=Workers(processes=1))
    after = {path.name: path.stat().st_mtime_ns for path in rows.glob("task_*")}
    assert after.items() >= before.items()
    assert store.read()["k"].tolist() == list(range(len(KEYS)))


@pytest.mark.parametrize("given", ["program.py", "-"])
def test_a_script_that_workers_cannot_read_again_is_told_how(tmp_path, given):
    """Without `if __name__ …` it begins itself anew; from standard input there is no file."""
    guard = 'if __name__ == "__main__":'
    text = PROGRAM.replace("sys.argv[1], KEYS", "sys.argv[1] + 2**20 * ' ', KEYS")  # as a model is
    text = text if given == "-" else text.replace(guard, "if True:")
    (tmp_path / "program.py").write_text(text)
    command = [sys.executable, given, str(tmp_path)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    ended = subprocess.run(
        command,
        input=text,
        env=environment,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=60,
    )
    message = ended.stderr.splitlines()[-1]
    assert guard in message
    assert "memory" not in message
    if given != "-":
        assert ended.stderr.count("Traceback") == 1  # the caller's alone


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
    monkeypatch.setenv(workers.THREADS, "1")
    sent = workers.Job.of(functions.scaled, 2, ("tendon_mj",))
    assert sent.run("task", 3, "here") == 6
    other = replace(sent, expected={**sent.expected, name: "9.9"})
    with refusing(WorkerError, f"{name}: {identity()[name]} there, 9.9 here"):
        other.run("task", 3, "there")


def test_a_worker_with_another_model_or_more_threads_is_refused(monkeypatch):
    monkeypatch.setenv(workers.THREADS, "1")
    sent = pickle.loads(
        pickle.dumps(workers.Job.of(functions.scaled, Modelled("abc"), ("tendon_mj",)))
    )
    with pytest.raises(WorkerError, match="model arm: abc, read otherwise there, abc here"):
        sent.run("task", 3, "there")
    monkeypatch.setenv(workers.THREADS, "8")
    with pytest.raises(WorkerError, match=r"OMP_NUM_THREADS: 8 there, 1 here.*--nthreads 1"):
        sent.run("task", 3, "there")


def test_sources_count_and_not_only_versions(tmp_path, monkeypatch):
    for name, text in (("first_form", "a = 1\n"), ("second_form", "a = 2\n")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    forms = identity(("first_form", "second_form"))
    assert forms["first_form"] != forms["second_form"]


@pytest.mark.parametrize(
    ("given", "facts"),
    [
        ({"processes": 2, "workers": 2}, ["--processes 2", "--workers 2"]),
        ({"workers": 0}, ["--workers 0", "1 … 1024"]),
        ({"processes": 2**31}, ["--processes 2147483648", "1 … 1024"]),
        ({"scheduler": "foo"}, ["--scheduler foo", "tcp://10.0.0.1:8786"]),
        ({"scheduler": "10.0.0.1:8786"}, ["--scheduler 10.0.0.1:8786"]),
        ({"scheduler": "tcp://10.0.0.1"}, ["--scheduler tcp://10.0.0.1"]),
    ],
)
def test_workers_are_one_kind_and_some_and_a_scheduler_has_an_address(given, facts):
    with refusing(InvalidValueError, *facts):
        Workers(**given)


@pytest.fixture
def rows(tmp_path):
    pytest.importorskip("pyarrow", reason="the extra tendon-mj[parquet] is not installed")
    return tmp_path / "rows"


def test_parts_are_one_table_in_the_order_of_their_keys(rows):
    parts = ParquetParts(rows)
    assert parts.read() == {}
    for key in ("b", "a"):
        parts.write(key, {"x": np.array([ord(key), 0]), "is": np.array([True, False])})
    (rows / ".c.99.parquet").write_bytes(b"half")  # of a run that was killed
    assert parts.done() == {"a", "b"}
    assert parts.read(["x"])["x"].tolist() == [97, 0, 98, 0]
    assert ParquetParts(rows, again=True).done() == set()
    (rows / "mine.parquet").write_bytes(b"mine")
    parts.clear()
    assert [path.name for path in rows.iterdir()] == ["mine.parquet"]
    assert parts.read() == {}


def test_a_part_that_is_damaged_or_of_another_run_is_computed_again(rows, tmp_path):
    one = {"x": np.array([1])}
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
