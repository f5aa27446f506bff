"""How commands end: a sentence with units, an example after the help, one line after Ctrl-C."""

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tendon_mj.cli import Output, console, main, progress_bar
from tendon_mj.cli.help import documented, example
from tendon_mj.cli.main import COMMANDS
from tendon_mj.cli.output import print_table
from tendon_mj.errors import EngineError
from tendon_mj.models import example_recording

# under a shell's & Python would leave Ctrl-C to its parent
RUN = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from tendon_mj.__main__ import main
sys.exit(main())
"""
WIDTH = 100
ARM = (
    "<mujoco><worldbody><site name='a'/><site name='b' pos='.1 0 .1'/><body pos='.2 0 0'>"
    "<joint name='j' axis='0 1 0'/><geom size='.01'/><site name='c'/></body></worldbody>"
    "<tendon><spatial name='t'><site site='a'/><site site='b'/><site site='c'/></spatial>"
    "</tendon><actuator><motor tendon='t'/></actuator></mujoco>"
)


WARN = """
import sys, warnings
from tendon_mj.cli.main import COMMANDS, main
def told() -> None:
    '''Do it.

    Example:
        tendon-mj told
    '''
    warnings.warn("not solved\\nin one step", RuntimeWarning)
COMMANDS["told"] = told
sys.exit(main(["told"]))
"""


def test_a_warning_of_python_is_one_line_without_its_place_in_the_code():
    ended = subprocess.run([sys.executable, "-c", WARN], capture_output=True, text=True, check=True)
    assert ended.stderr == "warning: not solved; in one step\n"


@pytest.mark.parametrize("command", COMMANDS)
def test_the_help_ends_with_an_example_that_the_command_takes(command, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(WIDTH))
    with pytest.raises(SystemExit) as end:
        main([command, "--help"])
    assert not end.value.code
    lines = capsys.readouterr().out.rstrip().splitlines()
    assert max(map(len, lines)) <= WIDTH
    assert lines[-2] == "example:"
    assert lines[-1].startswith(f"  tendon-mj {command}")
    options = set(re.findall(r"--[a-z-]+", lines[-1]))
    assert options <= set(re.findall(r"--[a-z-]+", "\n".join(lines[:-2])))


def command(one: int = 0) -> None:
    """Do it.

    Args:
        one: begins here
            and goes on.

    Example:
        tendon-mj command
    """


def test_help_joins_the_lines_of_an_argument_and_leaves_the_example_out():
    assert example(command) == "tendon-mj command"
    same = documented(command)
    assert "begins here and goes on." in same.__doc__
    assert "Example" not in same.__doc__
    assert same.__annotations__ == command.__annotations__


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (
            ["replay", str(example_recording())],
            r"misses input_tension_N by \d\d\.\d mN \(without friction \d\.\d+ N\), .* rms\.$",
        ),
        (
            ["simulate", "finger", "--motion", "tap", "--no-clip"],
            r"With friction as in the model the flexor loses .*%.* presses with up to \d\.\d\d N",
        ),
    ],
    ids=["replay", "simulate"],
)
def test_the_last_line_says_what_came_out(arguments, said, tmp_path, capsys):
    assert main([*arguments, "--out", str(tmp_path)]) == 0
    last = capsys.readouterr().out.rstrip().splitlines()[-1]
    assert re.search(said, last), last
    assert last.endswith(".")


def test_attach_ends_with_what_friction_does(tmp_path, capsys):
    (tmp_path / "arm.xml").write_text(ARM)
    arguments = ["--tendon", "t", "--friction", "0.2", "--out", str(tmp_path / "new.xml")]
    assert main(["attach", str(tmp_path / "arm.xml"), *arguments]) == 0
    last = capsys.readouterr().out.rstrip().splitlines()[-1]
    share = round(100 * (1 - np.exp(-0.2 * np.pi / 2)))
    assert f"t loses most by friction, {share}% of its tension at qpos0" in last
    assert "1.57 to 1.57 rad" in last


def test_the_sentence_comes_after_the_files(tmp_path):
    output = Output(tmp_path)
    output.result({"force_N": 1.0})
    with console.capture() as printed:
        output.close("The force is 1 N.")
    assert printed.get().splitlines()[-1] == "The force is 1 N."


def test_progress_says_how_much_time_is_left():
    with console.capture() as printed, progress_bar() as report:
        report("simulate", 1, 2)
    assert "elapsed" in printed.get()
    assert "to go" in printed.get()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT between processes")
@pytest.mark.parametrize(
    "arguments",
    [
        ["compare"],
        ["diagnose", str(example_recording()), "--no-sysid"],
        ["sweep", "finger", "--parameter", "*.friction=0.1:0.2:9999", "--processes", "2"],
    ],
    ids=["compare", "diagnose", "sweep"],
)
def test_ctrl_c_ends_in_one_line(arguments, tmp_path):
    out = Path(tmp_path) / "out"
    process = subprocess.Popen(
        [sys.executable, "-c", RUN, *arguments, "--out", str(out)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    while not out.exists() and process.poll() is None:  # it has begun when its folder is there
        time.sleep(0.05)
    time.sleep(1.0)
    for _ in range(3):  # of which the first one counts
        with contextlib.suppress(ProcessLookupError):  # it has ended
            os.killpg(process.pid, signal.SIGINT)  # as a terminal does, to worker processes too
        time.sleep(0.01)
    _, error = process.communicate()
    assert process.returncode == 130, error
    assert (
        error
        == "tendon-mj: interrupted; the files written so far are whole, the others are missing\n"
    )


def test_ctrl_c_while_the_commands_load_is_one_line(tmp_path):
    script = (
        "import runpy, sys; sys.argv[0] = 'x'; runpy.run_module('tendon_mj', run_name='__main__')"
    )
    (tmp_path / "tyro.py").write_text("raise KeyboardInterrupt")  # loads before the commands do
    path = os.pathsep.join([str(tmp_path), *sys.path])
    ended = subprocess.run(
        [sys.executable, "-c", script],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (ended.returncode, ended.stderr) == (130, "tendon-mj: interrupted; nothing was begun\n")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows tells a pipe's end otherwise")
@pytest.mark.parametrize("lines", [0, 1])  # that are read before
@pytest.mark.parametrize("buffered", ["", "1"])  # as Python has it for a pipe, and line by line
@pytest.mark.parametrize("arguments", [("render", "--help"), ("--help",), ("--version",)])
def test_a_reader_that_has_enough_ends_a_command_in_silence(arguments, buffered, lines):
    process = subprocess.Popen(
        [sys.executable, "-m", "tendon_mj", *arguments],
        env={**os.environ, "PYTHONUNBUFFERED": buffered},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    for _ in range(lines):
        process.stdout.readline()
    process.stdout.close()
    process.stdout = None
    assert process.communicate()[1] == b""
    assert process.returncode == 0


@pytest.mark.skipif(sys.platform == "win32", reason="Windows tells a pipe's end otherwise")
def test_a_command_whose_reader_has_enough_does_its_work(tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-m", "tendon_mj", "check", str(example_recording()), "--out", tmp_path],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    process.stdout.close()
    process.stdout = None
    assert process.communicate()[1] == b""
    assert process.returncode == 0
    files = json.loads((tmp_path / "result.json").read_text("utf-8"))["files"]
    assert files
    assert all((tmp_path / file).is_file() for file in files)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows tells a pipe's end otherwise")
def test_a_refusal_that_nobody_reads_is_one():
    process = subprocess.Popen(
        [sys.executable, "-m", "tendon_mj", "replay", "nothing.csv"],
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    process.stdout.close()
    assert process.wait() == 2


@pytest.mark.skipif(sys.platform == "win32", reason="there is no POSIX shell")
@pytest.mark.parametrize(("words", "status"), [("sweep bench x", 2), ("--help", 0), ("init b", 2)])
def test_a_closed_output_is_none(words, status, tmp_path):
    command = f"exec '{sys.executable}' -m tendon_mj {words} >&-"
    ended = subprocess.run(
        ["sh", "-c", command], cwd=tmp_path, stderr=subprocess.PIPE, text=True, check=False
    )
    assert ended.returncode == status
    assert "Traceback" not in ended.stderr


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no full device here")
@pytest.mark.parametrize("buffered", ["", "1"])
@pytest.mark.parametrize("arguments", [("--version",), ("render", "--help"), ("init", "bench")])
def test_an_output_that_is_full_is_named_in_a_line(arguments, buffered, tmp_path):
    with Path("/dev/full").open("w") as full:
        ended = subprocess.run(
            [sys.executable, "-m", "tendon_mj", *arguments],
            env={**os.environ, "PYTHONUNBUFFERED": buffered},
            cwd=tmp_path,
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert ended.stderr == "tendon-mj: the standard output: No space left on device\n"
    assert ended.returncode == 2


@pytest.mark.parametrize(
    "name", ["t", "flexor_digit", "flexor_digitorum_profundus_of_the_index_finger"]
)
@pytest.mark.parametrize("width", [80, WIDTH])
def test_no_name_is_cut(name, width, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(console, "_width", width)
    arm = ARM.replace("'t'", f"'{name}'").replace("<motor", f"<motor name='m_{name}'")
    (tmp_path / "arm.xml").write_text(arm)
    arguments = ["--tendon", "*", "--friction", "0.2", "--out", str(tmp_path / "new.xml")]
    assert main(["attach", str(tmp_path / "arm.xml"), *arguments]) == 0
    words = capsys.readouterr().out.replace("'", " ").split()
    assert {name, f"m_{name}"} <= set(words)
    assert not [word for word in words if word.endswith("…") and word != "…"]


@pytest.mark.parametrize("width", [60, 72, WIDTH])
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


def test_an_error_on_the_way_out_after_ctrl_c_is_no_refusal(monkeypatch, capsys):
    def interrupted() -> None:
        """Write a clip."""
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt:
            try:
                raise RuntimeError("ffmpeg is gone")
            except RuntimeError as error:
                raise EngineError("no clip") from error

    monkeypatch.setitem(COMMANDS, "render", interrupted)
    assert main(["render"]) == 130
    assert capsys.readouterr().err.startswith("tendon-mj: interrupted")


@pytest.mark.skipif(sys.platform == "win32", reason="its files' names are text")
@pytest.mark.parametrize("command", ["replay", "check", "diagnose", "fleet", "sweep"])
def test_a_name_that_is_no_text_is_refused_before_anything_is_computed(command, capsys):
    assert main([command, "s\udcff.csv"]) == 2
    assert capsys.readouterr().err == (
        "tendon-mj: argument 's\\udcff.csv': its bytes are not UTF-8; rename the file\n"
    )


@pytest.mark.parametrize("command", ["replay", "check", "diagnose"])
@pytest.mark.parametrize("path", [".", "/", ".."])
def test_a_folder_is_no_recording(command, path, capsys, tmp_path):
    assert main([command, path, "--out", str(tmp_path)]) == 2
    assert "is a folder; give the path of a recording's table" in capsys.readouterr().err


def test_a_terminal_without_the_letters_of_units_loses_no_result(tmp_path):
    arguments = ["replay", str(example_recording()), "--out", str(tmp_path)]
    environment = {**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}
    done = subprocess.run(
        [sys.executable, "-m", "tendon_mj", *arguments], env=environment, capture_output=True
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == b""
    assert (tmp_path / "result.json").exists()


@pytest.mark.parametrize("size", ["9" * 5000 + "x64", "64", "64x", "-1x64", "1e3x64"])
def test_a_size_that_is_none_is_refused(size, capsys, tmp_path):
    assert main(["render", "finger", "--size", size, "--out", str(tmp_path)]) == 2
    assert "give width x height in pixels" in capsys.readouterr().err


def test_results_that_are_tables_go_with_the_result_that_lists_them(tmp_path):
    first = Output(tmp_path, tables=("rigs.csv",))
    for name in ("rigs.csv", "simulated.csv"):
        first.add(tmp_path / name).write_text("a\n")
    first.result({})
    first.close()
    Output(tmp_path, tables=("rigs.csv",))
    assert {path.name for path in tmp_path.glob("*.csv")} == {"simulated.csv"}
