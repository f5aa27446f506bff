"""The folder of a command: one run at a time, nothing stale, nothing that was given overwritten."""

import json
import subprocess
import sys

import pytest

from tendon_mj.cli import Output, console, main
from tendon_mj.cli.output import print_table
from tendon_mj.errors import InvalidValueError
from tendon_mj.models import example_recording

HOLD = """
import sys
from pathlib import Path
from tendon_mj.cli import Output
output = Output(Path(sys.argv[1]))
print("open", flush=True)
sys.stdin.read()
"""


def finished(folder):
    output = Output(folder, tables=("rigs.csv",))
    for name in ("report.html", "clip.mp4", "rigs.csv", "model.xml", "simulated.csv"):
        output.add(folder / name).write_text("earlier")
    output.result({"error": 1.0, "list": (float("nan"), 2)})
    output.close()


def contents(folder):
    return {path: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def refusal(folder, **options):
    before = contents(folder) if folder.is_dir() else {}
    with pytest.raises(InvalidValueError) as refused:
        Output(folder, **options)
    assert before == (contents(folder) if folder.is_dir() else {})
    assert f"--out {folder}" in str(refused.value)
    return str(refused.value)


def test_a_result_is_plain_numbers_and_the_files_next_to_it(tmp_path):
    finished(tmp_path)
    result = json.loads((tmp_path / "result.json").read_text())
    assert (result["error"], result["list"]) == (1.0, [None, 2])
    assert result["files"] == sorted(result["files"])
    assert len(result["files"]) == 5


def test_a_new_run_removes_the_earlier_result_and_keeps_the_files_that_it_may_read(tmp_path):
    finished(tmp_path)
    (tmp_path / "photo.png").write_text("mine")
    Output(tmp_path, tables=("rigs.csv",))
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {".lock", "model.xml", "simulated.csv", "photo.png"}


@pytest.mark.parametrize("text", ["{", '{"files": ["../a.png", 3, "none.png", "sub.png", ""]}'])
def test_a_result_of_something_else_is_replaced_and_nothing_else_removed(tmp_path, text):
    out = tmp_path / "out"
    (out / "sub.png").mkdir(parents=True)
    (tmp_path / "a.png").write_text("mine")
    (out / "result.json").write_text(text)
    Output(out).result({"error": 2.0})
    assert json.loads((out / "result.json").read_text())["error"] == 2.0
    assert (tmp_path / "a.png").exists()


def test_another_run_in_the_same_folder_is_refused(tmp_path):
    with subprocess.Popen(
        [sys.executable, "-c", HOLD, str(tmp_path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as other:
        assert other.stdout.readline() == "open\n"
        assert "another run" in refusal(tmp_path)
        other.kill()  # a killed run holds no folder
        other.wait()
        Output(tmp_path)


@pytest.mark.parametrize("below", ["", "sub", "sub/folder"])
def test_a_folder_that_cannot_be_made_is_refused(below, tmp_path):
    (tmp_path / "file").write_text("mine")
    assert "not a folder" in refusal(tmp_path / "file" / below)
    assert (tmp_path / "file").read_text() == "mine"


@pytest.mark.parametrize("name", ["model.xml", "0_curve.csv", "result.json"])
def test_no_file_that_was_given_is_overwritten(name, tmp_path):
    finished(tmp_path)
    file, link = tmp_path / name, tmp_path / "link"
    file.write_text("mine")
    link.symlink_to(file)
    (tmp_path / "sub").mkdir()
    for given in (file, str(file), tmp_path / "sub" / ".." / name, link):
        options = {"writes": ("model.xml", "[0-9]*.csv"), "given": [None, "none", given]}
        assert name in refusal(tmp_path, **options)


def test_a_given_file_of_another_name_or_folder_is_allowed(tmp_path):
    for path in (tmp_path / "model.xml", tmp_path / "out" / "my_model.xml"):
        path.parent.mkdir(exist_ok=True)
        path.write_text("mine")
        Output(tmp_path / "out", writes=("model.xml",), given=[path]).close()
        assert path.read_text() == "mine"


def test_a_replay_overwrites_no_recording_that_it_reads(tmp_path, capsys):
    arguments = ["replay", "--out", str(tmp_path)]
    assert main([*arguments, str(example_recording())]) == 0
    before = contents(tmp_path)
    read = [tmp_path / f"simulated_{k}" for k in (0, 1)]
    for given in (*read, *(path.with_suffix(".csv") for path in read)):
        assert main([*arguments, str(given)]) == 2
    described = ["--description", str(tmp_path / "simulated_1.toml")]
    assert main([*arguments, str(example_recording()), *described]) == 2
    assert "simulated_1.toml" in capsys.readouterr().err
    assert contents(tmp_path) == before


@pytest.mark.parametrize(
    "arguments",
    [
        ["render", "bensch"],
        ["render", "bench", "--size", "wide"],
        ["simulate", "finger", "--motion", "prss"],
        ["check"],
        ["check", "nothing.csv"],
        ["diagnose", "nothing.csv", "--next", "nothing.toml"],
    ],
)
def test_a_command_that_is_refused_leaves_no_result_of_an_earlier_run(arguments, tmp_path):
    finished(tmp_path)
    assert main([*arguments, "--out", str(tmp_path)]) == 2
    assert not (tmp_path / "result.json").exists()
    assert not (tmp_path / "report.html").exists()


def test_names_in_brackets_are_printed_as_they_are():
    with console.capture() as printed:
        console.print("elbow[left] [/left] :smile: [measured]")
    assert printed.get() == "elbow[left] [/left] :smile: [measured]\n"


@pytest.mark.parametrize("width", [60, 72, 100])
def test_a_table_has_every_word_whole(width, monkeypatch):
    monkeypatch.setattr(console, "_width", width)
    names = ["hand", "index_finger_of_the_left_hand", "thumb"]
    rows = [(name, f"{k} … {k + 1}", "left as it was") for k, name in enumerate(names)]
    with console.capture() as printed:
        print_table(("model", "from … to", "what was done"), rows)
    words = printed.get().split()
    assert set(names) <= set(words)
    assert words.count("left") == words.count("as") == words.count("it") == len(rows)
    assert max(map(len, printed.get().splitlines())) <= width
