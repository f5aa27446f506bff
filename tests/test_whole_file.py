"""A file is written whole or not at all, and an error names it."""

import errno
import os
import stat
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from tendon_mj.whole_file import whole_file


def test_the_new_text_takes_the_place_of_the_old(tmp_path):
    path = tmp_path / "result.json"
    path.write_text("old")
    with whole_file(path) as made:
        made.write_text("new")
        assert path.read_text() == "old"
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_a_failure_leaves_the_old_text_and_nothing_else(tmp_path):
    path = tmp_path / "clip.mp4"
    path.write_text("old")

    def fail():
        with whole_file(path) as made:
            made.write_text("half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_writers_of_alike_names_at_once_do_not_meet(tmp_path):
    def write(number):
        path = tmp_path / f"simulated_with_friction_{number}.csv"
        for _ in range(30):
            with whole_file(path) as made:
                made.write_text(f"{number}\n" * 2000)
            assert path.read_text() == f"{number}\n" * 2000

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(write, range(8)))
    assert len(list(tmp_path.iterdir())) == 8


def test_the_ending_stays_for_whoever_writes_by_it(tmp_path):
    with whole_file(tmp_path / "a.png") as made:
        assert made.suffix == ".png"
        made.touch()


def test_a_full_disk_names_the_file(tmp_path):
    path = tmp_path / "result.json"
    with pytest.raises(OSError, match=r"result\.json") as raised, whole_file(path):
        raise OSError(errno.ENOSPC, "No space left on device")  # as a write reports it
    assert raised.value.errno == errno.ENOSPC


def test_a_folder_that_is_not_there_names_the_file_and_not_its_neighbour(tmp_path):
    path = tmp_path / "none" / "result.json"
    with pytest.raises(FileNotFoundError) as raised, whole_file(path) as made:
        made.write_text("new")
    assert raised.value.filename == str(path)


def test_a_writer_that_names_the_neighbour_in_its_own_words_names_the_file(tmp_path):
    path = tmp_path / "table.parquet"
    with pytest.raises(OSError, match=r"table\.parquet") as raised, whole_file(path) as made:
        raise OSError(errno.EROFS, f"Failed to open local file '{made}'")  # as pyarrow does
    assert raised.value.filename == str(path)
    assert ".table." not in str(raised.value)


@pytest.mark.parametrize("code", [errno.EROFS, errno.EACCES])
def test_a_folder_that_refuses_names_the_file_and_not_its_neighbour(tmp_path, monkeypatch, code):
    """As a read-only file system does, which refuses to remove even what is not there."""

    def refuse(path, *_, **__):
        raise OSError(code, os.strerror(code), str(path))

    path = tmp_path / "result.json"
    path.write_text("old")
    monkeypatch.setattr(Path, "unlink", refuse)
    monkeypatch.setattr(Path, "write_text", refuse)
    with pytest.raises(OSError, match=r"result\.json") as raised, whole_file(path) as made:
        made.write_text("new")
    assert raised.value.errno == code
    assert raised.value.filename == str(path)
    assert path.read_text() == "old"


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no named pipes in folders")
def test_what_is_no_file_is_not_replaced(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)  # as /dev/null is no file, which a test must not put at risk
    with pytest.raises(OSError, match="pipe is a device or pipe"), whole_file(pipe):
        raise AssertionError("nothing was to be written")
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    with pytest.raises(OSError, match="is a folder"), whole_file(tmp_path):
        raise AssertionError("nothing was to be written")
