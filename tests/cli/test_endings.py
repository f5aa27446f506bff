"""How commands end: a sentence with units, an example after the help, one line after Ctrl-C."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import mujoco
import pytest

from tendon_mj.cli import COMMANDS, commands, main
from tendon_mj.errors import INTERRUPTED
from tendon_mj.models import example_recording

# under a shell's & Python would leave Ctrl-C to its parent
RUN = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from tendon_mj.__main__ import main
sys.exit(main())
"""
HELP = """
import contextlib, sys
from tendon_mj.cli import main
with contextlib.suppress(SystemExit):
    main(["--help"])
print(*sys.modules, file=sys.stderr)
"""
posix = pytest.mark.skipif(sys.platform == "win32", reason="Windows has other signals and pipes")


def run(*arguments, **options):
    command = [sys.executable, *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, **options)


@pytest.mark.parametrize("width", [80, 120])
@pytest.mark.parametrize("command", COMMANDS)
def test_the_help_ends_with_an_example_that_the_command_takes(command, width, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(width))
    with pytest.raises(SystemExit) as end:
        main([command, "--help"])
    assert not end.value.code
    lines = capsys.readouterr().out.rstrip().splitlines()
    assert max(map(len, lines)) <= width
    assert not any(line.startswith("│") and not line.strip("│ ") for line in lines)  # empty rows
    assert "None" not in "\n".join(lines)
    assert "STR" not in "\n".join(lines)
    usage = lines[: lines.index("")]
    assert all(line.count("[") == line.count("]") for line in usage)  # wrapped between arguments
    assert lines[-2] == "example:"
    assert lines[-1].startswith(f"  tendon-mj {command}")
    options = set(re.findall(r"--[a-z-]+", lines[-1]))
    assert options <= set(re.findall(r"--[a-z-]+", "\n".join(lines[:-2])))


def test_the_help_of_all_commands_loads_none_of_them():
    done = run("-c", HELP)
    assert done.returncode == 0
    assert all(f"│ {command} " in done.stdout for command in COMMANDS)
    assert "tendon_mj.cli" in done.stderr.split()
    assert "tendon_mj.lab." not in done.stderr


def test_a_command_that_does_not_exist_is_refused_with_the_nearest(tmp_path, capsys):
    assert main(["diganose"]) == 2
    assert "did you mean 'diagnose'" in capsys.readouterr().err
    for name, command in (("hand.xml", "view"), ("pull.csv", "check"), ("hands", "fleet")):
        (tmp_path / name).touch()
        assert main([str(tmp_path / name)]) == 2
        assert f"did you mean tendon-mj {command} {tmp_path / name}?" in capsys.readouterr().err


def test_parameters_are_listed_with_their_units(capsys):
    assert main(["parameters", "finger", "--name", "flexor_sheath.f*"]) == 0
    rows = capsys.readouterr().out.splitlines()
    assert any({"flexor_sheath.friction", "-"} <= set(row.split()) for row in rows)
    assert main(["parameters", "finger", "--name", "flexor_sheath.mu"]) == 2
    assert "did you mean 'flexor_sheath.friction'" in capsys.readouterr().err


@posix
@pytest.mark.parametrize(
    "arguments",
    [
        ["compare"],
        ["sweep", "finger", "--parameter", "*.friction=0.1:0.2:9999", "--processes", "2"],
    ],
    ids=["compare", "sweep"],
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
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does, to worker processes too
    _, error = process.communicate()
    assert process.returncode == 130, error
    assert error.startswith("tendon-mj: interrupted")
    assert error.count("\n") == 1


@pytest.mark.parametrize("raised", [ValueError, mujoco.FatalError])
def test_ctrl_c_inside_mujoco_ends_in_one_line(raised, monkeypatch, capsys):
    def interrupted(given):
        raise raised(f"plugin tendon_mj.sheath: {INTERRUPTED}")

    monkeypatch.setattr(commands, "_run_command", interrupted)
    assert commands.main(["compare"]) == 130
    assert capsys.readouterr().err.startswith("tendon-mj: interrupted")


def test_a_terminal_without_the_letters_of_units_loses_no_result(tmp_path):
    arguments = ["replay", str(example_recording()), "--out", str(tmp_path)]
    environment = {**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}
    done = run("-m", "tendon_mj", *arguments, env=environment)
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "result.json").exists()


@pytest.mark.parametrize(
    ("arguments", "value"),
    [
        (["replay", ""], "empty"),
        (["compare", "--out", ""], "empty"),
        (["check", "s\udcff.csv", "--out", "OUT"], "\\udcff"),
        (["replay", ".", "--out", "OUT"], ". is a folder"),
        (["render", "finger", "--size", "64x", "--out", "OUT"], "64x"),
        (["replay", "nothing.csv", "--out", "OUT"], "nothing.csv"),
        (["render", "bensch", "--out", "OUT"], "did you mean 'bench'"),
    ],
)
def test_a_refusal_is_one_line_with_the_argument(arguments, value, tmp_path, capsys):
    out = str(tmp_path / "out")
    assert main([out if word == "OUT" else word for word in arguments]) == 2
    error = capsys.readouterr().err
    assert error.startswith("tendon-mj: ")
    assert error.count("\n") == 1
    assert value in error
