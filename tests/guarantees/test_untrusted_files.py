"""Files of strangers: no code of theirs runs, nothing is written outside `--out`, nothing fetched.

Python's audit hooks see every file that is opened to be written, every connection, every program
that is run and every name that a pickle looks up. All commands run in one process.
"""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tendon_mj.builders import example_recording

WATCHED = """
import json, os, sys
from tendon_mj.cli import main
import tendon_mj.diagnosis, tendon_mj.view.report  # what is read while they load is not watched

FILES = ("os.remove", "os.rename", "os.mkdir", "os.rmdir", "os.link", "os.symlink", "os.chmod")
ACTS = ("socket.connect", "socket.getaddrinfo", "os.system", "os.exec", "os.posix_spawn",
        "subprocess.Popen", "pickle.find_class", "urllib.Request")
seen = []

def watch(event, arguments):
    if event == "open":
        path, mode, flags = arguments
        if isinstance(path, (str, bytes)) and flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT):
            seen.append([event, os.path.abspath(os.fsdecode(path))])
    elif event in FILES and isinstance(arguments[0], (str, bytes)):  # not a file that is open
        seen.append([event, os.path.abspath(os.fsdecode(arguments[0]))])
    elif event in ACTS:
        seen.append([event, repr(arguments)])

sys.addaudithook(watch)
told = []
for arguments in json.loads(sys.stdin.read()):
    status = main(arguments)
    told.append([status, seen[:]])
    seen.clear()
open(sys.argv[1], "w").write(json.dumps(told))
"""
CODE = "__import__('pathlib').Path('pwned').touch()"
FORMULA = "=cmd|'/c calc'!A0"
KINDS = ("nothing", "cell", "header", "comment", "unit", "source", "model", "sensor", "parameter")


def write(kind, folder):
    """A recording with code in it."""
    table = example_recording().read_text().splitlines()[:200]
    described = example_recording().with_suffix(".toml").read_text()
    if kind == "cell":
        table[5] = f"{CODE}," + table[5].split(",", 1)[1]
    elif kind == "header":
        table = [table[0] + f",{FORMULA}", *(line + ",1" for line in table[1:])]
    elif kind == "comment":
        table.insert(0, f"# {CODE}")
    elif kind == "unit":
        table[0] = table[0].replace("_N", f"_{CODE}")
    elif kind == "source":
        described = described.replace('source = "', f'source = "{{{{ {CODE} }}}} <script>')
    elif kind == "model":
        described = described.replace('"bench"', f'"{CODE}"')
    elif kind == "sensor":
        described = described.replace('"input_tension"', f'"{CODE}"')
    elif kind == "parameter":
        described += f'\n[known]\n"{CODE}" = 1.0\n'
    (folder / f"{kind}.csv").write_text("\n".join(table) + "\n")
    (folder / f"{kind}.toml").write_text(described)


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """(command, kind) → exit status, and what the command did that was watched."""
    folder = tmp_path_factory.mktemp("untrusted")
    pairs = [(command, kind) for command in ("check", "replay") for kind in KINDS]
    for kind in KINDS:
        write(kind, folder)
    jobs = [
        [c, str(folder / f"{kind}.csv"), "--out", str(folder / f"{c}_{kind}")] for c, kind in pairs
    ]
    report = folder / "report.json"
    done = subprocess.run(
        [sys.executable, "-c", WATCHED, report],
        input=json.dumps(jobs),
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert report.exists(), done.stderr
    assert not (folder / "pwned").exists()
    return folder, dict(zip(pairs, json.loads(report.read_text()), strict=True))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("command", ["check", "replay"])
def test_a_stranger_s_recording_does_nothing_but_write_its_pictures(command, kind, told):
    folder, runs = told
    status, seen = runs[command, kind]
    assert status in ((0,) if kind in ("nothing", "source") else (0, 2))
    own = folder / f"{command}_{kind}"
    caches = (Path.home() / ".cache", Path(sys.prefix), Path.home() / ".config")
    for event, what in seen:
        path = Path(what)
        assert path.is_absolute(), (event, what)  # all else than a file is a program or connection
        assert any(path.is_relative_to(one) for one in (own, *caches)), (event, what)
