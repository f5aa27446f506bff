"""The folder of a command: one run at a time, nothing stale, nothing half-written."""

import errno
import json
import os
import subprocess
import sys

import filelock
import pytest

from tendon_mj.cli import Output, main
from tendon_mj.errors import InvalidValueError
from tendon_mj.models import example_recording

HOLD = """
import sys
from pathlib import Path
from tendon_mj.cli.output import Output
output = Output(Path(sys.argv[1]))
print("open", flush=True)
sys.stdin.read()
"""


def finished(folder):
    output = Output(folder)
    for name in ("report.html", "clip.mp4", "model.xml", "simulated.csv"):
        output.add(folder / name).write_text("earlier")
    output.result({"error": 1.0})
    output.close()


def test_a_run_that_fails_leaves_no_result_of_an_earlier_one(tmp_path):
    finished(tmp_path)
    Output(tmp_path)  # and nothing more
    assert not [p for p in tmp_path.iterdir() if p.suffix in (".json", ".html", ".mp4")]


@pytest.mark.parametrize("below", ["", "sub", "sub/folder"])
def test_a_folder_that_is_or_lies_in_a_file_is_refused_with_the_file(below, tmp_path):
    file = tmp_path / "file"
    file.write_text("mine")
    with pytest.raises(InvalidValueError, match=f"--out .*{file} is a file; it must be a folder"):
        Output(file / below)
    assert file.read_text() == "mine"


def test_what_the_next_run_may_read_stays(tmp_path):
    finished(tmp_path)
    Output(tmp_path)
    assert (tmp_path / "model.xml").read_text() == "earlier"
    assert (tmp_path / "simulated.csv").read_text() == "earlier"


def test_files_of_others_stay(tmp_path):
    (tmp_path / "photo.png").write_text("mine")
    beside = tmp_path / "beside"
    beside.mkdir()
    (tmp_path / "kept.png").write_text("mine")
    listed = {"files": ["../kept.png", str(tmp_path / "photo.png"), 3, "none.png"]}
    (beside / "result.json").write_text(json.dumps(listed))
    Output(beside)
    assert (tmp_path / "kept.png").exists()
    assert (tmp_path / "photo.png").exists()


