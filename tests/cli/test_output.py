"""The folder of a command: one run at a time, nothing stale, nothing half-written."""

import json
import subprocess
import sys

import pytest

from tendon_mj.cli import main
from tendon_mj.cli.output import Output
from tendon_mj.errors import InvalidValueError

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


@pytest.mark.parametrize("text", ["", "{", "[]", '{"files": 3}', "\xff"])
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


def test_a_link_to_nowhere_is_refused_as_out_by_name(tmp_path):
    link = tmp_path / "out"
    link.symlink_to(tmp_path / "none" / "there")
    with pytest.raises(InvalidValueError, match=r"--out .*out is a link to .*there, which is not"):
        Output(link)