@pytest.mark.parametrize(
    "name", ["\x00.png", "\ud800.png", "a" * 5000 + ".png", "sub.png", "", ".", "/.png", ".png"]
)
def test_names_that_no_file_has_are_passed_over(name, tmp_path):
    (tmp_path / "sub.png").mkdir()
    (tmp_path / "old.png").write_text("earlier")
    (tmp_path / "result.json").write_text(json.dumps({"files": [name, "old.png"]}))
    Output(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == [".lock", "sub.png"]


def test_no_file_that_was_given_is_removed_as_a_result_of_an_earlier_run(tmp_path):
    picture, listed = tmp_path / "s.png", tmp_path / "result.json"
    picture.write_text("read by this command")
    listed.write_text(json.dumps({"files": ["old.png", "s.png"]}))
    (tmp_path / "old.png").write_text("earlier")
    for given in (picture, tmp_path / "sub" / ".." / "s.png"):
        (tmp_path / "sub").mkdir(exist_ok=True)
        with pytest.raises(
            InvalidValueError, match=r"s\.png there would be removed, as result\.js"
        ):
            Output(tmp_path, given=[given])
    assert picture.read_text() == "read by this command"
    assert listed.exists()
    assert (tmp_path / "old.png").exists()


@pytest.mark.parametrize("text", ["", "{", "[]", '{"files": 3}', "\xff", "[" * 100_000])
def test_a_result_of_something_else_is_replaced(tmp_path, text):
    (tmp_path / "result.json").write_text(text, encoding="latin-1")
    output = Output(tmp_path)
    output.result({"error": 2.0})
    assert json.loads((tmp_path / "result.json").read_text())["error"] == 2.0


def test_another_run_in_the_same_folder_is_refused(tmp_path):
    with subprocess.Popen(
        [sys.executable, "-c", HOLD, str(tmp_path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as other:
        assert other.stdout.readline() == "open\n"
        with pytest.raises(InvalidValueError, match="another run is writing there"):
            Output(tmp_path)
        other.kill()  # a killed run holds no folder
        other.wait()
        Output(tmp_path)


@pytest.mark.parametrize(
    ("arguments", "before"),
    [
        (["replay", ""], "replay"),
        (["compare", "--out", ""], "--out"),
        (["simulate", "finger", "--model", ""], "--model"),
        (["compare", "--out="], "--out"),
        (["simulate", "finger", "--model=", "--no-clip"], "--model"),
    ],
)
def test_an_empty_argument_is_refused(arguments, before, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # which an empty --out would be
    assert main(arguments) == 2
    assert f"the argument after {before} is empty" in capsys.readouterr().err


@pytest.mark.parametrize(
    "arguments",
    [
        ["render", "bensch"],
        ["render", "bench", "--size", "wide"],
        ["render", "bench", "--camera", "top"],
        ["simulate", "finger", "--motion", "prss"],
        ["check"],
        ["check", "nothing.csv"],
        ["replay", "."],
        ["diagnose", "nothing.csv", "--next", "nothing.toml"],
    ],
)
def test_a_command_that_is_refused_leaves_no_result_of_an_earlier_run(arguments, tmp_path):
    finished(tmp_path)
    assert main([*arguments, "--out", str(tmp_path)]) == 2
    assert not (tmp_path / "result.json").exists()
    assert not (tmp_path / "report.html").exists()


@pytest.mark.parametrize("name", ["model.xml", "0_curve.csv", "result.json", ".lock"])
def test_no_file_that_was_given_is_written_over(name, tmp_path):
    finished(tmp_path)
    file, link = tmp_path / name, tmp_path / "link"
    file.write_text("mine")
    link.symlink_to(file)
    writes = ("model.xml", "[0-9]*.csv")
    for given in (file, str(file), tmp_path / "none" / ".." / name, link):
        before = {path: path.read_bytes() for path in tmp_path.iterdir()}
        (tmp_path / "none").mkdir()
        with pytest.raises(InvalidValueError, match=rf"--out .*: {name} there would be written"):
            Output(tmp_path, writes=writes, given=[None, "none", given])
        (tmp_path / "none").rmdir()
        assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_given_file_of_another_name_or_folder_is_no_hindrance(tmp_path):
    for path in (tmp_path / "model.xml", tmp_path / "out" / "my_model.xml"):
        path.parent.mkdir(exist_ok=True)
        path.write_text("mine")
        Output(tmp_path / "out", writes=("model.xml",), given=[path]).close()
        assert path.read_text() == "mine"


def test_a_replay_writes_over_no_recording_that_it_reads(tmp_path, capsys):
    arguments = ["replay", "--out", str(tmp_path)]
    assert main([*arguments, str(example_recording())]) == 0
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    read = [tmp_path / f"simulated_{k}" for k in (0, 1)]
    for given in (*read, *(path.with_suffix(".csv") for path in read)):
        assert main([*arguments, str(given)]) == 2
    described = ["--description", str(tmp_path / "simulated_1.toml")]
    assert main([*arguments, str(example_recording()), *described]) == 2
    assert "would be written over" in capsys.readouterr().err
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no named pipes in folders")
def test_a_pipe_in_place_of_the_result_is_refused_and_not_opened(tmp_path):
    os.mkfifo(tmp_path / "result.json")
    with pytest.raises(InvalidValueError, match=r"result\.json there is a folder, device or pipe"):
        Output(tmp_path)


def test_a_folder_that_cannot_be_written_to_is_named(tmp_path, monkeypatch):
    def refuse(_):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS), str(tmp_path / ".lock"))

    monkeypatch.setattr(filelock.FileLock, "_acquire", refuse)
    with pytest.raises(InvalidValueError, match="nothing can be written there") as raised:
        Output(tmp_path)
    assert f"--out {tmp_path}" in str(raised.value)
    assert ".lock" not in str(raised.value)


def test_a_link_to_nowhere_is_refused_as_out_by_name(tmp_path):
    link = tmp_path / "out"
    link.symlink_to(tmp_path / "none" / "there")
    with pytest.raises(InvalidValueError, match=r"--out .*out is a link to .*there, which is not"):
        Output(link)
